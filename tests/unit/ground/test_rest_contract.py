"""The page keeps what its OpenAPI description says, whatever a program sends: checked by schemathesis."""

import re
import subprocess
import sys
from pathlib import Path
from urllib.request import urlopen

import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis.errors import Unsatisfiable

import emulated_commands
from emulated_scene import full
from fleet_bench import FleetThread
from ground_page import on_a_thread
from rest_program import BASE
from ross_protocols.mavlink.commands import Result
from scripted_station import Scripted
from served_ground import served
from waiting import wait_for

ENDLESS = "/payloads/{payload}/events"  # see test_rest_events
UPLOAD = "POST /flights"  # no schema can say what a telemetry log is
OFTENER = {"POST /payloads/{payload}/orders": 6, "PUT /payloads/{payload}/parameters/{name}": 3}
WANTED_CASES = 5000
LIMITS = {"deadline": None, "database": None, "derandomize": True, "suppress_health_check": list(HealthCheck)}
SETTINGS = f"""
[[operations]]
include-path = "{ENDLESS}"
enabled = false

[[operations]]
include-name = "{UPLOAD}"
checks.positive_data_acceptance.enabled = false
"""
KNOWN = '\n[parameters]\n"path.payload" = "1-191"\n'


@pytest.fixture(scope="module")
def description():
    """The description of a running page, as schemathesis reads it, and the faults of the page."""
    import schemathesis  # takes a second, which whoever collects tests need not wait

    station = Scripted(Result.ACCEPTED)
    station.say(*full(30.0))
    with on_a_thread(station) as (port, faults):
        yield schemathesis.openapi.from_url(f"http://127.0.0.1:{port}/{BASE}/openapi.json"), faults


def cases(operation, *, good):
    """Send some requests that fit the description, or do not, and look at every answer."""
    from schemathesis import GenerationMode

    tried, mode = [], GenerationMode.POSITIVE if good else GenerationMode.NEGATIVE

    @settings(max_examples=OFTENER.get(operation.label, 2 if good else 1), phases=[Phase.generate], **LIMITS)
    @given(operation.as_strategy(generation_mode=mode))
    def one(case):
        if "payload" in case.path_parameters and good and len(tried) % 2 == 0:  # else one that was not received
            case.path_parameters["payload"] = "1-191"
        tried.append(case.call_and_validate().status_code)

    try:
        one()
    except Unsatisfiable:
        assert not good, operation.label  # nothing can be wrong with it
    return tried


@pytest.mark.soak
def test_answers_to_good_and_to_bad_requests_fit_the_description(description):
    schema, faults = description
    operations = [each.ok() for each in schema.get_all_operations()]
    tested = [each for each in operations if each.path != ENDLESS and each.label != UPLOAD]
    good = [status for each in tested for status in cases(each, good=True)]
    bad = [status for each in tested for status in cases(each, good=False)]
    assert sum(status < 300 for status in good) > len(tested) // 2
    assert 404 in good
    assert bad
    assert all(400 <= status < 500 for status in bad)
    assert not faults


def contract(folder, url, cases, *more, seed):
    """Run schemathesis as its users do; return how many cases it tried."""
    (folder / "schemathesis.toml").write_text(SETTINGS + "".join(more))
    command = [Path(sys.executable).with_name("schemathesis"), "run", f"{url}{BASE}/openapi.json", "--no-color"]
    options = ["-n", str(cases), "--seed", str(seed), "--continue-on-failure"]
    done = subprocess.run([*command, *options], cwd=folder, capture_output=True, text=True, timeout=3600, check=False)
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr
    return int(re.search(r"(\d+) generated", done.stdout)[1])


@pytest.mark.soak
def test_five_thousand_cases_against_the_running_page_fail_nowhere(tmp_path, monkeypatch):
    monkeypatch.setattr(emulated_commands, "TASK", 0.05)
    with served() as ground, FleetThread(ground.port):
        wait_for(lambda: b"1-191" in fetched(f"{ground.url}{BASE}/payloads"))
        tried = [contract(tmp_path, ground.url, 70, seed=1), contract(tmp_path, ground.url, 70, KNOWN, seed=2)]
        assert b"1-191" in fetched(f"{ground.url}{BASE}/payloads")
    print(f"schemathesis: {tried} cases, 0 failures")  # noqa: T201
    assert sum(tried) >= WANTED_CASES


def fetched(url):
    with urlopen(url) as answer:  # noqa: S310
        return answer.read()
