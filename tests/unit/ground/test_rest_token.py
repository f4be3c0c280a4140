"""Who may use the REST interface: the rules of the page, the token in a header, and a stop that nobody locks out."""

import pytest

from ground_page import page
from rest_program import PAYLOAD, program
from ross_payload.ground.web.security import TRIES, WAIT
from ross_protocols.mavlink.dialect import ross
from scripted_station import Scripted

TOKEN = "open-sesame-open-sesame"  # noqa: S105
ALL = ("openapi.json", "station", "payloads", "payloads/1-191/events", "nothing", "recordings", "control")


async def test_without_the_token_nothing_is_told_and_nothing_done_not_even_which_paths_there_are():
    station = Scripted()
    async with page(station, token=TOKEN) as served, program(served) as one:
        for path in ALL:
            answer = await one.get(f"/{path}")
            assert answer.refused(401, "no-token").startswith("expected Authorization: Bearer and the token, got none")
            assert answer.headers["WWW-Authenticate"] == "Bearer"
        assert (await one.ask("POST", f"{PAYLOAD}/stop")).status == 401
        assert not station.commands()


async def test_the_token_in_the_header_opens_everything_also_what_is_no_part_of_the_interface():
    async with page(Scripted(), token=TOKEN) as served, program(served, token=TOKEN) as one:
        assert (await one.get("/station")).status == 200
        assert (await one.get("/openapi.json")).told["security"] == [{"token": []}]
        async with one.session.get(f"{served.url}recordings") as answer:
            assert answer.status == 200
        async with one.session.ws_connect(f"{served.url}live") as socket:
            assert (await socket.receive_json())["type"] == "hello"


async def test_a_page_without_a_token_asks_for_none():
    async with page(Scripted()) as served, program(served) as one, program(served, token="any") as other:  # noqa: S106
        assert (await one.get("/openapi.json")).told["security"] == [{}]
        assert (await other.get("/station")).status == 200


@pytest.mark.parametrize("header", ["Bearer", "Bearer  ", f"Bearer {TOKEN}x", f"bearer x{TOKEN}", f"Bearer {TOKEN} x"])
async def test_another_token_is_a_wrong_one_and_is_not_repeated(header):
    async with page(Scripted(), token=TOKEN) as served, program(served) as one:
        answer = await one.get("/station", headers={"Authorization": header})
        assert answer.refused(401, "no-token").endswith("got another one")
        assert TOKEN not in str(answer.told)


async def test_a_header_that_is_another_s_business_is_no_guess():
    """A proxy in front of the page may ask for a password: then browsers send that with every request."""
    async with page(Scripted(), token=TOKEN) as served, program(served) as one:
        for _ in range(2 * TRIES):
            basic = await one.get("/station", headers={"Authorization": f"Basic {TOKEN}"})
            assert basic.refused(401, "no-token").startswith("expected Authorization: Bearer and the token, got none")
        assert (await one.get("/station", headers={"Authorization": f"Bearer {TOKEN}"})).status == 200
        async with one.session.get(served.url, headers={"Authorization": "Basic x"}) as answer:
            assert 'name="token"' in await answer.text()


async def guesses(one, path="/station", method="GET"):
    return [(await one.ask(method, path, headers={"Authorization": "Bearer guess"})).status for _ in range(TRIES + 1)]


async def test_whoever_guesses_waits_even_with_the_right_token_but_nobody_waits_for_a_stop():
    station = Scripted()
    async with page(station, token=TOKEN) as served, program(served) as guesser, program(served, token=TOKEN) as one:
        assert await guesses(guesser) == [401] * TRIES + [429]
        locked = await one.get("/station")
        assert locked.refused(429, "locked-out").startswith("too many wrong tokens: wait ")
        assert 0 < int(locked.headers["Retry-After"]) <= WAIT
        assert (await one.order(kind="explore")).status == 429
        assert not station.commands()
        assert (await one.ask("POST", f"{PAYLOAD}/stop")).status == 202
        assert [each.command for each in station.commands()] == [ross.MAV_CMD_ROSS_STOP]
        assert (await one.ask("POST", "/stop")).status == 202


async def test_wrong_tokens_for_a_stop_count_and_stop_nothing():
    station = Scripted()
    async with page(station, token=TOKEN) as served, program(served) as guesser:
        assert await guesses(guesser, f"{PAYLOAD}/stop", "POST") == [401] * TRIES + [429]
        assert not station.commands()


async def test_who_guesses_in_the_header_keeps_nobody_from_the_form_nor_from_what_a_cookie_opens():
    async with page(Scripted(), token=TOKEN) as served, program(served) as guesser, program(served) as other:
        await guesses(guesser)
        async with other.session.post(f"{served.url}login", data={"token": TOKEN}, allow_redirects=False) as answer:
            assert answer.status == 303
        cookie = answer.headers["Set-Cookie"].split(";")[0]
        assert (await guesser.get("/station", headers={"Cookie": cookie})).status == 200
        assert (await guesser.get("/station")).status == 401


async def test_another_site_orders_nothing_in_the_name_of_who_is_logged_in():
    station = Scripted()
    async with page(station) as served, program(served) as one:
        for headers in ({"Origin": "http://evil.example"}, {"Sec-Fetch-Site": "same-site"}):
            assert (await one.ask("POST", "/stop", headers=headers)).refused(403, "other-origin")
        assert not station.commands()
