"""What a program cannot mean is one problem with the right status, and nothing happens."""

import json
from types import SimpleNamespace

import pytest

from ground_page import on_a_thread, page
from hand_station import HandStation
from rest_program import PAYLOAD, program
from ross_protocols.mavlink.dialect import ross
from scripted_station import Scripted, status

ORDERS, UNIT = f"{PAYLOAD}/orders", f"{PAYLOAD}/parameters/EXP_UNIT"
EXPLORE = ross.MAV_CMD_ROSS_EXPLORE
JSON = {"Content-Type": "application/json"}
KINDS = "cancel, enrol, explore, home, inform, listen, noise, park, rearm, record, stop, stop_stream, stream, turn"


def order(**fields):
    return {"json": fields}


def raw(body, **headers):
    return {"data": body, "headers": JSON | headers}


WRONG = [
    # method, path, how, status, code, detail
    ("GET", "/payloads/9-191", {}, 404, "unknown-payload", "id: expected a payload that was received, got 9-191"),
    ("GET", "/payloads/9-191/sources", {}, 404, "unknown-payload", "got 9-191"),
    ("GET", "/payloads/0-191", {}, 422, "invalid", "payload: expected a text such as 1-191, got '0-191'"),
    ("POST", "/payloads/one/stop", {}, 422, "invalid", "payload: expected a text such as 1-191, got 'one'"),
    ("GET", "/payloads/1-191/nothing", {}, 404, "not-found", "/api/v1/openapi.json lists all of them"),
    ("GET", "/nothing", {}, 404, "not-found", "there is no such path"),
    ("DELETE", PAYLOAD, {}, 405, "wrong-method", "Allow"),
    ("GET", f"{PAYLOAD}?wiat=1", {}, 422, "invalid", "wiat: unknown field"),
    ("GET", f"{ORDERS}/1?wiat=1", {}, 422, "invalid", "wiat: unknown field; did you mean 'wait'?"),
    ("GET", f"{ORDERS}/1?wait=1&wait=2", {}, 422, "invalid", "wait: expected one value, got 2"),
    ("GET", f"{ORDERS}/1?wait=61", {}, 422, "invalid", "wait: expected 0 to 60, got '61'"),
    ("GET", f"{ORDERS}/1?wait=nan", {}, 422, "invalid", "wait: expected 0 to 60, got 'nan'"),
    ("GET", f"{ORDERS}/1", {}, 404, "unknown-order", "number: expected that of an order to 1-191, got 1"),
    ("GET", f"{ORDERS}/first", {}, 422, "invalid", "number: expected "),
    ("POST", f"{ORDERS}/7/cancel", {}, 404, "unknown-order", "got 7"),
    ("POST", "/payloads/9-191/orders", order(kind="park"), 404, "unknown-payload", "got 9-191"),
    ("POST", ORDERS, {}, 415, "wrong-content-type", "Content-Type: expected application/json in UTF-8, got"),
    ("POST", ORDERS, {"data": {"kind": "park"}}, 415, "wrong-content-type", "got application/x-www-form-urlencoded"),
    ("POST", ORDERS, raw(b"{}", **{"Content-Type": "application/json; charset=utf-16"}), 415, "wrong-content-type", ""),
    ("POST", ORDERS, raw(b""), 400, "malformed", "body: expected JSON, got EOF"),
    ("POST", ORDERS, raw(b'{"kind":'), 400, "malformed", "body: expected JSON, got EOF"),
    ("POST", ORDERS, raw(b'{"kind": "turn", "heading": NaN}'), 400, "malformed", "body: expected JSON"),
    ("POST", ORDERS, raw(b"\xff\xfe"), 400, "malformed", "body: expected JSON"),
    ("POST", ORDERS, raw(b"[" * 60_000), 400, "malformed", "body: expected JSON"),
    ("POST", ORDERS, raw(b" " * 70_000 + b"{}"), 413, "too-large", "65536"),
    ("POST", ORDERS, raw(b"x", **{"Content-Encoding": "gzip"}), 400, "malformed", ""),
    ("POST", ORDERS, order(), 422, "invalid", f"kind: expected one of {KINDS}, got nothing"),
    ("POST", ORDERS, order(kind="dance"), 422, "invalid", f"kind: expected one of {KINDS}, got 'dance'"),
    ("POST", ORDERS, {"json": ["park"]}, 422, "invalid", "body: expected an object, got ['park']"),
    ("POST", ORDERS, {"json": None}, 415, "wrong-content-type", ""),
    ("POST", ORDERS, raw(b"null"), 422, "invalid", "body: expected an object, got null"),
    ("POST", ORDERS, order(kind="turn"), 422, "invalid", "heading: expected -360 to 360, got nothing"),
    ("POST", ORDERS, order(kind="turn", heading=361), 422, "invalid", "heading: expected -360 to 360, got 361"),
    ("POST", ORDERS, order(kind="turn", heading="40"), 422, "invalid", "heading: expected -360 to 360, got '40'"),
    ("POST", ORDERS, order(kind="turn", heading=True), 422, "invalid", "heading: expected -360 to 360, got True"),
    ("POST", ORDERS, order(kind="turn", heading=None), 422, "invalid", "heading: expected -360 to 360, got null"),
    ("POST", ORDERS, raw(b'{"kind": "turn", "heading": 1e999}'), 422, "invalid", "heading: expected -360 to 360"),
    ("POST", ORDERS, order(kind="turn", heading=4, speed=1), 422, "invalid", "speed: unknown field"),
    ("POST", ORDERS, order(kind="turn", headng=4), 422, "invalid", "headng: unknown field; did you mean 'heading'?"),
    ("POST", ORDERS, order(kind="park", heading=4), 422, "invalid", "heading: unknown field"),
    ("POST", ORDERS, order(kind="listen", source=1.5), 422, "invalid", "source: expected a whole number, got 1.5"),
    ("POST", ORDERS, order(kind="listen", source=256), 422, "invalid", "source: expected 0 to 255, got 256"),
    ("POST", ORDERS, order(kind="listen", source=1, azimuth=2), 422, "invalid", "expected a source or an azimuth"),
    ("POST", ORDERS, order(kind="inform", azimuths=[]), 422, "invalid", "azimuths: expected a list of 1 to 6 values"),
    ("POST", ORDERS, order(kind="inform", azimuths=[1, 999]), 422, "invalid", "azimuths.1: expected -360 to 360"),
    ("POST", ORDERS, order(kind="record", on="yes"), 422, "invalid", "on: expected true or false, got 'yes'"),
    ("POST", ORDERS, order(kind="stream", what="target"), 422, "invalid", "address: expected one for a new stream"),
    ("POST", ORDERS, order(kind="stream", address="239.1.2.3", port=5004), 422, "invalid", "address: expected a text "),
    ("POST", ORDERS, order(kind="stream", stream=0, what="source"), 422, "invalid", "source: expected 0 to 255"),
    ("POST", ORDERS, order(kind="enrol", source=1), 422, "invalid", "consent: expected true, got nothing"),
    ("POST", ORDERS, order(kind="enrol", source=1, consent=False), 422, "invalid", "expected that of the talker"),
    ("POST", f"{ORDERS}?wait=-1", order(kind="park"), 422, "invalid", "wait: expected 0 to 60, got '-1'"),
    ("POST", ORDERS, order(kind="park") | {"headers": {"Ross-Client": "a b"}}, 422, "invalid", "Ross-Client: "),
    ("PUT", UNIT, {"json": {"value": "2"}}, 422, "invalid", "value: expected"),
    ("PUT", UNIT, {"json": {"value": 1e39}}, 422, "invalid", "value: expected -3.40282e+38 to 3.40282e+38, got 1e+39"),
    ("PUT", UNIT, {"json": {}}, 422, "invalid", "value: expected"),
    ("PUT", f"{PAYLOAD}/parameters/NO_SUCH", {"json": {"value": 2}}, 404, "unknown-parameter", "'NO_SUCH'"),
    ("GET", f"{PAYLOAD}/parameters/EXP_UNITS", {}, 404, "unknown-parameter", "expected one such as EXP_UNIT"),
    ("GET", f"{PAYLOAD}/parameters/{'X' * 17}", {}, 422, "invalid", "name: expected a text such as EXP_UNIT"),
    ("GET", "/recordings/0001", {}, 404, "not-found", "recording 0001: not found"),
    ("DELETE", "/recordings/0001", {}, 404, "not-found", "recording 0001: not found"),
    ("GET", "/recordings/..%2f..%2fetc/files/passwd", {}, 422, "invalid", "name: expected a text such as 0001"),
    ("POST", "/flights?name=a.tlog", {"data": b"nothing"}, 422, "invalid", "a.tlog: expected a telemetry log"),
    ("POST", "/flights?name=a.exe", {"data": b"nothing"}, 422, "invalid", "name: expected a text such as flight.tlog"),
    ("POST", "/flights", {"data": b"nothing"}, 422, "invalid", "such as flight.tlog, got nothing"),
    ("GET", "/station", {"headers": {"Host": "evil.example"}}, 421, "other-host", "host: expected this computer"),
    ("POST", "/stop", {"headers": {"Origin": "http://evil.example"}}, 403, "other-origin", "another origin: refused"),
    ("POST", "/stop", {"headers": {"Sec-Fetch-Site": "cross-site"}}, 403, "other-origin", "another origin: refused"),
]  # fmt: skip


