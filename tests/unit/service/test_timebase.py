"""Which time it is, and how the autopilot's clock lies to ours."""

import math
from datetime import UTC, datetime
from itertools import pairwise

import pytest

from ross_payload.timebase import Timebase
from ross_protocols.mavlink import vehicle
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.dialect import common
from ross_protocols.mavlink.vehicle import SystemTime, TimeSync
from ross_sim.clock import SimClock

UNIX = 1_795_000_000.0  # [s]


class Heard:
    def __init__(self, message, role="autopilot", system_id=1, component_id=1):
        self.link, self.role = "udpin:autopilot:1", role
        (self.packet,) = Decoder().feed(Encoder(system_id, component_id).encode(message))


class Voice:
    """Remembers what was sent."""

    id = ComponentId(1, 191)

    def __init__(self):
        self.sent = []

    def send(self, value, link=None):
        self.sent.append((vehicle.read(value), link))

    def subscribe(self, call):
        self.call = call


def heartbeat():
    return common.MAVLink_heartbeat_message(2, 3, 0, 0, 3, 3)


@pytest.fixture
def bench():
    clock, voice = SimClock(), Voice()
    clock.sleep(5.0)
    timebase = Timebase(clock)
    timebase.attach(voice)
    return clock, voice, timebase


def trip(bench, there, back, ahead):
    """One round trip to a clock that is `ahead` [s] of ours."""
    clock, voice, _ = bench
    voice.call(Heard(heartbeat()))
    asked = voice.sent[-1][0].asked
    clock.sleep(there)
    answered = round((clock.now() + ahead) * 1e9)
    clock.sleep(back)
    voice.call(Heard(vehicle.time_sync(TimeSync(asked, answered))))


def test_time_counts_from_the_boot_until_a_clock_can_be_trusted(bench):
    clock, voice, timebase = bench
    assert (timebase.usec(), timebase.unix) == (5_000_000, False)
    voice.call(Heard(vehicle.system_time(SystemTime(boot=1.0, unix=UNIX))))
    assert timebase.unix
    assert timebase.usec() == pytest.approx(UNIX * 1e6)
    clock.sleep(2.0)
    assert timebase.usec() == pytest.approx((UNIX + 2.0) * 1e6)


@pytest.mark.parametrize("unix", [None, 12.0, 1_000_000_000.0, 5_000_000_000.0])
def test_an_autopilot_without_a_time_is_not_believed(bench, unix):
    _, voice, timebase = bench
    voice.call(Heard(vehicle.system_time(SystemTime(boot=1.0, unix=unix))))
    assert not timebase.unix


@pytest.mark.parametrize("changes", [{"role": "ground"}, {"component_id": 191}, {"system_id": 9}])
def test_only_the_autopilot_tells_the_time(bench, changes):
    _, voice, timebase = bench
    voice.call(Heard(heartbeat()))
    voice.call(Heard(vehicle.system_time(SystemTime(boot=1.0, unix=UNIX)), **changes))
    assert not timebase.unix


def test_a_systems_clock_that_is_synchronised_serves_at_once():
    clock = SimClock()
    assert Timebase(clock, lambda: UNIX).usec() == round(UNIX * 1e6)
    assert not Timebase(clock, lambda: None).unix


@pytest.mark.parametrize("suspended", [3600.0, 0.2, -7.0])
def test_a_systems_clock_is_followed_while_no_autopilot_tells_the_time(bench, suspended):
    """While the computer is suspended ours stands still; and what keeps the system's right may set it."""
    clock, voice, _ = bench
    ahead, known = [UNIX], [True]
    timebase = Timebase(clock, lambda: clock.now() + ahead[0] if known[0] else None)
    timebase.attach(voice)

    def off():
        clock.sleep(10.0)
        return timebase.utc().timestamp() - clock.now() - UNIX

    assert off() == pytest.approx(0.0, abs=1e-5)
    ahead[0] += suspended
    assert abs(off() - suspended) < 0.5
    known[0], ahead[0] = False, 0.0
    assert abs(off() - suspended) < 0.5, "not known to be right any more, it is not believed"
    known[0] = True
    voice.call(Heard(vehicle.system_time(SystemTime(boot=1.0, unix=UNIX + clock.now()))))
    assert abs(off()) < 0.5, "an autopilot goes before it"


