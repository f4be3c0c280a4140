"""The scheme ``pulses``: into the void, to a device in another process, or to the pins of this computer."""

from __future__ import annotations

from ross_payload.actuators.tb6600.pulse_segments import RECORDING, PulseCodec, RecordingPulses
from ross_payload.actuators.wires import connect, served_at
from ross_payload.actuators.wires.gpio import SCHEME, open_pins, pins_of
from ross_payload.errors import ConfigError
from ross_payload.interfaces import Clock, Port

KNOWN = f"{RECORDING}, pulses:tcp:HOST:PORT, {SCHEME}CHIP:STEP,DIRECTION,ENABLE[,HOME]"


class PulseWire:
    """The scheme ``pulses``."""

    def open(self, url: str, clock: Clock) -> Port:
        """Open a port for edges.

        Raises
        ------
        ConfigError
            When the URL names none that exists.
        LinkError
            When it cannot be opened.
        """
        self.check(url)
        if url == RECORDING:
            return RecordingPulses(clock.now)
        if url.startswith("pulses:tcp:"):
            return connect(url, PulseCodec(), clock)
        return open_pins(url, clock)

    def check(self, url: str) -> None:
        """Refuse a URL that names no port.

        Raises
        ------
        ConfigError
            When it names none that exists.
        """
        if url.startswith("pulses:tcp:"):
            served_at(url)
        elif url.startswith(SCHEME):
            pins_of(url)
        elif url != RECORDING:
            raise ConfigError(f"pulse port '{url}' is unknown; there are: {KNOWN}")


wire = PulseWire()
