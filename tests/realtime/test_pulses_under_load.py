"""How often the pulses of a stepper run out beside two busy loops, by `ahead_ms` and by the priority of the payload.

The move is then lost, and says so. A busy loop takes a whole core with the priority of everything ordinary.
"""

import pytest

from pulse_rig import HOME, REARM, SEPARATING, Rig, busy_loops
from ross_sim.study.rows.promptness_rows import PulseRow

pytestmark = pytest.mark.alone
ACCEPTED = 0  # MAV_RESULT
SAFE_MS = 100
WITHOUT_RIGHTS = """
import ctypes, os, resource, sys
resource.setrlimit(resource.RLIMIT_RTPRIO, (0, 0))
ctypes.CDLL(None).prctl(24, 23, 0, 0, 0)  # PR_CAPBSET_DROP, CAP_SYS_NICE: as any user
os.execv(sys.executable, [sys.executable, "-m", "ross_payload.cli", *sys.argv[1:]])
"""
NICE = """
import os
os.nice(-10)
from ross_payload import cli
cli.main()
"""
ROUND_ROBIN = """
import os
os.sched_setscheduler(0, os.SCHED_RR, os.sched_param(5))
from ross_payload import cli
cli.main()
"""
PRIORITIES = {
    "no rights": ("-c", WITHOUT_RIGHTS),
    "urgent pump": ("-m", "ross_payload.cli"),
    "urgent pump, Nice=-10": ("-c", NICE),
    "all round robin": ("-c", ROUND_ROBIN),
    "separating, urgent pump": ("-c", SEPARATING),
    "separating, urgent pump, Nice=-10": ("-c", f"import os\nos.nice(-10)\n{SEPARATING}"),
}
SAID = {
    "no rights": "ordinary: no right to real-time priority (`ulimit -r` says 0)",
    "urgent pump": "the pump in real time, as the service's unit allows it (`LimitRTPRIO=20`)",
    "urgent pump, Nice=-10": "the same, and `Nice=-10`",
    "all round robin": "all threads in real time (round robin)",
    "separating, urgent pump": "the pump in real time, a thread separates without a pause",
    "separating, urgent pump, Nice=-10": "the same, and `Nice=-10`, a thread separates without a pause",
}
SOUND = ("urgent pump", "urgent pump, Nice=-10", "all round robin")  # what 40 ms is good for
CASES = [
    ("no rights", 40, 30),
    ("urgent pump", 40, 30),
    ("urgent pump", 60, 30),
    ("urgent pump", SAFE_MS, 100),
    ("urgent pump, Nice=-10", 40, 30),
    ("all round robin", 40, 30),
    ("separating, urgent pump", 40, 25),
    ("separating, urgent pump, Nice=-10", 40, 25),
    ("separating, urgent pump", SAFE_MS, 25),
]


@pytest.fixture
def rig(noise, tmp_path, process, ground_station, free_port):
    """Make a rig whose payload has some priority and looks so far ahead."""
    (tmp_path / "noise.wav").hardlink_to(noise)

    def make(priority, ahead_ms):
        def start():
            return process(["run", "ross.toml"], tmp_path, "payload", PRIORITIES[priority])

        return Rig(tmp_path, start, ground_station, free_port(), ahead_ms)

    return make


@pytest.mark.soak
def test_a_move_beside_two_busy_loops_arrives_or_says_that_its_pulses_ran_out(rig):
    with rig("urgent pump", 100) as payload, busy_loops():
        assert lost(payload, 1) <= 1


def lost(payload, moves):
    """How many of so many moves by 90 degrees ran out of pulses."""
    count = 0
    for _ in range(moves):
        if payload.turn_to_the_end() != ACCEPTED:
            count += 1
            faults = [line for line in (payload.folder / "payload.log").read_text().splitlines() if "fault" in line]
            assert faults, "it failed without a word"
            assert "pulse underrun" in faults[-1], faults[-1]
            assert (payload.ground.order(HOME), payload.ground.order(REARM)) == (ACCEPTED, ACCEPTED)
    return count


@pytest.mark.soak
@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}, {case[1]} ms")
def test_moves_beside_two_busy_loops_are_counted(rig, written, capsys, case):
    priority, ahead_ms, moves = case
    with rig(priority, ahead_ms) as payload, busy_loops():
        each = [lost(payload, 1) == 1 for _ in range(moves)]
    written("pulses.csv", [PulseRow(SAID[priority], ahead_ms, move, gone) for move, gone in enumerate(each)])
    count = sum(each)
    with capsys.disabled():
        print(f"{ahead_ms} ms ahead, {priority}: {count} of {moves} moves lost")  # noqa: T201
    if priority in SOUND:
        assert count <= (0 if ahead_ms >= SAFE_MS else moves / 10)
