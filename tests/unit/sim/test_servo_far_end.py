"""The simulated CAN bus and the simulated servo: time on the bus, friction, play, encoder, firmware, faults."""

import math
from dataclasses import replace

import numpy as np
import pytest

from ross_payload.actuators.dronecan_servo.options import Options
from ross_protocols.can import CanFrame
from ross_protocols.dronecan.messages import ArrayCommand, Command, CommandKind, NodeStatus, Status
from ross_protocols.dronecan.node_messages import Decoder, Encoder
from ross_protocols.dronecan.services import MAGIC, NodeInfo, NodeInfoRequest, RestartRequest, RestartResponse
from ross_sim.devices.bus_nodes import ROOM, Bus, lasts
from ross_sim.devices.dronecan_far_end import far_end
from ross_sim.devices.far_end import OF_DEVICES, SLIP, Fault
from ross_sim.devices.servo_shaft import STEP, Drive, Shaft

TEN_MS = 0.01
GOAL = math.radians(60)


def frame(priority, node=1, data=bytes(8)):
    return CanFrame(priority << 24 | 1010 << 8 | node, data)


class TestBus:
    def bus(self, n=3):
        bus = Bus(np.random.default_rng(0))
        return bus, [bus.plug() for _ in range(n)]

    def test_everybody_else_hears_a_frame(self):
        bus, (one, two, three) = self.bus()
        one.send(frame(8))
        bus.carry(TEN_MS)
        assert (one.receive(), two.receive(), three.receive()) == ([], [frame(8)], [frame(8)])

    def test_the_lowest_identifier_goes_first_but_each_node_in_its_own_order(self):
        bus, (one, two, three) = self.bus()
        for priority in (20, 2):
            one.send(frame(priority, 1))
        two.send(frame(10, 2))
        bus.carry(TEN_MS)
        assert three.receive() == [frame(10, 2), frame(20, 1), frame(2, 1)]

    def test_at_1_mbit_s_a_long_frame_lasts_144_us(self):
        assert lasts(frame(0)) == pytest.approx(144e-6, rel=0.01)

    def test_what_does_not_fit_comes_later_and_in_the_long_run_nothing_is_won(self):
        bus, (one, two, _) = self.bus()
        heard = 0
        for _ in range(100):
            one.sent += [frame(8)] * (ROOM - len(one.sent))
            bus.carry(TEN_MS)
            heard += len(two.receive())
        assert heard == pytest.approx(100 * TEN_MS / lasts(frame(8)), rel=0.01)

    def test_who_babbles_with_the_highest_priority_silences_all_others(self):
        bus, (one, two, three) = self.bus()
        for _ in range(10):
            one.sent += [frame(0)] * ROOM
            two.send(frame(8, 2))
            bus.carry(TEN_MS)
        assert frame(8, 2) not in three.receive()

    def test_an_interface_has_room_for_so_many_frames_and_loses_the_rest(self):
        bus, (one, *_) = self.bus()
        for _ in range(500):
            one.send(frame(8))
        bus.carry(TEN_MS)
        assert len(one.sent) == ROOM

    def test_damaged_frames_take_their_time_but_reach_nobody(self):
        bus, (one, two, _) = self.bus()
        one.damage = 0.5
        heard = 0
        for _ in range(40):
            one.sent += [frame(8)] * 50
            bus.carry(TEN_MS)
            heard += len(two.receive())
        assert heard == pytest.approx(1000, rel=0.1)


class TestShaft:
    def shaft(self, **drive):
        return Shaft(replace(Drive(), **drive), np.random.default_rng(0))

    def live(self, shaft, goal, seconds):
        speeds = []
        for _ in range(round(seconds / STEP)):
            shaft.live(goal)
            speeds.append(abs(shaft.rate))
        return max(speeds)

    def test_it_reaches_its_goal_within_what_friction_holds(self):
        shaft = self.shaft()
        self.live(shaft, GOAL, 1.0)
        assert shaft.rate == 0.0
        assert shaft.turned == pytest.approx(GOAL, abs=math.radians(0.15))

    def test_a_jump_is_followed_as_fast_as_the_drive_can(self):
        shaft = self.shaft()
        fastest = self.live(shaft, math.pi, 0.4)
        assert fastest == pytest.approx(Drive().speed, rel=0.05)
        assert fastest <= Drive().speed * 1.02

    def test_without_torque_friction_brings_it_to_rest(self):
        shaft = self.shaft()
        self.live(shaft, math.pi, 0.3)
        speed, here = shaft.rate, shaft.turned
        shaft.powerless = True
        self.live(shaft, math.pi, 5.0)
        assert shaft.rate == 0.0
        assert shaft.turned - here == pytest.approx(speed**2 / (2 * Drive().friction), rel=0.05)

    def test_a_weak_motor_does_not_overcome_friction(self):
        shaft = self.shaft(acceleration=1.0, friction=2.0)
        self.live(shaft, GOAL, 1.0)
        assert shaft.turned == 0.0

    def test_the_load_lags_by_half_of_the_play_on_either_side(self):
        play = math.radians(2)
        shaft = self.shaft(backlash=play)
        for goal, side in ((GOAL, -1), (-GOAL, 1)):
            self.live(shaft, goal, 1.5)
            assert shaft.turned == pytest.approx(shaft.angle + side * play / 2, abs=1e-9)

    def test_an_encoder_on_the_load_takes_the_play_out(self):
        shaft = self.shaft(backlash=math.radians(2), encoder="load")
        self.live(shaft, GOAL, 1.5)
        assert shaft.turned == pytest.approx(GOAL, abs=math.radians(0.3))

    @pytest.mark.parametrize("counts", [64, 4096])
    def test_the_encoder_is_as_coarse_as_its_counts(self, counts):
        shaft = self.shaft(counts=counts)
        shaft.place(1.0)
        unit = 2 * math.pi / counts
        assert abs(shaft.reported - 1.0) <= unit / 2
        assert shaft.reported / unit == pytest.approx(round(shaft.reported / unit))

    def test_a_noisy_encoder_trembles_by_degrees(self):
        shaft = self.shaft()
        shaft.noisy = True
        reports = np.degrees([shaft.reported for _ in range(1000)])
        assert reports.std() == pytest.approx(2.0, rel=0.1)


