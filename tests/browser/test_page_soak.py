"""Five payloads at 10 Hz: how far the page is behind them, what that costs, and whether anything grows."""

import os
import statistics
import threading
import time
from contextlib import closing

import pytest

from browsing import eventually
from fleet_bench import FleetBench
from ross_sim.study.rows.long_run_rows import PageRun
from served_ground import served

PAYLOADS, RATE = 5, 10.0
EVERY = 5.0  # [s] between two looks
HOUR = float(os.environ.get("ROSS_SOAK", "3600"))  # [s]
TAKEN = "() => (globalThis.rossLatency ?? []).splice(0).map((each) => each.drawn - each.heard)"


class Pauses:
    """Notes how long a thread that has nothing else to do is kept from waking: what a busy computer does to all."""

    STEP = 0.02  # [s]

    def __init__(self):
        self.longest = 0.0  # [s]
        self._over = threading.Event()
        self._thread = threading.Thread(target=self._wake)

    def _wake(self):
        before = time.monotonic()
        while not self._over.wait(self.STEP):
            now = time.monotonic()
            self.longest = max(self.longest, now - before - self.STEP)
            before = now

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *reason):
        self._over.set()
        self._thread.join()


class Watch:
    """Looks at a page and at the process that serves it."""

    def __init__(self, page, ground, pauses):
        self.page, self.ground, self._pauses = page, ground, pauses
        self.latencies, self.rows, self.core = [], [], 0.0  # [ms], see `look`, share of one core
        self._devtools = page.context.new_cdp_session(page)
        self._devtools.send("Performance.enable")
        page.evaluate(TAKEN)
        self._start, self._cpu = time.monotonic(), ground.cpu()

    def look(self):
        self._devtools.send("HeapProfiler.collectGarbage")
        metrics = {each["name"]: each["value"] for each in self._devtools.send("Performance.getMetrics")["metrics"]}
        age = time.monotonic() - self._start
        sizes = (self.ground.memory(), self.ground.files(), metrics["JSHeapUsedSize"], metrics["Nodes"])
        self.rows.append((age, *sizes, self.ground.dropped()))
        self.latencies += self.page.evaluate(TAKEN)
        self.core = (self.ground.cpu() - self._cpu) / age

    def growth(self, column):
        """By what factor the least value of the last third exceeds that of the first, after the first sixth."""
        settled = self.rows[len(self.rows) // 6 :]
        third = len(settled) // 3
        return min(row[column] for row in settled[-third:]) / min(row[column] for row in settled[:third])

    def run(self):
        latencies = sorted(self.latencies)
        return PageRun(
            seconds=round(self.rows[-1][0]),
            frames=len(latencies),
            median_ms=round(statistics.median(latencies), 1),
            p95_ms=round(latencies[int(0.95 * len(latencies))], 1),
            max_ms=round(latencies[-1], 1),
            core=round(self.core, 3),
            dropped=self.rows[-1][5] - self.rows[0][5],
            paused_ms=round(1e3 * self._pauses.longest, 1),
            **{name: round(self.growth(column), 3) for column, name in enumerate(GROWING, 1)},
            memory_mb=round(self.rows[-1][1] / 2**20, 1),
            heap_mb=round(self.rows[-1][3] / 2**20, 1),
        )


GROWING = ("memory", "files", "heap", "nodes")


def watched(open_page, seconds):
    with (
        served() as ground,
        FleetBench(ground.port, PAYLOADS, RATE),
        closing(open_page(ground.url)) as page,
        Pauses() as pauses,
    ):
        page.goto(f"{ground.url}#/payload/3-191")
        eventually(page, lambda: page.locator(".scope").count() and page.evaluate("() => globalThis.rossLatency"))
        page.wait_for_timeout(2000)
        watch = Watch(page, ground, pauses)
        while not watch.rows or watch.rows[-1][0] < seconds:
            page.wait_for_timeout(min(EVERY, seconds / 9) * 1000)
            watch.look()
    return watch


@pytest.mark.soak
def test_the_page_keeps_up_with_five_payloads(open_page):
    run = watched(open_page, 9.0).run()
    assert run.frames > 20
    assert run.median_ms < 1000


@pytest.mark.soak
@pytest.mark.timeout(HOUR + 600)
def test_an_hour_of_five_payloads(open_page, written):
    run = watched(open_page, HOUR).run()
    written("page.csv", [run])
    assert run.p95_ms < 150, run
    assert run.core < 0.5, run
    assert all(getattr(run, name) < 1.1 for name in GROWING), run
    assert not run.dropped, run