@pytest.fixture(scope="module")
def served():
    """A page, its station, and how it is reached."""
    station = Scripted()
    with on_a_thread(station) as (port, faults):
        yield SimpleNamespace(url=f"http://127.0.0.1:{port}/", station=station, faults=faults)


@pytest.mark.parametrize("case", WRONG, ids=lambda case: f"{case[0]}-{case[5]}"[:60])
async def test_what_cannot_be_meant_is_one_problem_and_nothing_happens(served, case):
    method, path, how, code, word, detail = case
    async with program(served) as one:
        answer = await one.ask(method, path, **how)
        assert detail in answer.refused(code, word)
        assert (await one.get("/control")).told["name"] is None
    sent = [message for message, _ in served.station.sent]
    assert not [each for each in sent if each.get_type() == "COMMAND_LONG" and each.command >= EXPLORE]
    assert not [each for each in sent if each.get_type() in ("PARAM_SET", "COMMAND_CANCEL")]
    assert not served.faults


async def test_every_value_that_is_wrong_is_told_with_its_place():
    async with page(Scripted()) as served, program(served) as one:
        wrong = (await one.order(kind="stream", stream=999, gain=99, port=0)).told["errors"]
        assert {(each["place"], each["name"]) for each in wrong} == {
            ("body", name) for name in ("stream", "gain", "port")
        }


