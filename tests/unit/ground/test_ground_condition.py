"""How every part of a payload is, and what to do."""

import pytest

from fleet_ear import status
from ross_payload.ground.model.health import condition, worst
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.computer import Computer, computer_message


def test_every_part_that_nobody_speaks_of_is_unknown(ground):
    ground.say(v.Named(0.0, "ross_k", 1.0))
    parts = condition(ground.known)
    assert {parts[name]["level"] for name in ("microphones", "actuator", "processor", "recording")} == {"unknown"}
    assert worst(parts) == "good", "it is heard"


@pytest.mark.parametrize(
    ("told", "part", "level", "word"),
    [
        (v.Audio(1, trouble=2), "microphones", "act", "microphone 1"),
        (v.Audio(1, waiting=3.0), "microphones", "watch", "backlog"),
        (status(1.0, actuator_present=True, homed=True, settled=True), "actuator", "good", "settled"),
        (status(1.0, actuator_present=True, homed=True, fault=True), "actuator", "act", "fault"),
        (status(1.0, actuator_present=True), "actuator", "act", "home"),
        (v.Recording(1, v.RecordingState.FULL, reason="the disk is full"), "recording", "act", "disk is full"),
        (v.Recording(1, v.RecordingState.ON, name="x"), "recording", "good", "recording x"),
    ],
)
def test_a_part_says_how_it_is_and_what_to_do(ground, told, part, level, word):
    ground.say(v.Named(0.0, "ross_k", 1.0), told)
    found = condition(ground.known)[part]
    assert (found["level"], word in found["words"]) == (level, True), found


@pytest.mark.parametrize(
    ("computer", "level", "word"),
    [
        (Computer(5.0, (0.3, 0.2), 50.0, 1e9, 4e9), "good", "normal"),
        (Computer(5.0, (0.3, 1.0), 50.0, 1e9, 4e9), "watch", "core"),
        (Computer(5.0, (0.3, 0.2), 91.0, 1e9, 4e9), "watch", "hot"),
        (Computer(5.0, (0.3, 0.2), 50.0, 3.95e9, 4e9), "watch", "memory"),
        (Computer(5.0), "good", "normal"),
    ],
)
def test_a_processor_says_how_it_is(ground, computer, level, word):
    ground.say(v.Named(0.0, "ross_k", 1.0), computer_message(computer, 0))
    found = condition(ground.known)["processor"]
    assert (found["level"], word in found["words"]) == (level, True), found


def test_a_link_of_the_payload_that_loses_much_is_to_be_watched(ground):
    ground.say(
        v.LinkReport(1, 0, 2, "udp", True, False, received=80, lost=20), v.LinkReport(1, 1, 2, "tcp", False, False)
    )
    assert [link["level"] for link in condition(ground.known)["links"]] == ["watch", "watch"]
