"""Who may open the page, and who may not."""

import asyncio
import shutil
import ssl
import subprocess

import aiohttp
import pytest

from ground_page import browser, page
from hand_station import HandStation
from ross_payload.ground.errors import GroundError
from ross_payload.ground.web import security
from ross_payload.ground.web.security import TRIES, WAIT, Gate, new_token, out_of_date, read_token, tls_of

TOKEN = "open-sesame-open-sesame"  # noqa: S105

needs_openssl = pytest.mark.skipif(shutil.which("openssl") is None, reason="apt install openssl")


async def status(client, url, **options):
    async with client.get(url, allow_redirects=False, **options) as answer:
        await answer.read()
        return answer.status


async def test_without_the_token_nothing_is_shown():
    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession() as client:
        base = served.url
        async with client.get(base) as answer:
            assert answer.status == 401
            assert 'name="token"' in await answer.text()
        for path in ("assets/connection.js", "live", "flights", "login", "nothing"):
            assert await status(client, base + path) == 401
        async with client.post(f"{base}flights?name=a.tlog", data=b"x") as answer:
            assert answer.status == 401
        with pytest.raises(aiohttp.WSServerHandshakeError):
            async with browser(base):
                pass


async def test_the_token_in_the_address_becomes_a_cookie_that_no_script_reads_and_leaves_the_address():
    async with page(HandStation(), token=TOKEN) as served:
        jar = aiohttp.CookieJar(unsafe=True)
        async with aiohttp.ClientSession(cookie_jar=jar) as client:
            async with client.get(f"{served.url}?token={TOKEN}", allow_redirects=False) as answer:
                assert answer.status == 303
                assert answer.headers["Location"] == "/"
                cookie = answer.headers["Set-Cookie"]
                assert "HttpOnly" in cookie
                assert "SameSite=Strict" in cookie
                assert TOKEN not in cookie
            base = served.url
            assert await status(client, base) == 200
            async with client.ws_connect(f"{base}live") as socket:
                assert (await socket.receive_json())["type"] == "hello"


async def test_the_token_in_the_form_opens_the_page_and_a_wrong_one_does_not():
    jar = aiohttp.CookieJar(unsafe=True)
    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession(cookie_jar=jar) as client:
        login = served.url + "login"
        async with client.post(login, data={"token": "wrong"}) as answer:
            assert answer.status == 401
            assert "The token is wrong." in await answer.text()
        async with client.post(login, data={"token": TOKEN}) as answer:
            assert answer.status == 200
            assert answer.url.path == "/"


async def test_nobody_serves_the_page_to_others_without_a_token():
    with pytest.raises(GroundError, match="reachable from other computers: expected a token, got none"):
        async with page(HandStation(), host="0.0.0.0"):  # noqa: S104
            pass


async def test_whoever_guesses_waits_even_with_the_right_token():
    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession() as client:
        base = served.url
        for _ in range(TRIES):
            assert await status(client, f"{base}?token=guess") == 401
        async with client.get(f"{served.url}?token={TOKEN}", allow_redirects=False) as answer:
            assert answer.status == 429
            assert 0 < int(answer.headers["Retry-After"]) <= WAIT


IMAGE = {"Sec-Fetch-Mode": "no-cors", "Sec-Fetch-Dest": "image"}
LINK = {"Sec-Fetch-Mode": "navigate", "Sec-Fetch-Dest": "document", "Sec-Fetch-User": "?1"}


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
@pytest.mark.parametrize("kind", [IMAGE, LINK])
async def test_another_site_cannot_lock_out_the_login(site, kind):
    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession() as client:
        headers = {"Sec-Fetch-Site": site, **kind}
        for _ in range(2 * TRIES):
            refused = await status(client, f"{served.url}?token=guess", headers=headers)
            assert refused == (403 if kind is IMAGE else 401)
        assert await status(client, f"{served.url}?token={TOKEN}") == 303


async def test_another_site_cannot_lock_out_the_form_where_browsers_do_not_say_who_asks():
    """As over plain HTTP from another computer: an image of another site looks like an address that was typed."""

    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession() as client:
        for _ in range(TRIES):
            assert await status(client, f"{served.url}?token=guess") == 401
        async with client.get(f"{served.url}?token={TOKEN}") as answer:
            assert answer.status == 429
            assert f'value="{TOKEN}"' in await answer.text()
        origin = {"Origin": served.url.rstrip("/")}
        form = {"data": {"token": TOKEN}, "headers": origin, "allow_redirects": False}
        async with client.post(f"{served.url}login", **form) as answer:
            assert answer.status == 303


async def test_whoever_guesses_in_the_form_waits_there_too():
    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession() as client:
        told = []
        for token in ["guess"] * TRIES + [TOKEN]:
            async with client.post(f"{served.url}login", data={"token": token}) as answer:
                told.append(answer.status)
        assert told == [401] * TRIES + [429]