def test_time_never_runs_backwards(bench):
    clock, voice, timebase = bench
    times = []
    for unix in (UNIX, UNIX - 100.0, UNIX + 3.0, UNIX + 2.9, UNIX - 50.0):
        voice.call(Heard(vehicle.system_time(SystemTime(boot=1.0, unix=unix))))
        clock.sleep(0.1)
        times.append(timebase.usec())
    assert times == sorted(times)


def test_time_goes_on_after_a_clock_was_set_back_and_agrees_with_it_in_the_end(bench):
    clock, voice, timebase = bench
    times, began = [], clock.now()
    for second in range(200):
        back = 0.0 if second < 10 else 18.0  # the leap seconds of GPS, known at last
        voice.call(Heard(vehicle.system_time(SystemTime(boot=clock.now(), unix=UNIX + clock.now() - began - back))))
        times.append(timebase.usec() / 1e6)
        clock.sleep(1.0)
    steps = [later - time for time, later in pairwise(times)]
    assert 0.89 < min(steps) < 0.91
    assert max(steps) < 1.01
    assert times[9] == pytest.approx(UNIX + 9, abs=1e-3)
    assert times[-1] == pytest.approx(UNIX + 199 - 18, abs=1e-3)


def test_the_date_is_the_autopilots_where_only_that_has_a_clock(bench):
    """Our computer's may say anything: it has none that runs while it is off."""
    _, voice, timebase = bench
    assert timebase.utc() is None
    voice.call(Heard(vehicle.system_time(SystemTime(boot=1.0, unix=UNIX))))
    assert timebase.utc() == datetime(2026, 11, 18, 11, 6, 40, tzinfo=UTC)


def test_a_wrong_date_does_not_stay(bench):
    """By the date recordings are named, and deleted: 2037 for decades would delete all of them."""
    _, voice, timebase = bench
    for boot, ahead in ((1.0, 0.0), (2.0, 11 * 31_557_600.0), (3.0, 0.0)):
        for later in range(1 + (ahead > 0)):  # a single one is not taken
            voice.call(Heard(vehicle.system_time(SystemTime(boot=boot + 0.1 * later, unix=UNIX + ahead))))
        timebase.usec()
        assert timebase.utc() == datetime.fromtimestamp(UNIX + ahead, UTC)


def test_one_wrong_date_far_ahead_is_not_taken_and_one_that_stays_is(bench):
    """While it is the date, recordings are deleted by it, and time stamps never come back from it."""
    _, voice, timebase = bench
    years = 11 * 31_557_600.0
    for boot, told, taken in ((1, 0, 0), (2, years, 0), (3, 0, 0), (4, years, 0), (5, years, years), (6, 0, 0)):
        for _ in range(2):  # over two links
            voice.call(Heard(vehicle.system_time(SystemTime(boot=float(boot), unix=UNIX + told))))
        assert timebase.utc() == datetime.fromtimestamp(UNIX + taken, UTC)
        if boot < 5:
            assert timebase.usec() == pytest.approx(UNIX * 1e6)


@pytest.mark.parametrize("step", [86_000.0, 11 * 31_557_600.0])
def test_a_date_that_leaps_ahead_is_told_until_it_has_stood_for_a_day(bench, step):
    """Also one that leaps in steps, each of less than a day."""
    clock, voice, timebase = bench

    def leaps_at(unix):
        for _ in range(2):  # a single one far ahead is not taken
            clock.sleep(1.0)
            voice.call(Heard(vehicle.system_time(SystemTime(boot=clock.now(), unix=unix + clock.now()))))
        return timebase.leapt

    assert not timebase.leapt
    assert [leaps_at(UNIX + ahead) for ahead in (0.0, step, 2 * step, 0.0)] == [False, step > 86_400, True, False]
    assert not leaps_at(UNIX - step)
    clock.sleep(100_000.0)  # time that passes is no leap
    assert not leaps_at(UNIX - step)
    assert leaps_at(UNIX + step)
    clock.sleep(80_000.0)
    assert leaps_at(UNIX + step)
    clock.sleep(6_400.0)
    assert not leaps_at(UNIX + step)


def test_a_date_ahead_of_a_synchronised_clock_has_leapt(bench):
    clock, voice, _ = bench
    timebase = Timebase(clock, lambda: UNIX)
    timebase.attach(voice)
    assert timebase.utc() is not None
    for boot in (1.0, 2.0):
        voice.call(Heard(vehicle.system_time(SystemTime(boot=boot, unix=UNIX + 1e8))))
    assert timebase.leapt