class Lab:
    """A servo and somebody with node id 9 who asks it."""

    def __init__(self, **options):
        self.options = Options(**options)
        self.end = far_end.make(self.options)
        self.now = 0.0
        self.voice, self.ear = Encoder(9), Decoder(9)
        self.heard = []

    def say(self, frames):
        for each in frames:
            self.end.port.send(each)

    def live(self, seconds):
        self.heard = []
        for _ in range(round(seconds / TEN_MS)):
            self.now = round(self.now + TEN_MS, 6)
            self.end.advance(self.now)
            self.heard += [each for each in map(self.ear.feed, self.end.port.receive()) if each is not None]
        return self

    def answers(self, kind):
        return [each.response for each in self.heard if hasattr(each, "response") and isinstance(each.response, kind)]

    def messages(self, kind):
        return [each.message for each in self.heard if hasattr(each, "message") and isinstance(each.message, kind)]

    def command(self, value, kind=CommandKind.UNITLESS):
        self.say(Encoder(9).broadcast(ArrayCommand((Command(1, kind, value),))))

    @property
    def degrees(self):
        return math.degrees(self.end.angle())


def test_it_reports_at_50_hz_where_it_is_and_not_where_it_was_told_to_be():
    lab = Lab()
    lab.command(0.5)
    lab.live(0.09)
    assert len(lab.messages(Status)) == 5
    assert math.degrees(lab.messages(Status)[-1].position) == pytest.approx(lab.degrees, abs=0.2)
    assert lab.degrees < 50


def test_commands_of_another_kind_or_that_are_no_number_are_not_obeyed():
    lab = Lab()
    lab.command(1.0, CommandKind.POSITION)
    lab.command(math.nan)
    lab.live(1.0)
    assert lab.degrees == 0.0


def test_it_says_who_it_is():
    lab = Lab()
    lab.say(lab.voice.request(NodeInfoRequest(), 50))
    (info,) = lab.live(0.05).answers(NodeInfo)
    assert (info.name, len(info.unique_id)) == ("org.ross.servo", 16)


@pytest.mark.parametrize(("magic", "boots"), [(MAGIC, True), (1, False)])
def test_it_boots_when_it_is_asked_in_earnest(magic, boots):
    lab = Lab()
    lab.live(3.0)
    lab.say(lab.voice.request(RestartRequest(magic), 50))
    (answer,) = lab.live(1.5).answers(RestartResponse)
    assert answer.ok is boots
    assert (lab.messages(NodeStatus)[-1].uptime < 3) is boots


def test_what_turns_slips_and_the_encoder_sees_nothing_of_it():
    lab = Lab()
    lab.live(0.5)
    lab.end.afflict(Fault.SLIP)
    lab.live(0.5)
    assert lab.degrees == pytest.approx(math.degrees(SLIP))
    assert lab.messages(Status)[-1].position == 0.0


def test_an_encoder_on_the_load_sees_a_slip_and_the_servo_turns_back():
    end = far_end.make(Options(), replace(Drive(), encoder="load"))
    end.port.sent += Encoder(9).broadcast(ArrayCommand((Command(1, 0, 0.0),)))
    end.advance(0.1)
    end.afflict(Fault.SLIP)
    end.advance(1.5)
    assert math.degrees(end.angle()) == pytest.approx(0.0, abs=0.2)


@pytest.mark.parametrize("fault", sorted(OF_DEVICES))
def test_every_fault_ends_as_it_began(fault):
    lab = Lab()
    lab.live(0.2)
    for on in (True, False):
        lab.end.afflict(fault, on)
        lab.live(0.3)
    lab.command(0.25)
    lab.live(1.5)
    assert lab.messages(Status)
    slipped = 10 if fault is Fault.SLIP else 0
    assert lab.degrees == pytest.approx(50 + slipped, abs=0.3)


def test_a_servo_without_position_cannot_have_a_noisy_one():
    end = far_end.make(Options(feedback="model"))
    with pytest.raises(ValueError, match=r"expected one of .*, got 'noisy'"):
        end.afflict(Fault.NOISY)


def test_two_lives_are_the_same_to_the_last_bit():
    def life():
        lab = Lab()
        lab.end.afflict(Fault.CORRUPT)
        lab.end.afflict(Fault.NOISY)
        lab.command(0.3)
        return repr(lab.live(1.0).heard), lab.end.angle()

    assert life() == life()
