"""A test that claims something about time is repeated when it fails while the computer itself did not run what was due.

Virtual machines are suspended by their hosts for half a second now and then. Whoever holds a product to milliseconds
then measures the host. `Meter` is an independent witness: a process with a thread on every processor which sleeps and
notes when it was woken late. `Repetition` runs a failed test of the timed lanes again, with all its fixtures anew, only
when the witness saw such a pause during the test; at most `MOST` times in all, and says so in the summary. A product
that is late without a pause fails at once, one that is always late fails in the end, and no pause excuses a traceback
or what a test says to hold `ALWAYS`.

``python host_pauses.py`` is the witness: it answers every line of its input with the pauses so far.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from typing import Any

NAP = 0.010  # [s] between two looks of the witness
NOTED = 0.040  # [s] later than due: a pause
LOOKS = 2  # of every thread after it was asked, until it answers
MOST = 3  # attempts of one test
EXCUSE = {"alone": 0.050, "realtime": 0.200, "browser": 0.200}  # [s] that a pause lasts at least, by lane
TRACEBACK = "Traceback (most recent call last)"  # in what a program of the product said
ALWAYS = "whatever the computer does"  # in the message of an assertion that no pause excuses
PROPERTY = "repeated"

Pause = tuple[float, float]  # when it began and ended, on the monotonic clock [s]


class Meter:
    """Tells of pauses since it was started; `close` ends it."""

    def __init__(self) -> None:
        command = [sys.executable, "-S", "-E", os.path.realpath(__file__)]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.since(0.0)  # it has begun

    @property
    def pid(self) -> int:
        """Number of the process."""
        return self._process.pid

    def since(self, begin: float) -> list[Pause]:
        """Return the pauses that lasted beyond ``begin`` [s], up to now."""
        assert self._process.stdin and self._process.stdout
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        return [(start, end) for start, end in json.loads(self._process.stdout.readline()) if end > begin]

    def close(self) -> None:
        """End the process."""
        self._process.communicate()


class Repetition:
    """The plug-in of pytest; ``lane`` tells that of a test, None for one that claims nothing about time."""

    def __init__(self, lane: Callable[[Any], str | None], meter: Callable[[], Meter] = Meter) -> None:
        self._lane, self._make = lane, meter
        self._meter: Meter | None = None

    def pytest_runtest_protocol(self, item: Any, nextitem: Any) -> bool | None:
        """Run a test, and again while there is an excuse."""
        from _pytest.runner import runtestprotocol

        lane = self._lane(item)
        if lane not in EXCUSE:
            return None
        self._meter = self._meter or self._make()
        item.ihook.pytest_runtest_logstart(nodeid=item.nodeid, location=item.location)
        excuses: list[str] = []
        while True:
            begin = time.monotonic()
            reports = runtestprotocol(item, nextitem=nextitem, log=False)
            failed = [str(report.longrepr) for report in reports if report.failed]
            if not failed or len(excuses) == MOST - 1:
                break
            excuse = excused(failed, self._meter.since(begin), EXCUSE[lane])
            if not excuse or not _torn_down(item):
                break
            excuses.append(excuse)
        told = next((report for report in reports if report.failed or report.when == "call"), reports[0])
        told.user_properties += [(PROPERTY, f"{item.nodeid}: {excuse}") for excuse in excuses]
        for report in reports:
            item.ihook.pytest_runtest_logreport(report=report)
        item.ihook.pytest_runtest_logfinish(nodeid=item.nodeid, location=item.location)
        return True

    def pytest_unconfigure(self) -> None:
        """Let the witness go."""
        if self._meter is not None:
            self._meter.close()

    def pytest_terminal_summary(self, terminalreporter: Any) -> None:
        """Say what was repeated, and why."""
        lines = [value for report in _reports(terminalreporter) for name, value in report.user_properties
                 if name == PROPERTY]  # fmt: skip
        if lines:
            terminalreporter.section("repeated, for the computer had paused")
            for line in lines:
                terminalreporter.write_line(line)


def excused(failed: Sequence[str], pauses: Sequence[Pause], least: float) -> str:
    """Say what excuses these failures, empty when nothing does.

    >>> excused(["E  assert 0.7 < 0.15"], [(8.0, 8.61)], 0.2)
    'a pause of 0.61 s: assert 0.7 < 0.15'
    >>> excused(["E  assert 0.7 < 0.15"], [(8.0, 8.1)], 0.2)
    ''
    """
    longest = max((end - start for start, end in pauses), default=0.0)
    if longest < least or any(word in each for each in failed for word in (TRACEBACK, ALWAYS)):
        return ""
    said = [line.removeprefix("E").strip() for line in failed[0].splitlines() if line.startswith("E ")]
    return f"a pause of {longest:.2f} s: {(said or failed[0].splitlines()[-1:] or [''])[0]}"


def _torn_down(item: Any) -> bool:
    """Have all fixtures made anew, also those of the module, which a pause may have spoilt; False if one ends badly."""
    try:
        item.session._setupstate.teardown_exact(None)
    except (Exception, SystemExit) as error:
        item.add_report_section("teardown", "fixtures", repr(error))
        return False
    for definitions in item._fixtureinfo.name2fixturedefs.values():
        for definition in definitions:
            definition.cached_result = None
    item._initrequest()
    return True


def _reports(terminalreporter: Any) -> Iterator[Any]:
    for name in ("passed", "failed", "error", "skipped"):
        yield from (report for report in terminalreporter.stats.get(name, []) if hasattr(report, "user_properties"))


# ---- the witness


def watch(processor: int, pauses: list[Pause], looks: list[int], slot: int) -> None:
    """Sleep on one processor, and note when that took too long."""
    os.sched_setaffinity(0, {processor})
    before = time.monotonic()
    while True:
        time.sleep(NAP)
        now = time.monotonic()
        if now - before > NAP + NOTED:
            pauses.append((before + NAP, now))
        before = now
        looks[slot] += 1


def witness() -> None:
    """Answer until the input ends."""
    processors = sorted(os.sched_getaffinity(0))
    pauses: list[Pause] = []
    looks = [0] * len(processors)
    for slot, processor in enumerate(processors):
        threading.Thread(target=watch, args=(processor, pauses, looks, slot), daemon=True).start()
    for _ in sys.stdin:
        enough = [count + LOOKS for count in looks]  # what goes on now will be seen
        while any(count < least for count, least in zip(looks, enough, strict=True)):
            time.sleep(NAP)
        sys.stdout.write(json.dumps(pauses) + "\n")
        sys.stdout.flush()


if __name__ == "__main__":
    witness()