async def test_a_fault_of_the_page_is_a_problem_and_a_line_on_the_terminal(monkeypatch):
    told = []
    monkeypatch.setattr("ross_payload.ground.web.rest.problems.report", told.append)
    monkeypatch.setattr("ross_payload.ground.web.rest.payload_handlers.overview", lambda *_: {"now": "never"})
    async with page(Scripted()) as served, program(served) as one:
        assert "see the terminal" in (await one.get("/payloads")).refused(500, "fault")
    assert len(told) == 1


async def test_a_payload_that_does_not_answer_for_its_parameters_is_a_problem_of_its_own(monkeypatch):
    monkeypatch.setattr("ross_payload.ground.web.rest.parameter_handlers.LIST_TIMEOUT_S", 0.05)
    station = HandStation()
    station.say(status(1.0))
    async with page(station) as served, program(served) as one:
        listed = await one.get(f"{PAYLOAD}/parameters?wait=0")
        assert (listed.status, listed.told["complete"], listed.told["parameters"]) == (200, False, [])
        assert "0 have arrived so far" in (await one.get(f"{UNIT}?wait=0")).refused(504, "no-answer")
        assert "0 have arrived so far" in (await one.ask("PUT", UNIT, json={"value": 1})).refused(504, "no-answer")


def test_the_list_of_what_is_wrong_covers_every_kind_of_order_with_numbers():
    told = json.dumps([how.get("json") for _, _, how, *_ in WRONG])
    assert all(f'"{kind}"' in told for kind in ("turn", "listen", "inform", "record", "stream", "enrol"))