def test_the_first_look_at_a_date_that_has_leapt_does_not_take_it_for_sure():
    """By this very look recordings would be deleted."""
    clock, ahead = SimClock(), [UNIX]
    timebase = Timebase(clock, lambda: clock.now() + ahead[0])
    assert timebase.sure_utc() == timebase.utc() is not None
    ahead[0] += 1e8
    clock.sleep(60.0)
    assert timebase.sure_utc() is None
    assert timebase.utc() is not None


@pytest.mark.parametrize("ahead", [0.0, 3600.0, -3600.0])
def test_a_date_that_the_clock_of_the_computer_confirms_is_sure_at_once(bench, ahead):
    clock, voice, _ = bench
    timebase = Timebase(clock, unkept=lambda: UNIX + clock.now() + ahead)
    timebase.attach(voice)
    assert timebase.sure_utc() is timebase.utc() is None
    voice.call(Heard(vehicle.system_time(SystemTime(boot=clock.now(), unix=UNIX + clock.now()))))
    assert timebase.sure_utc() == timebase.utc() is not None


@pytest.mark.parametrize("computer", [lambda: UNIX, lambda: UNIX + 2e8, lambda: None])
def test_a_date_that_nobody_confirms_is_sure_when_it_has_stood_for_a_day(bench, caplog, computer):
    """It may be wrong from the start, as that of a satellite receiver that is misled; recordings were deleted by it."""
    clock, voice, _ = bench
    timebase = Timebase(clock, unkept=computer)
    timebase.attach(voice)
    for wait, sure in ((1.0, False), (80_000.0, False), (6_500.0, True)):
        clock.sleep(wait)
        voice.call(Heard(vehicle.system_time(SystemTime(boot=clock.now(), unix=UNIX + 1e8 + clock.now()))))
        assert (timebase.sure_utc() is not None) is sure
        assert timebase.utc() is not None
    assert caplog.text.count("nobody confirms the date that the autopilot tells") == 1


def test_a_date_against_that_of_the_network_never_deletes_anything(bench):
    clock, voice, _ = bench
    timebase = Timebase(clock, lambda: UNIX + clock.now())
    timebase.attach(voice)
    for wait in (1.0, 100_000.0, 100_000.0):
        clock.sleep(wait)
        for _ in range(2):  # a single one far ahead is not taken
            clock.sleep(1.0)
            voice.call(Heard(vehicle.system_time(SystemTime(boot=clock.now(), unix=UNIX + 1e8 + clock.now()))))
        assert timebase.sure_utc() is None is not timebase.utc()


def test_a_small_difference_is_worked_off_and_not_jumped(bench):
    _, voice, timebase = bench
    voice.call(Heard(vehicle.system_time(SystemTime(boot=1.0, unix=UNIX))))
    before = timebase.usec()
    voice.call(Heard(vehicle.system_time(SystemTime(boot=1.0, unix=UNIX + 0.2))))
    assert 0 < timebase.usec() - before < 0.05e6


def test_a_request_is_answered_to_whoever_asks_where_it_came_from(bench):
    clock, voice, _ = bench
    request = vehicle.time_sync(TimeSync(77, target=voice.id))
    voice.call(Heard(request, role="ground", system_id=255, component_id=190))
    assert voice.sent == [(TimeSync(77, round(clock.now() * 1e9), ComponentId(255, 190)), "udpin:autopilot:1")]


@pytest.mark.parametrize("asking", [(1, 1), (1, 240), (255, 190)])
@pytest.mark.parametrize("target", [None, (0, 0), (1, 0)])
def test_a_request_to_everybody_is_left_to_the_autopilot(bench, target, asking):
    """PX4 and MAVROS ask everybody, and take an answer of anybody for the other one's clock."""
    _, voice, _ = bench
    request = common.MAVLink_timesync_message(0, 77)  # a client without targets
    if target is not None:
        request = vehicle.time_sync(TimeSync(77, target=ComponentId(*target)))
    system, component = asking
    voice.call(Heard(request, role="ground", system_id=system, component_id=component))
    assert not voice.sent


@pytest.mark.parametrize("target", [(1, 1), (2, 0), (2, 191)])
def test_a_request_to_somebody_else_is_not_answered(bench, target):
    _, voice, _ = bench
    request = vehicle.time_sync(TimeSync(77, target=ComponentId(*target)))
    voice.call(Heard(request, role="ground", system_id=255, component_id=190))
    assert not voice.sent


def test_the_autopilot_alone_is_asked(bench):
    _, voice, _ = bench
    voice.call(Heard(heartbeat()))
    assert [said.target for said, _ in voice.sent] == [ComponentId(1, 1)]


