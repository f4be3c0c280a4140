"""The grbl driver over a socket, in real time: who drives a motor notices when reports are late."""

import pytest

from ross_payload.actuators.grbl.driver import backend
from ross_payload.actuators.grbl.options import Options
from ross_payload.actuators.wires import open_wire
from ross_payload.clock import SystemClock
from ross_payload.interfaces import Services
from ross_sim.devices.grbl_far_end import far_end
from ross_sim.devices.wire_servers import WireServer, side_of


def test_over_tcp_it_turns_in_real_time_as_in_simulated():
    clock = SystemClock()
    end, epoch = far_end.make(Options()), clock.now()
    side = side_of("serial", end.port, epoch)
    with WireServer("127.0.0.1", 0, side, clock) as server:
        options = Options(port=f"serial:tcp:127.0.0.1:{server.port}")
        deadline = clock.now() + 60

        def live(until):
            while not until():
                assert clock.now() < deadline, actuator.state()
                clock.sleep(0.005)
                side.exchange(clock.now() - epoch)
                end.advance(clock.now() - epoch)
                actuator.poll(clock.now())

        with backend.open(options, Services(clock, lambda url: open_wire(url, clock))) as actuator:
            live(lambda: actuator.state().homed and actuator.state().settled)
            actuator.command(0.5)
            live(lambda: actuator.state().settled)
    assert end.angle() == pytest.approx(0.5, abs=options.resolution)