async def test_a_form_that_another_site_sends_is_not_tried():
    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession() as client:
        for origin in ["http://evil.example", "null"] * TRIES:
            async with client.post(f"{served.url}login", data={"token": "guess"}, headers={"Origin": origin}) as answer:
                assert answer.status == 403
        async with client.post(f"{served.url}login", data={"token": TOKEN}, allow_redirects=False) as answer:
            assert answer.status == 303


async def test_a_lock_out_spares_whoever_is_logged_in():
    jar = aiohttp.CookieJar(unsafe=True)
    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession(cookie_jar=jar) as inside:
        assert await status(inside, f"{served.url}?token={TOKEN}") == 303
        async with aiohttp.ClientSession() as guesser:
            for _ in range(2 * TRIES):
                await status(guesser, f"{served.url}?token=guess")
                async with guesser.post(f"{served.url}login", data={"token": "guess"}):
                    pass
        assert await status(inside, served.url) == 200
        assert await status(inside, f"{served.url}?token=guess") == 303
        async with inside.ws_connect(f"{served.url}live") as socket:
            assert (await socket.receive_json())["type"] == "hello"


async def test_a_link_of_another_site_leads_to_the_form_and_what_it_brings_is_no_markup():
    async with page(HandStation(), token=TOKEN) as served, aiohttp.ClientSession() as client:
        led = {"headers": {"Sec-Fetch-Site": "cross-site", **LINK}, "allow_redirects": False}
        async with client.get(f"{served.url}?token={TOKEN}", **led) as answer:
            assert answer.status == 401
            assert f'value="{TOKEN}"' in await answer.text()
        async with client.get(f"{served.url}?token=%22%3E%3Cscript%3Ex", **led) as answer:
            assert "<script>" not in await answer.text()


async def test_another_site_embeds_nothing_and_downloads_nothing():
    async with page(HandStation()) as served, aiohttp.ClientSession() as client:
        for path in ("assets/app.js", "recordings", "recordings/0001.zip", "live", ""):
            headers = {"Sec-Fetch-Site": "cross-site", **IMAGE}
            assert await status(client, served.url + path, headers=headers) == 403
        assert await status(client, served.url, headers={"Sec-Fetch-Site": "cross-site", **LINK}) == 200
        assert await status(client, served.url, headers={"Sec-Fetch-Site": "same-origin", **IMAGE}) == 200


def test_a_guess_is_forgotten_after_the_wait_and_addresses_do_not_fill_the_memory():
    gate = Gate(TOKEN)
    for _ in range(TRIES):
        assert not gate.tried("guess", "10.0.0.1", now=0.0)
    assert gate.tried(TOKEN, "10.0.0.2", now=0.0)
    assert not gate.tried(TOKEN, "10.0.0.1", now=WAIT - 0.1)
    assert gate.tried(TOKEN, "10.0.0.1", now=WAIT)
    for number in range(2 * security.MAX_ADDRESSES):
        gate.tried("guess", f"host {number}", now=0.0)
    assert len(gate.wrong) <= security.MAX_ADDRESSES


def test_a_cookie_is_good_for_one_token_only():
    assert Gate(TOKEN).lets_in(Gate(TOKEN).cookie)
    assert not Gate(TOKEN).lets_in(Gate("another-token-another").cookie)
    assert not Gate(TOKEN).lets_in("")
    assert not Gate(TOKEN).lets_in("é")
    assert new_token() != new_token()


async def test_a_name_that_leads_here_from_elsewhere_is_refused():
    async with page(HandStation()) as served, aiohttp.ClientSession() as client:
        port = served.url.rsplit(":", 1)[1].strip("/")
        for host in ("evil.example", f"evil.example:{port}", "127.0.0.1.evil.example", "[", "10.0.0.1"):
            assert await status(client, served.url, headers={"Host": host}) in (400, 421)
        assert await status(client, served.url, headers={"Host": f"localhost:{port}"}) == 200


async def test_a_page_of_another_origin_gets_no_socket_and_brings_no_flight():
    async with page(HandStation()) as served, aiohttp.ClientSession() as client:
        for origin in ("http://evil.example", "null", "http://127.0.0.1:1"):
            with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
                async with browser(served.url, headers={"Origin": origin}):
                    pass
            assert refused.value.status == 403
        async with client.post(f"{served.url}flights?name=a.tlog", headers={"Origin": "http://evil.example"}) as it:
            assert it.status == 403
        async with browser(served.url, headers={"Origin": served.url.strip("/")}) as one:
            await one.next("hello")


@pytest.mark.parametrize(
    "path",
    [
        "assets/../server.py", "assets/%2e%2e/server.py", "assets/..%2fserver.py", "assets/%2fetc/passwd", "assets/",
        "assets", "assets/views", "assets/views/", "assets/.hidden.js", "assets//index.html", "assets/connection.js%00",
        "assets/connection.js/x", "../pyproject.toml", "login.html",
    ],
)  # fmt: skip
async def test_no_path_leads_out_of_the_page_and_none_lists_it(path):
    async with page(HandStation()) as served:
        host, port = served.url.removeprefix("http://").strip("/").split(":")
        reader, writer = await asyncio.open_connection(host, int(port))
        writer.write(f"GET /{path} HTTP/1.1\r\nHost: {host}:{port}\r\nConnection: close\r\n\r\n".encode())
        answer = await reader.read()
        writer.close()
        await writer.wait_closed()
        assert answer.split()[1] in (b"404", b"400")
        assert b"Content-Security-Policy" in answer or answer.split()[1] == b"400"


