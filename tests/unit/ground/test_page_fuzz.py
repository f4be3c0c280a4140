"""Nonsense over HTTP and the WebSocket: refused as the client's mistake, never a fault of the page."""

import json
import socket

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from examples import examples
from ground_page import audio, on_a_thread
from hand_station import HandStation
from recording_bench import input_of, record
from ross_payload.ground.web.browser_requests import REQUESTS, on_message
from ross_payload.ground.web.browser_session import BrowserSession
from ross_payload.ground.web.flight_library import FlightLibrary
from ross_payload.ground.web.page_state import PageState
from ross_payload.sessions.catalog import Catalog
from ross_payload.sessions.session_store import SessionStore

TOKEN = "open-sesame-open-sesame"  # noqa: S105
CONTINUE = b"HTTP/1.1 100 Continue\r\n\r\n"  # comes before the answer, where a client asks for it
FORM = b"application/x-www-form-urlencoded"
EXAMPLES = 250


@pytest.fixture(scope="module", params=[None, TOKEN], ids=["open", "token"])
def served(request, tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    record(folder, [input_of(index) for index in range(20)])
    station = HandStation()
    station.say(audio())
    with on_a_thread(station, token=request.param, recordings=Catalog(SessionStore(folder))) as (port, faults):
        yield port, faults


def answer(port, request, patience=5.0):
    """Send bytes and return what comes back until the server closes, or for a while."""
    with socket.create_connection(("127.0.0.1", port), timeout=patience) as client:
        client.sendall(request)
        got = b""
        try:
            while chunk := client.recv(65536):
                got += chunk
        except (TimeoutError, ConnectionResetError):
            pass
        return got


def post(body, content_type, target=(b"POST", b"/login"), extra=()):
    lines = [
        b"%b %b HTTP/1.1" % target, b"Host: 127.0.0.1", b"Connection: close", b"Content-Type: " + content_type,
        b"Content-Length: %d" % len(body), *extra,
    ]  # fmt: skip
    return b"\r\n".join(lines) + b"\r\n\r\n" + body


@pytest.mark.parametrize(
    ("content_type", "body"),
    [
        (b"multipart/form-data", b"token=x"),
        (b"multipart/form-data; boundary=x", b"--y\r\n\r\nnothing"),
        (b"multipart/form-data; boundary=x", b"--x\r\nContent-Disposition: form-data\r\n\r\nx\r\n--x--"),
        (b"multipart/form-data; boundary=" + b"x" * 200, b""),
        (b"text/plain; charset=nonsense", b"token=x"),
        (b"\xff\xfe", b"token=x"),
        (FORM, b"&".join(b"a=b" for _ in range(1000))),
    ],
)
def test_a_form_that_is_none_is_refused_in_one_line(content_type, body):
    with on_a_thread(HandStation(), token=TOKEN) as (port, faults):
        head, _, text = answer(port, post(body, content_type)).partition(b"\r\n\r\n")
    assert head.split()[1] == b"400"
    assert b"expected" in text
    assert text.count(b"\n") == 1
    assert not faults


@pytest.mark.parametrize(
    "header",
    [
        b"Expect: \xf0\xdbv", b"Cookie: ross-80=\xff", b"Origin: http://[", b"Origin: \xff", b"Content-Encoding: gzip",
        b"Sec-Fetch-Site: \xff", b"If-None-Match: \xff", b"Transfer-Encoding: gzip",
    ],
)  # fmt: skip
@pytest.mark.parametrize("method", [b"GET", b"POST"])
def test_a_header_that_cannot_be_read_is_the_clients_mistake(served, header, method):
    port, faults = served
    told = answer(port, post(b"token=x", FORM, (method, b"/login"), (header,)))
    assert 300 <= int(told.split()[1]) < 500
    assert not faults


def test_a_form_in_a_strange_charset_is_read_all_the_same():
    with on_a_thread(HandStation(), token=TOKEN) as (port, _):
        told = answer(port, post(b"token=" + TOKEN.encode(), FORM + b"; charset=nonsense"))
    assert told.split()[1] == b"303"


raw = st.binary(max_size=40).map(lambda data: data.replace(b"\r", b"").replace(b"\n", b""))
methods = st.sampled_from([b"GET", b"HEAD", b"POST", b"DELETE", b"PUT", b"OPTIONS", b"TRACE", b"get", b"P\xffST"])
paths = st.one_of(
    st.sampled_from(
        [
            b"/", b"/login", b"/live", b"/live?you=%ff", b"/flights", b"/flights?name=a.tlog",
            b"/flights?name=%00.tlog",            b"/flights?name=%ff.tlog", b"/?token=%ff", b"/?token=x&token=y",
            b"/assets/app.js", b"/assets/%00",
            b"/recordings", b"/recordings/0001.zip", b"/recordings/0001/audio.wav", b"/recordings/%ed%a0%80.zip",
            b"/recordings/a%0d%0ab.zip", b"http://127.0.0.1:99999/", b"*", b"//", b"/%",
            b"/api/v1/payloads", b"/api/v1/payloads/1-191/orders", b"/api/v1/payloads/1-191/stop", b"/api/v1/stop",
            b"/api/v1/payloads/%ff/sources", b"/api/v1/payloads/1-191/orders/1?wait=%ff", b"/api/v1/control",
            b"/api/v1/recordings/%ed%a0%80", b"/api/v1/recordings/0001/files/%00", b"/api/v1/flights?name=%00.tlog",
            b"/api/v1/payloads/1-191/parameters/%ff?wait=0", b"/api/v1/openapi.json", b"/api/%ff",
        ]
    ),
    raw.map(lambda data: b"/" + data.replace(b" ", b"")),
)  # fmt: skip
names = st.sampled_from(
    [
        b"Cookie", b"Origin", b"Host", b"Range", b"If-None-Match", b"If-Range", b"If-Modified-Since", b"Upgrade",
        b"Sec-WebSocket-Version", b"Sec-WebSocket-Key", b"Content-Encoding", b"Transfer-Encoding", b"Content-Type",
        b"Accept-Encoding", b"Sec-Fetch-Site", b"Authorization", b"Ross-Client",
        b"User-Agent", b"Expect", b"X-Forwarded-For", b"Connection",
    ]
)  # fmt: skip
values = st.one_of(
    st.sampled_from(
        [
            b"", b"gzip", b"deflate", b"br", b"chunked", b"websocket", b"13", b"http://[", b"null", b"bytes=9-1",
            b"bytes=-1", b"bytes=0-,5-", b'"', b'W/"x"', b"cross-site", b"127.0.0.1:99999", b"127.0.0.1:\xb2", b"[",
            b"ross-80=\xff", b"ross-80=\xed\xa0\x80; a", b"multipart/form-data; boundary=x", b"100-continue",
            b"Bearer", b"Bearer \xff", b"Basic x", b"application/json",
            b"\xf0\xdbv", b"Thu, 99 Foo 0000 99:99:99 GMT", b"dGhlIHNhbXBsZSBub25jZQ==", b"Upgrade",
        ]
    ),
    raw,
)  # fmt: skip
headers = st.lists(st.tuples(names, values).map(b": ".join), max_size=5)
bodies = st.one_of(
    st.just(b""),
    raw,
    st.sampled_from([b"token=%ff", b"\x1f\x8b\x08garbage", b"5\r\nhello\r\n0\r\n\r\n", b'{"kind":"stop"}']),
)


@settings(max_examples=examples(EXAMPLES))
@given(target=st.tuples(methods, paths), extra=headers, body=bodies, kind=st.one_of(st.just(FORM), values))
@example(target=(b"GET", b"/"), extra=[b"Expect: 100-continue"], body=b"", kind=FORM)
def test_no_request_is_a_fault_of_the_page(served, target, extra, body, kind):
    port, faults = served
    told = answer(port, post(body, kind, target, extra), patience=0.5)
    assert not faults
    told = told.removeprefix(CONTINUE)
    if told:
        status = int(told.split()[1])
        assert status == 101 or 200 <= status < 500, told[:300]


@settings(max_examples=examples(EXAMPLES // 5))
@given(data=st.binary(min_size=1, max_size=200))
def test_bytes_that_are_no_request_are_no_fault_of_the_page(served, data):
    port, faults = served
    told = answer(port, data + b"\r\n\r\n", patience=0.2)
    assert not told or told.split()[1][:1] in b"1234"
    assert not faults


plain = st.one_of(
    st.none(), st.booleans(), st.integers(), st.floats(), st.text(max_size=10),
    st.sampled_from(["1-191", "9-9", "stop", "explore", "cancel", "listen", "turn", "record", "noise", "a", 10**400]),
)  # fmt: skip
keys = st.sampled_from(
    [
        "id", "order", "kind", "name", "value", "slot", "open", "close", "seek", "speed", "watch", "play", "take",
        "lat",        "lon", "heading", "number", "source", "azimuth", "on", "seconds",
    ]
)  # fmt: skip
things = st.recursive(
    plain, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(keys, inner, max_size=4), max_leaves=8
)


@settings(max_examples=examples(2 * EXAMPLES))
@given(kind=st.sampled_from(sorted(REQUESTS)), fields=st.dictionaries(keys, things, max_size=6), known=st.booleans())
def test_no_message_is_a_fault_of_the_page(kind, fields, known):
    station = HandStation()
    station.say(audio())
    with FlightLibrary(None) as flights:
        session = BrowserSession(PageState(station, flights), "0001", "test", "", lambda: None)
        on_message(session, json.dumps({**fields, **({"id": "1-191"} if known else {}), "type": kind}))
        session.due()


@settings(max_examples=examples(EXAMPLES // 5))
@given(text=st.text(max_size=100))
def test_a_text_that_is_no_message_is_refused(text):
    with FlightLibrary(None) as flights:
        session = BrowserSession(PageState(HandStation(), flights), "0001", "test", "", lambda: None)
        on_message(session, text)
        assert any('"refused"' in told for told in session.due())
