"""Three processes in real time: an autopilot with its gimbal, the payload, and a ground station's pilot (the test)."""

from __future__ import annotations

import math
import signal
import subprocess
import time

from pymavlink.dialects.v20 import ardupilotmega

from processes import ROSS
from ross_protocols.mavlink.tunnel import unwrap
from ross_protocols.mavlink.vehicle import euler
from waiting import wait_for

PITCH_YAW, CONFIGURE, REQUEST_MESSAGE, MANAGER_STATUS = 1000, 1001, 512, 281
ACCEPTED = 0
PAYLOAD = """
audio.source = "{source}"
actuator = {{ kind = "mavlink_gimbal" }}
service = {{ state_dir = "state", log_format = "json" }}
[[links]]
url = "udpout:127.0.0.1:{port}"
role = "autopilot"
"""


class GimbalAutopilot:
    """``ross autopilot --gimbal`` between a payload and a ground station; it may be frozen, killed, started again."""

    def __init__(self, port: int, ground: int) -> None:
        links = ["--link", f"udpin:127.0.0.1:{port}", "--link", f"udpout:127.0.0.1:{ground}"]
        self._command = [*ROSS, "autopilot", "--gimbal", *links]
        self.start()

    def start(self) -> None:
        self._process = subprocess.Popen(self._command, stdout=subprocess.PIPE, text=True)
        assert self._process.stdout and self._process.stdout.readline() == "ready\n"

    def freeze(self) -> None:
        self._process.send_signal(signal.SIGSTOP)

    def go_on(self) -> None:
        self._process.send_signal(signal.SIGCONT)

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()
        if self._process.stdout:
            self._process.stdout.close()


class Pilot:
    """What a ground station sees and asks of gimbal and payload; angles in degrees, clockwise from the nose."""

    def __init__(self, ground, payload) -> None:
        self.ground, self.payload, self.until = ground, payload, wait_for

    def ask(self, number, *values):
        """Send a command to the autopilot; return its answer."""
        before = len(self.ground.of("COMMAND_ACK", 1))
        numbers = [*values, *[0.0] * (7 - len(values))]
        self.ground.link.mav.send(ardupilotmega.MAVLink_command_long_message(1, 1, number, 0, *map(float, numbers)))
        fits = lambda: [ack for ack in self.ground.of("COMMAND_ACK", 1)[before:] if ack.command == number]  # noqa: E731
        return self.until(fits)[0].result

    def point(self, yaw):
        """Have the autopilot point the gimbal (command 1000)."""
        return self.ask(PITCH_YAW, 0.0, yaw, math.nan, math.nan, 12.0)

    def configure(self, control):
        """Take control (-2) or release it (-3)."""
        return self.ask(CONFIGURE, control, control, -1.0, -1.0)

    def primary(self):
        """Who is in control, as the manager answers now."""
        before = len(self.ground.of("GIMBAL_MANAGER_STATUS", 1))
        assert self.ask(REQUEST_MESSAGE, MANAGER_STATUS) == ACCEPTED
        said = self.until(lambda: self.ground.of("GIMBAL_MANAGER_STATUS", 1)[before:])[-1]
        return said.primary_control_sysid, said.primary_control_compid

    def yaw(self):
        """Where the gimbal said last that it is."""
        said = self.ground.of("GIMBAL_DEVICE_ATTITUDE_STATUS", 154)
        return math.degrees(euler(said[-1].q)[0]) if said else math.nan

    def moved(self, yaw, since):
        """Reports, from the one with this index on, that show another yaw than this one."""
        said = self.ground.of("GIMBAL_DEVICE_ATTITUDE_STATUS", 154)[since:]
        return [one for one in said if abs(math.degrees(euler(one.q)[0]) - yaw) > 0.1]

    def reaches(self, yaw, seconds=3.0, within=1.0):
        """Wait until the gimbal stands there; return whether it came in time."""
        end = time.monotonic() + seconds
        while abs(self.yaw() - yaw) > within:
            if time.monotonic() > end:
                return False
            time.sleep(0.01)
        return True

    def status(self):
        """The payload's latest ROSS_STATUS."""
        packets = [unwrap(message) for message in self.ground.of("TUNNEL")[-20:]]
        said = [packet.message for packet in packets if packet and packet.name == "ROSS_STATUS"]
        return said[-1] if said else None

    def heading(self):
        """Where the payload says its joint is."""
        status = self.status()
        return math.nan if status is None else math.degrees(status.joint)

    def faults(self):
        """What the payload logged of faults."""
        return [line for line in self.payload.log() if line["message"].startswith("fault")]

    def hears_the_payload(self):
        """Wait until the autopilot passes on what the payload says, and so what it is told."""
        before = len(self.ground.of("HEARTBEAT"))
        self.until(lambda: self.ground.of("HEARTBEAT")[before:])