def secret(path, text, mode=0o600):
    path.write_text(text)
    path.chmod(mode)
    return path


def test_a_token_is_read_from_a_file_that_only_its_owner_can_read(tmp_path):
    assert read_token(secret(tmp_path / "token", f"{TOKEN}\n")) == TOKEN


@pytest.mark.parametrize(
    ("text", "mode", "why"),
    [
        (TOKEN, 0o644, "expected mode 0600, got 0644"),
        ("short", 0o600, "expected a token of at least 16 ASCII characters, got 5"),
        ("", 0o600, "got 0 characters"),
        ("é" * 20, 0o600, "got 20 characters"),
    ],
)
def test_a_bad_token_file_is_told_in_one_line(tmp_path, text, mode, why):
    with pytest.raises(GroundError, match=why):
        read_token(secret(tmp_path / "token", text, mode))


def test_a_token_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(GroundError, match=r"token: No such file or directory; expected a file with a token"):
        read_token(tmp_path / "token")


CA = """[ca]
default_ca=d
[d]
database=index.txt
new_certs_dir=.
rand_serial=yes
default_md=sha256
policy=p
x509_extensions=v
[p]
commonName=supplied
[v]
subjectKeyIdentifier=hash
authorityKeyIdentifier=keyid
basicConstraints=critical,CA:true
keyUsage=digitalSignature,keyCertSign
"""


EC_KEY = ("-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1")  # made sooner than one of RSA


def certificate(folder, name="good", years=(2020, 2090)):
    """Make a certificate and its key."""

    def openssl(*words):
        subprocess.run(["openssl", *words], cwd=folder, check=True, capture_output=True)

    (folder / "ca.cnf").write_text(CA)
    (folder / "index.txt").write_text("")
    key, request, made = f"{name}.key", f"{name}.csr", f"{name}.pem"
    openssl("req", "-new", *EC_KEY, "-nodes", "-keyout", key, "-out", request, "-subj", f"/CN={name}")
    dates = [f"{year}0101000000Z" for year in years]
    openssl(
        "ca", "-batch", "-notext", "-config", "ca.cnf", "-selfsign", "-keyfile", key, "-in", request, "-out", made,
        "-startdate", dates[0], "-enddate", dates[1],
    )  # fmt: skip
    return folder / made, folder / key


@needs_openssl
async def test_the_page_speaks_tls_and_its_cookie_never_travels_without(tmp_path):
    files = certificate(tmp_path)
    tls = tls_of(*files)
    assert not out_of_date(tls, files[0])
    trusting = ssl.create_default_context(cafile=files[0])
    trusting.check_hostname = False
    trusting.verify_flags |= ssl.VerifyFlags.VERIFY_X509_PARTIAL_CHAIN
    async with page(HandStation(), token=TOKEN, tls=tls) as served, aiohttp.ClientSession() as client:
        assert served.url.startswith("https://")
        async with client.get(f"{served.url}?token={TOKEN}", ssl=trusting, allow_redirects=False) as answer:
            assert answer.status == 303
            assert "Secure" in answer.headers["Set-Cookie"]
        base = served.url
        cookie = answer.headers["Set-Cookie"].split(";")[0]
        headers = {"Cookie": cookie, "Origin": base.strip("/")}
        async with client.ws_connect(f"{base}live", ssl=trusting, headers=headers) as socket:
            assert (await socket.receive_json())["type"] == "hello"


@needs_openssl
def test_a_certificate_out_of_date_is_noticed(tmp_path):
    old, new = certificate(tmp_path, "old", (2020, 2021)), certificate(tmp_path, "new", (2080, 2090))
    assert out_of_date(tls_of(*old), old[0]) == "has expired"
    assert out_of_date(tls_of(*new), new[0]) == "is not valid yet"


@needs_openssl
def test_the_key_of_another_certificate_is_told(tmp_path):
    (one, _), (_, other) = certificate(tmp_path, "one"), certificate(tmp_path, "other")
    with pytest.raises(
        GroundError, match=r"other\.key: expected the key of .*one\.pem, got that of another certificate"
    ):
        tls_of(one, other)


def test_what_is_no_certificate_is_told(tmp_path):
    text = secret(tmp_path / "text", "hello")
    with pytest.raises(GroundError, match=r"--certificate .*nothing: expected a PEM file, got none"):
        tls_of(tmp_path / "nothing", text)
    with pytest.raises(GroundError, match=r"--key .*nothing: expected a PEM file, got none"):
        tls_of(text, tmp_path / "nothing")
    with pytest.raises(GroundError, match="expected a certificate and its key in PEM"):
        tls_of(text, None)
    with pytest.raises(GroundError, match="--key: expected --certificate with it, got none"):
        tls_of(None, text)
    assert tls_of(None, None) is None
