"""What a payload on a bus tells of its mission: status, sources, news, health."""

import os
import re
import subprocess
import sys
import tomllib
from pathlib import Path

import numpy as np
import pytest

from dronecan_bench import play
from dronecan_wire import of
from ross_payload.config import Config, validated
from ross_payload.events import (
    AlignmentCandidate,
    AlignmentPlanned,
    Checked,
    Enrolled,
    Estimate,
    Finished,
    GroupScore,
    Outcome,
    SourceEstimate,
    SourcesEstimated,
    State,
    StateChanged,
)
from ross_payload.orders import Stop, TurnTo
from ross_protocols.dronecan.messages import Health, LogMessage, Mode, NodeStatus
from ross_protocols.dronecan.node_messages import Encoder
from ross_protocols.dronecan.ross_types import RossSource, RossSources, RossStatus
from ross_sim.devices.bus_nodes import lasts
from session_bench import Likes

ROOT = Path(__file__).parents[3]


def test_status_comes_five_times_a_second_and_follows_a_turn(wire, peer, tmp_path):
    def script(bench):
        yield from peer.wait(2.0)
        assert 9 <= len(of(RossStatus, peer.all)) <= 12
        assert peer.latest(RossStatus).state == State.IDLE
        bench.runner.order(TurnTo(0.5))
        yield from peer.wait(0.3)
        moving = peer.latest(RossStatus)
        assert (moving.state, moving.settled, moving.actuator) == (State.TURN, False, True)
        assert moving.heading_goal == pytest.approx(0.5)
        yield from peer.wait(3.0)
        assert peer.latest(RossStatus).heading == pytest.approx(0.5, abs=0.01)
        assert peer.latest(RossStatus).settled

    play(script, wire.open, tmp_path)


def test_a_stop_is_no_illness_and_a_heartbeat_goes_on(wire, peer, tmp_path):
    def script(bench):
        bench.runner.order(Stop())
        yield from peer.wait(2.5)

    play(script, wire.open, tmp_path)
    beats = [said.message for said in of(NodeStatus, peer.all)]
    assert len(beats) >= 3
    assert {beat.mode for beat in beats[1:-1]} == {Mode.OPERATIONAL}
    assert {beat.health for beat in beats} == {Health.OK}
    assert beats[-2].vendor_code == State.STOPPED


CANDIDATE = AlignmentCandidate(1, 0.75, 0.75, 1e-4, "gain", gain_db=9.5)
SOURCES = (
    SourceEstimate(0.5, 0.01, 0.9, resolved=True),
    SourceEstimate(-2.0, 0.02, 0.8, resolved=True),
)
STORY = [
    StateChanged(1.0, State.EXPLORE_LISTEN),
    SourcesEstimated(1.0, Estimate(SOURCES, certain=True), 3, final=True),
    AlignmentPlanned(1.0, (CANDIDATE,), np.zeros(0), np.zeros((2, 0))),
    StateChanged(1.0, State.CHECK),
    Checked(1.0, CANDIDATE, (GroupScore((1,), 4.5, True),), 0, "duet", ""),
]


def test_what_the_mission_finds_is_told_at_once_and_every_second(wire, peer, tmp_path):
    def script(bench):
        yield from peer.wait(1.5)
        assert {said.message for said in of(RossSources, peer.all)} == {RossSources(0)}
        peer.all.clear()
        bench.tell(*STORY)
        yield from peer.wait(0.05)
        told = peer.latest(RossSources)
        assert [source.azimuth for source in told.sources] == pytest.approx([0.5, -2.0])
        assert [source.target for source in told.sources] == [False, True]
        assert told.sources[1].score == 4.5
        assert told.final
        yield from peer.wait(0.3)
        status = peer.latest(RossStatus)
        assert (status.k, status.target, status.target_found, status.certain) == (2, 1, True, True)
        assert (status.alignment, status.gain_db, status.score) == (0.75, 9.5, 4.5)
        peer.all.clear()
        yield from peer.wait(3.0)
        assert 2 <= len(of(RossSources, peer.all)) <= 4

    play(script, wire.open, tmp_path, target=Likes(1))


def test_where_nobody_is_enrolled_no_score_is_told(wire, peer, tmp_path):
    def script(bench):
        bench.tell(*STORY[:-1], Checked(1.0, CANDIDATE, (GroupScore((1,), 0.0, False),), None, "duet", ""))
        yield from peer.wait(0.3)
        assert peer.latest(RossStatus).score is None
        assert [source.score for source in peer.latest(RossSources).sources] == [None, None]
        bench.tell(Enrolled(1.0, "talker-1", 1, 0.1, 5.0, None), *STORY[-1:])
        yield from peer.wait(0.3)
        assert peer.latest(RossStatus).score == 4.5

    play(script, wire.open, tmp_path)


def test_news_are_log_messages_and_a_fault_is_an_error(wire, peer, tmp_path):
    def script(bench):
        yield from peer.wait(0.1)
        bench.tell(*STORY, Finished(2.0, Outcome.FAULT, "the motor is gone"), StateChanged(2.0, State.FAULT, "gone"))
        yield from peer.wait(1.5)
        said = {(each.message.level, each.message.text) for each in of(LogMessage, peer.all)}
        assert (1, "target recognised: source 1, score 4.5") in said
        assert (3, "mission over: the motor is gone") in said
        assert peer.latest(NodeStatus).health is Health.ERROR

    play(script, wire.open, tmp_path)


# ------------------------------------------------------------------------------------- what the guide says


def block(language):
    page = (ROOT / "docs" / "how-to" / "dronecan-node.md").read_text(encoding="utf-8")
    return re.search(rf"```{language}\n(.*?)```", page, re.DOTALL).group(1)


def test_the_table_of_the_guide_is_valid():
    assert validated(Config, tomllib.loads(block("toml")), "the guide").dronecan.node_id == 121


@pytest.mark.soak
def test_the_program_of_the_guide_prints_what_it_says(tmp_path):
    pytest.importorskip("dronecan")
    home = os.environ | {"HOME": str(tmp_path)}
    subprocess.run(["sh", "-ec", block("sh")], cwd=ROOT, env=home, check=True)
    command = [sys.executable, "-c", block("python")]
    done = subprocess.run(command, cwd=ROOT, env=home, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == block("python").rpartition("# ")[2].strip()


def test_six_talkers_take_the_frames_that_the_guide_says():
    sources = RossSources(1, tuple(RossSource(0.1, 0.1, 1.0) for _ in range(6)))
    voice = Encoder(121)
    a_second = [*voice.broadcast(sources), *voice.broadcast(NodeStatus(1)), *(voice.broadcast(RossStatus(0)) * 5)]
    assert len(a_second) == 36
    assert sum(map(lasts, a_second)) == pytest.approx(0.005, abs=0.0005)
