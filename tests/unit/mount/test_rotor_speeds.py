"""How fast the rotors turn: what an autopilot says on the wire, what the mount makes of it, what a session keeps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from pymavlink.dialects.v20 import ardupilotmega

from mount_bench import Drone
from ross_payload.config import Config, validated
from ross_payload.dsp.stft import Stft
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.mission.context import Context, speeds_by_hop
from ross_payload.mission.settings import Tools
from ross_payload.pointing import Pointing
from ross_payload.service.assemble import settings_of
from ross_payload.sessions import input_log
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.dialect import MESSAGES
from ross_protocols.mavlink.rotor_speeds import rotor_sensors, rotor_status, rotor_telemetry, speeds_of

FLYING = Config.model_validate({"mount": {"source": "autopilot"}, "ego_noise": {"learn": True}})
SPEEDS = (90.0, 91.0, 88.5, 92.0)


def told(drone):
    return drone.mount.attitude(drone.clock.now()).rotor_speeds


@pytest.mark.parametrize("name", ["RPM", "ESC_TELEMETRY_1_TO_4", "ESC_TELEMETRY_5_TO_8", "ESC_TELEMETRY_9_TO_12"])
def test_messages_have_the_checksums_of_ardupilot(name):
    (theirs,) = (kind for kind in ardupilotmega.mavlink_map.values() if kind.msgname == name)
    ours = MESSAGES[theirs.id]
    assert (ours.msgname, ours.crc_extra) == (name, theirs.crc_extra)


def test_esc_status_has_the_checksum_of_px4():
    assert MESSAGES[291].crc_extra == 10  # MAVLINK_MSG_ID_ESC_STATUS_CRC of the C headers


def test_the_second_message_of_telemetry_tells_of_the_fifth_rotor_on():
    assert speeds_of(rotor_telemetry([100.0], 1, 7)) == {4: 100.0, 5: 0.0, 6: 0.0, 7: 0.0}


def test_a_rotor_that_turns_the_other_way_has_a_positive_speed():
    assert speeds_of(rotor_status(0.0, [-90.0]))[0] == 90.0


def test_what_is_no_number_or_no_rotor_stands():
    assert speeds_of(rotor_sensors([float("nan"), 5000.0])) == {0: 0.0, 1: 0.0}


@pytest.mark.parametrize("messages", ["esc_telemetry", "esc_status"])
def test_the_mount_asks_for_the_speeds_of_the_rotors_and_tells_them(messages):
    drone = Drone(config=FLYING, rotors=lambda: SPEEDS, rotor_messages=messages)
    assert told(drone) == ()
    drone.clock.sleep(3.0)
    assert told(drone) == pytest.approx(SPEEDS, abs=1 / 60)


def test_more_than_four_rotors_are_told_in_several_messages():
    drone = Drone(config=FLYING, rotors=lambda: [90.0 + number for number in range(6)])
    drone.clock.sleep(3.0)
    assert told(drone) == pytest.approx((90.0, 91.0, 92.0, 93.0, 94.0, 95.0, 0.0, 0.0), abs=1 / 60)


def test_nobody_asks_for_speeds_where_the_noise_is_not_learnt():
    drone = Drone(rotors=lambda: SPEEDS)
    drone.clock.sleep(3.0)
    assert told(drone) == ()


def test_sensors_of_speed_count_only_while_no_controller_is_heard():
    drone = Drone(config=FLYING, silent=((0.0, 100.0),))
    autopilot = Encoder(1, 1)
    drone.other.send(autopilot.encode(rotor_sensors([70.0])))
    drone.clock.sleep(0.2)
    assert told(drone)[0] == pytest.approx(70.0)
    drone.other.send(autopilot.encode(rotor_telemetry(SPEEDS, 0, 1)))
    drone.other.send(autopilot.encode(rotor_sensors([70.0])))
    drone.clock.sleep(0.2)
    assert told(drone)[0] == pytest.approx(90.0)


def test_speeds_that_are_older_than_a_second_are_not_known():
    drone = Drone(config=FLYING, rotors=lambda: SPEEDS, silent=((4.0, 6.0),))
    drone.clock.sleep(3.9)
    assert told(drone)
    drone.clock.sleep(1.4)
    assert told(drone) == ()


def test_speeds_of_another_vehicle_or_component_are_not_believed():
    drone = Drone(config=FLYING, silent=((0.0, 100.0),))
    drone.other.send(Encoder(1, 1).encode(rotor_sensors([])))  # the first autopilot is ours
    for stranger in (Encoder(7, 1), Encoder(1, 154)):
        drone.other.send(stranger.encode(rotor_telemetry(SPEEDS, 0, 1)))
    drone.clock.sleep(0.5)
    assert told(drone) == ()


def test_a_frame_of_ardupilots_own_encoder_is_read():
    sender = ardupilotmega.MAVLink(None, srcSystem=1, srcComponent=1)
    frame = sender.esc_telemetry_1_to_4_encode([0] * 4, [0] * 4, [0] * 4, [0] * 4, [5400, 0, 0, 5460], [1] * 4).pack(
        sender
    )
    (packet,) = Decoder().feed(bytes(frame))
    assert speeds_of(packet.message) == {0: 90.0, 1: 0.0, 2: 0.0, 3: 91.0}


def test_a_session_keeps_the_speeds_of_the_rotors_exactly():
    attitude = replace(Attitude(0.1), rotor_speeds=(90.1, 0.0, 1 / 3))
    block = AudioBlock(np.zeros((2, 160), np.float32), 0, 0.0)
    line = input_log.line(Input(block, 0.0, Pointing(), settled=True, attitude=attitude))
    read = input_log.input_of(input_log.parsed(line.encode()), block.samples, None)
    assert read.attitude.rotor_speeds == attitude.rotor_speeds


def test_a_session_without_rotors_has_no_word_of_them():
    block = AudioBlock(np.zeros((2, 160), np.float32), 0, 0.0)
    line = input_log.line(Input(block, 0.0, Pointing(), settled=True, attitude=Attitude(0.1)))
    assert "rotors" not in line
    assert input_log.parsed(line.replace("}\n", ',"rotors":["fast"]}\n').encode()) is None


def test_the_speeds_of_a_listening_period_say_where_its_tones_are():
    settings = settings_of(validated(Config, {"ego_noise": {"learn": True, "blades": 3}}, "test.toml"), -1.0, 1.0)
    stft = Stft(settings.rate, 1024, 256)
    context = Context(settings, Tools(None, stft, None, stft, None))
    samples = np.zeros((2, settings.rate), np.float32)
    tonal = context.tonal(stft, samples, speeds_by_hop([(), *[(100.0, 0.0)] * 9]))
    assert tonal.shape == (513, stft.frames_of(settings.rate))
    first = stft.frequencies[tonal[:, tonal.shape[1] // 2]][0]
    assert first == pytest.approx(300.0, abs=2 * stft.frequencies[1])
    assert context.tonal(stft, samples, speeds_by_hop([()] * 10)) is None