def test_a_flood_of_requests_is_not_answered_by_a_flood(bench):
    clock, voice, _ = bench
    for _ in range(100):
        for number in range(50):
            voice.call(Heard(vehicle.time_sync(TimeSync(asked=number + 1, target=voice.id))))
        clock.sleep(0.01)
    assert 25 <= len(voice.sent) <= 51


def test_an_answer_is_not_answered(bench):
    _, voice, _ = bench
    voice.call(Heard(vehicle.time_sync(TimeSync(asked=77, answered=99))))
    assert not voice.sent


def test_a_round_trip_tells_how_the_clocks_lie_to_each_other(bench):
    clock, _voice, timebase = bench
    assert timebase.local(100.0) is None
    trip(bench, there=0.02, back=0.02, ahead=95.0)
    assert timebase.local(clock.now() + 95.0) == pytest.approx(clock.now(), abs=1e-6)


def test_the_quickest_of_many_round_trips_counts(bench):
    clock, _voice, timebase = bench
    for there, back in ((0.02, 0.3), (0.01, 0.01), (0.2, 0.02)):
        trip(bench, there, back, ahead=95.0)
    assert timebase.local(clock.now() + 95.0) == pytest.approx(clock.now(), abs=0.002)


def test_an_answer_to_what_was_never_asked_tells_nothing(bench):
    _, voice, timebase = bench
    voice.call(Heard(heartbeat()))
    voice.call(Heard(vehicle.time_sync(TimeSync(asked=123, answered=456))))
    assert timebase.local(0.0) is None


def test_an_answer_that_comes_after_a_second_tells_nothing(bench):
    _clock, _voice, timebase = bench
    trip(bench, there=0.6, back=0.6, ahead=95.0)
    assert timebase.local(0.0) is None


def test_an_autopilot_that_has_rebooted_counts_again(bench):
    clock, _voice, timebase = bench
    for ahead in (95.0, 95.0, -3.0):
        trip(bench, 0.02, 0.02, ahead)
    assert timebase.local(clock.now() - 3.0) == pytest.approx(clock.now(), abs=1e-6)


def test_the_time_of_an_autopilot_that_has_rebooted_is_believed_before_it_answers(bench):
    """Its real-time clock runs on, and what it counts from its start starts again."""
    clock, voice, timebase = bench
    trip(bench, 0.02, 0.02, ahead=3600.0)
    voice.call(Heard(vehicle.system_time(SystemTime(clock.now() + 3600.0, UNIX + clock.now()))))
    clock.sleep(3.0)
    voice.call(Heard(vehicle.system_time(SystemTime(1.0, UNIX + clock.now()))))
    clock.sleep(1.0)
    voice.call(Heard(vehicle.system_time(SystemTime(2.0, UNIX + clock.now()))))
    assert timebase.usec() / 1e6 == pytest.approx(UNIX + clock.now(), abs=0.1)


def test_a_late_copy_of_the_time_is_no_reboot(bench):
    """Two links of one autopilot, one of them 1.6 s late."""
    clock, voice, timebase = bench
    trip(bench, 0.02, 0.02, ahead=3600.0)
    for _ in range(10):
        now = clock.now()
        voice.call(Heard(vehicle.system_time(SystemTime(now + 3600.0, UNIX + now))))
        voice.call(Heard(vehicle.system_time(SystemTime(now + 3600.0 - 1.6, UNIX + now - 1.6))))
        clock.sleep(1.0)
        assert timebase.local(clock.now() + 3600.0) is not None
    assert timebase.usec() / 1e6 == pytest.approx(UNIX + clock.now(), abs=0.05)


@pytest.mark.parametrize("roll", [math.inf, -math.inf, math.nan])
@pytest.mark.parametrize("sender", [{}, {"role": "ground", "system_id": 77, "component_id": 88}])
def test_an_attitude_of_impossible_angles_is_nothing(bench, roll, sender):
    _, voice, _ = bench
    for roll_and_pitch in ((roll, 0.0), (0.0, roll), (roll, roll)):
        message = common.MAVLink_attitude_message(0, *roll_and_pitch, 0.1, 0.1, 0.1, 0.1)
        voice.call(Heard(message, **sender))
        assert vehicle.read(message) is None


def test_we_ask_once_for_every_heartbeat_and_no_more(bench):
    _, voice, _ = bench
    for _ in range(3):
        voice.call(Heard(heartbeat()))
    assert [value.answered for value, _ in voice.sent] == [None] * 3
