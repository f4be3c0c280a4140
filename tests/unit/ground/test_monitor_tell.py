"""What is worth a line of a log."""

import math
from dataclasses import replace

from emulated_scene import full
from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.view import view
from ross_payload.ground.terminal.change_log import ChangeLog
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.values import Audio, Severity, Source, Status, Text


class Told:
    """What is logged after each message."""

    def __init__(self):
        self._fleet, self._encoder, self._decoder = Fleet(), Encoder(1, 191), Decoder()
        self.change_log = ChangeLog()
        self.scene = list(full(30.0, 3, 1))
        self.words(*self.scene)

    def _picture(self, values):
        for value in values:
            for packet in self._decoder.feed(self._encoder.encode(value)):
                self._fleet.on_packet(packet, at=1.0)
        return view(self._fleet.payloads[ComponentId(1, 191)])

    def words(self, *values):
        return self.change_log.words(self._picture(values))

    def sections(self, *values):
        return self.change_log.sections(self._picture(values))

    def one(self, kind):
        return next(value for value in self.scene if isinstance(value, kind))


def test_what_is_repeated_is_not_told_again():
    told = Told()
    assert told.words(*told.scene) == []


def test_a_new_state_is_told_with_its_meaning():
    told = Told()
    [line] = told.words(replace(told.one(Status), state=9))
    assert line == "state fault: A fault ended the mission."


def test_no_heading_is_told_as_360_degrees():
    told = Told()
    north = math.radians(0.03)  # 359.97 degrees of a compass
    [line] = told.words(replace(told.one(Status), heading=north, heading_goal=north))
    assert line == "axis at 0.0 deg, turning to 0.0 deg"


def test_a_source_that_trembles_is_not_told_and_one_that_walks_is():
    told = Told()
    source = told.one(Source)
    assert told.words(replace(source, azimuth=source.azimuth + 0.05)) == []
    assert told.words(replace(source, azimuth=source.azimuth + 0.09))[0].startswith("sources 0 at ")


def test_small_steps_add_up():
    told = Told()
    source = told.one(Source)
    steps = [told.words(replace(source, azimuth=source.azimuth + 0.03 * step)) for step in range(1, 7)]
    assert sum(map(bool, steps)) == 2


def test_an_estimate_is_told_when_all_of_it_has_come():
    told = Told()
    new = [replace(value, estimate=2) for value in told.scene if isinstance(value, Source)]
    new = [replace(value, azimuth=value.azimuth + 1.0) for value in new]
    assert told.words(new[0]) == told.words(new[1]) == []
    [line] = told.words(new[2])
    assert line.startswith("sources 0 at ")
    assert line.count(" at ") == 3


def test_a_new_start_is_told_once():
    told = Told()
    again = replace(told.one(Status), time_usec=1)
    assert any("restarted, 2 starts so far" in line for line in told.words(again))
    assert not any("started" in line for line in told.words(replace(again, time_usec=2, state=3)))


def test_a_text_is_told_once():
    told = Told()
    assert told.words(Text(Severity.INFO, "RoSS: one")) == ["RoSS: one"]
    assert told.words(Text(Severity.INFO, "RoSS: two")) == ["RoSS: two"]
    assert told.words() == []


def test_only_a_level_that_changes_is_told_of_health():
    told = Told()
    audio = told.one(Audio)
    assert told.words(replace(audio, level=(-10.0, -11.0))) == []
    [line] = told.words(replace(audio, trouble=2))
    assert line.startswith("health microphones: critical, microphone 1 is silent")
    assert told.words(audio)[0].startswith("health")


def test_silence_is_told_once_and_so_is_its_end():
    change_log = ChangeLog()
    assert change_log.presence(10.0, 11.0) == []
    assert change_log.presence(10.0, 13.0) == ["no telemetry for 3.0 s"]
    assert change_log.presence(10.0, 14.0) == []
    assert change_log.presence(14.5, 14.6) == ["telemetry resumed"]


def test_json_has_only_the_sections_that_changed():
    told = Told()
    told.sections()
    [(name, value)] = told.sections(replace(told.one(Source), confidence=0.5))
    assert name == "sources"
    assert value[0]["confidence"] == 0.5
    assert "trail" not in value[0]
