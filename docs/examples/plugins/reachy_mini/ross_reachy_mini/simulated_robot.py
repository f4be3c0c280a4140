"""A Reachy Mini that is simulated: what its daemon takes and tells, and a head that follows its target with a lag.

It is the far end of the driver in simulated time; `emulated_daemon` serves it over the network.
"""

import math

from ross_sim.devices.far_end import Fault, WireEnd, checked

REPORT_S = 0.020  # between two reports, with frequency=50
LAG_S = 0.015  # time constant of head and body behind their targets
MOST_RAD_S = math.radians(400)  # no faster, however far the target is
BODY, DELTA = math.radians(160), math.radians(65)  # limits that the daemon clamps to
UPRIGHT = {"x": 0.0, "y": 0.0, "z": 0.0, "roll": 0.0, "pitch": 0.0, "yaw": 0.0}


class Robot:
    """Head and body, and the daemon's state."""

    faults = frozenset({Fault.SILENT, Fault.STUCK, Fault.TAKEN})

    def __init__(self):
        self.port = WireEnd()
        self.mode = "enabled"
        self._pose, self._target = dict(UPRIGHT), dict(UPRIGHT)
        self._body, self._body_target = 0.0, 0.0
        self._now, self._reported = 0.0, -math.inf
        self._wrong = set()
        self._complaints = []

    def advance(self, now):
        sent, self.port.sent = self.port.sent, []
        for frame in sent:
            self.take(frame)
        self.live(now)
        if now >= self._reported + REPORT_S - 1e-6:
            self._reported = now
            if Fault.SILENT not in self._wrong:
                self.port.arrived.append(self.state())

    def take(self, frame):
        """Do what the daemon is told."""
        if "motors" in frame:
            self.mode = frame["motors"]
            self._target, self._body_target = dict(self._pose), self._body
        elif Fault.TAKEN not in self._wrong:  # while a recorded move plays, targets are ignored
            self._set(frame)

    def live(self, now):
        """Follow the targets until ``now`` [s]."""
        step, self._now = now - self._now, now
        if self.mode != "enabled" or Fault.STUCK in self._wrong or step <= 0:
            return
        share = 1 - math.exp(-step / LAG_S)
        for key in self._pose:
            most = MOST_RAD_S * step
            self._pose[key] += min(max(share * (self._target[key] - self._pose[key]), -most), most)
        self._body += share * (self._body_target - self._body)

    def state(self):
        """What the daemon tells: a FullState."""
        return {"control_mode": self.mode, "head_pose": dict(self._pose), "body_yaw": self._body}

    def angle(self):
        return self._pose["yaw"]

    def afflict(self, fault, on=True):
        checked(fault, self.faults)
        (self._wrong.add if on else self._wrong.discard)(fault)

    def complaints(self):
        return self._complaints

    def lie_down(self):
        """Let the head hang, as asleep."""
        self._pose |= {"pitch": math.radians(35), "z": -0.03}
        self._target, self.mode = dict(self._pose), "disabled"

    def _set(self, frame):
        head, body = frame["target_head_pose"], frame.get("target_body_yaw", self._body_target)
        if abs(body) > BODY + 1e-9 or abs(head["yaw"] - body) > DELTA + 1e-9:
            self._complaints.append(f"a target beyond the limits: head {head['yaw']:.3f}, body {body:.3f} rad")
        self._body_target = min(max(body, -BODY), BODY)
        yaw = min(max(head["yaw"], self._body_target - DELTA), self._body_target + DELTA)
        self._target = {key: float(head[key]) for key in UPRIGHT} | {"yaw": yaw}


class Plugin:
    """Makes the robot; its head lags behind, and its rate is told from reports that come every 20 ms."""

    def __init__(self):
        self.slack = {"lag": 0.3, "ripple": 0.08, "late": 0.03}

    def make(self, config):
        return Robot()


far_end = Plugin()
