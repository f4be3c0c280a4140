"""A test that fails while the computer paused is repeated; one that fails without a pause, or always, fails."""

import os
import signal
import time

import pytest

from host_pauses import MOST, Meter, Repetition, excused

pytest_plugins = "pytester"
PAUSED, QUICK = [(0.0, 0.6)], [(0.0, 0.06)]
TEST = """
import pytest
seen = []
@pytest.fixture
def fresh(tmp_path):
    seen.append(tmp_path)
    return len(seen)
def test_it(fresh):
    assert fresh > {failures}, "{said}"
"""


@pytest.fixture
def meter():
    one = Meter()
    yield one
    one.close()


def test_a_pause_is_seen_with_its_length_and_only_by_who_asks_for_its_time(meter):
    begin = time.monotonic()
    os.kill(meter.pid, signal.SIGSTOP)
    time.sleep(0.3)  # the pause
    os.kill(meter.pid, signal.SIGCONT)
    assert any(end - start > 0.25 and end > begin + 0.3 for start, end in meter.since(begin))
    now = time.monotonic()
    assert all(end > now for _, end in meter.since(now))


class Witness:
    def __init__(self, pauses):
        self.pauses = pauses

    def since(self, begin):
        return self.pauses

    def close(self):
        pass


@pytest.mark.parametrize(
    ("failures", "pauses", "said", "outcome"),
    [
        (1, PAUSED, "late", (True, 1)),
        (MOST - 1, PAUSED, "late", (True, MOST - 1)),
        (MOST, PAUSED, "late", (False, MOST - 1)),  # always late
        (1, [], "late", (False, 0)),  # late without a pause
        (1, QUICK, "late", (False, 0)),
        (1, PAUSED, "Traceback (most recent call last)", (False, 0)),
        (0, PAUSED, "", (True, 0)),
    ],
)
def test_only_a_pause_excuses_and_not_for_ever(pytester, failures, pauses, said, outcome):
    passes, repeated = outcome
    pytester.makepyfile(TEST.format(failures=failures, said=said))
    plugin = Repetition(lambda item: "realtime", lambda: Witness(pauses))
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider", "-p", "no:asyncio", plugins=[plugin])
    result.assert_outcomes(passed=int(passes), failed=int(not passes))
    told = [line for line in result.outlines if "::test_it: a pause of 0.60 s: AssertionError: late" in line]
    assert len(told) == repeated


SPOILT = """
import pytest
made = []
@pytest.fixture(scope="module")
def shared():
    made.append("up")
    yield made
    made.append("down")
def test_before(shared):
    pass
def test_it(shared):
    assert shared == ["up", "down", "up"]
def test_after(shared):
    assert shared == ["up", "down", "up"]
@pytest.fixture(scope="module")
def broken():
    made.append("broken")
    assert made.count("broken") > 1
def test_setup(broken):
    pass
"""


def test_the_fixtures_of_the_module_are_made_anew(pytester):
    pytester.makepyfile(SPOILT)
    plugin = Repetition(lambda item: "realtime", lambda: Witness(PAUSED))
    result = pytester.runpytest_inprocess("-p", "no:cacheprovider", "-p", "no:asyncio", plugins=[plugin])
    result.assert_outcomes(passed=4)
    assert sum("a pause of 0.60 s" in line for line in result.outlines) == 2


def test_what_claims_nothing_about_time_is_never_repeated(pytester):
    pytester.makepyfile(TEST.format(failures=1, said=""))
    plugin = Repetition(lambda item: None, lambda: Witness(PAUSED))
    pytester.runpytest_inprocess("-p", "no:asyncio", plugins=[plugin]).assert_outcomes(failed=1)


def test_an_excuse_says_the_longest_pause_and_what_failed():
    assert excused(["E   assert 1 < 0\nE    more"], [*QUICK, *PAUSED], 0.05) == "a pause of 0.60 s: assert 1 < 0"
