"""What QGroundControl does with a gimbal, as its source has it: it asks, completes, takes control, pans, gives back."""

from contextlib import ExitStack

import pytest

from gimbal_bench import ACCEPTED, CONFIGURE, GROUND, INTERVAL, NAN, POINT, REQUEST, GimbalBench

INFORMATION, STATUS, ATTITUDE = 280, 281, 285
REQUESTS, RENEWED = 6, 0.5  # times that it asks; [s] between two rates


class QGroundControl:
    """Asks for what is missing at every heartbeat; a gimbal is complete when all three messages have come."""

    def __init__(self, bench):
        self._bench, self._station, self._left = bench, bench.ground, REQUESTS
        self.complete = None  # when [s]
        self._seen = 0
        bench.clock.before_calls(self._listen)

    def _listen(self, now):
        heard = self._bench.wires[GROUND].heard
        for time, packet in heard[self._seen :]:
            if packet.name == "HEARTBEAT" and packet.component_id == 154:
                self._ask(time)
        self._seen = len(heard)
        names = {packet.name for _, packet in heard}
        wanted = {"GIMBAL_MANAGER_INFORMATION", "GIMBAL_MANAGER_STATUS", "GIMBAL_DEVICE_ATTITUDE_STATUS"}
        if self.complete is None and wanted <= names:
            self.complete = now

    def _ask(self, now):
        if not self._bench.told("GIMBAL_MANAGER_INFORMATION") and self._left:
            self._left -= 1
            self._station.command(now, REQUEST, INFORMATION)[1]()
        for number in (STATUS, ATTITUDE):
            self._station.command(now, INTERVAL, number, 0)[1]()


@pytest.fixture
def bench():
    with ExitStack() as stack:
        yield GimbalBench(stack, "standalone")


def test_it_shows_the_gimbal_within_a_second(bench):
    ground = QGroundControl(bench)
    bench.live(6.0)
    first = next(time for time, packet in bench.wires[GROUND].heard if packet.component_id == 154)
    assert ground.complete - first < 1.0
    assert len(bench.told("GIMBAL_MANAGER_INFORMATION")) == 1
    assert set(bench.results(INTERVAL)) == {ACCEPTED}


def test_all_messages_name_one_device_that_is_no_component(bench):
    QGroundControl(bench)
    bench.live(6.0)
    names = ("GIMBAL_MANAGER_INFORMATION", "GIMBAL_MANAGER_STATUS", "GIMBAL_DEVICE_ATTITUDE_STATUS")
    ids = {said.gimbal_device_id for name in names for said in bench.told(name)}
    assert ids == {1}  # it drops attitudes of a device above 6


def test_it_pans_as_long_as_a_button_is_held(bench):
    take, give = (255, 190, -1, -1, NAN, NAN, 1), (-3, -3, -1, -1, NAN, NAN, 1)
    rates = [bench.ground.command(3.1 + RENEWED * step, POINT, NAN, NAN, 0, 15, 12, 0, 1) for step in range(6)]
    bench.live(
        10.0,
        bench.ground.command(3.0, CONFIGURE, *take),
        *rates,
        bench.ground.command(6.1, POINT, NAN, NAN, 0, 0, 12, 0, 1),
        bench.ground.command(8.0, CONFIGURE, *give),
    )
    assert [bench.speed(time) for time in (4.0, 5.0, 6.0)] == pytest.approx([-15] * 3, abs=0.5)
    assert bench.speed(7.0) == 0.0
    assert (bench.primary(5.0), bench.primary(9.0)) == ((255, 190), (0, 0))
    assert set(bench.results(POINT)) == {ACCEPTED}


def test_its_centre_button_looks_forward(bench):
    bench.live(
        9.0,
        bench.ground.command(3.0, POINT, 0, 40, NAN, NAN, 12 | 32, 0, 1),
        bench.ground.command(6.0, POINT, 0, 0, NAN, NAN, 12 | 32, 0, 1),
    )
    assert (bench.angle(5.9), bench.angle(8.9)) == pytest.approx((-40, 0), abs=0.05)
