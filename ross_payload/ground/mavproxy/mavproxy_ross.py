"""The module that MAVProxy loads; `ross mavproxy` does so. Importing it needs no MAVProxy, only `init` does."""

from __future__ import annotations

import time
from typing import Any

from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.mavproxy.shell import COMPLETIONS, Shell
from ross_protocols.mavlink.codec import Packet
from ross_protocols.mavlink.component_id import ComponentId

TICK_S = 0.1
COLOURS = {"good": "green", "act": "red", "unknown": "grey"}
ROW = 6  # of MAVProxy's status bar, below its own


class Hooks:
    """What MAVProxy calls, on top of its own module class."""

    def __init__(self, mpstate: Any) -> None:
        super().__init__(mpstate, "ross", "the payload that turns to listen", public=True, multi_vehicle=True)  # type: ignore[call-arg]
        self._state = mpstate
        orders = CommandProtocol(self._send, mpstate.settings.source_system, mpstate.settings.source_component)
        self._shell = Shell(orders, print)
        self._due = 0.0
        self._shown = ("", "")  # in the status bar
        self.add_command("ross", self._shell.execute, "RoSS: ross help", COMPLETIONS)  # type: ignore[attr-defined]

    def mavlink_packet(self, message: Any) -> None:
        """Take what MAVProxy has read."""
        if message.get_type() == "BAD_DATA":
            return
        system, component = message.get_srcSystem(), message.get_srcComponent()
        frame = bytes(message.get_msgbuf())
        packet = Packet(system, component, message.get_seq(), message.get_type(), message, frame)
        self._shell.on_packet(packet, time.monotonic())

    def idle_task(self) -> None:
        """Let time go on, and show it where there is a console."""
        now = time.monotonic()
        if now < self._due:
            return
        self._due = now + TICK_S
        self._shell.tick(now)
        shown = self._shell.summary()
        if shown != self._shown:
            self._shown = shown
            self._state.console.set_status("ROSS", shown[0], row=ROW, fg=COLOURS[shown[1]])

    def _send(self, message: Any, who: ComponentId) -> None:
        """Send on the link on which the payload's system was heard last; two would let it refuse the second one."""
        links = list(self._state.mav_master)
        active = [link for link in links if _last_heartbeat(link, who)]
        for link in [max(active, key=lambda link: _last_heartbeat(link, who))] if active else links:
            link.mav.send(message)


def _last_heartbeat(link: Any, who: ComponentId) -> float:
    """When a system was heard on one of MAVProxy's links, UNIX time [s]; 0: never."""
    system = getattr(link, "sysid_state", {}).get(who.system)
    beat = None if system is None else system.messages.get("HEARTBEAT")
    return float(getattr(beat, "_timestamp", 0.0))


def init(mpstate: Any) -> Any:
    """Return the module; MAVProxy calls this."""
    from MAVProxy.modules.lib.mp_module import MPModule

    class RossModule(Hooks, MPModule):  # type: ignore[misc]
        """The module."""

    return RossModule(mpstate)
