"""Between a payload's client and topics, whoever carries those: nothing here needs ROS."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable
from typing import Any

from ross_payload.ground import Payload
from ross_payload.ground.audio.rtp_port import RtpPort
from ross_payload.ground.client.payload import SILENT_S
from ross_ros2 import conversions
from ross_ros2.conversions import Fields

Publish = Callable[[str, str, Fields], None]  # topic, type of its message, fields

POSE_ARRAY, POSE = "geometry_msgs/msg/PoseArray", "geometry_msgs/msg/PoseStamped"
DIAGNOSTICS = "diagnostic_msgs/msg/DiagnosticArray"
AUDIO, AUDIO_INFO = "audio_common_msgs/msg/AudioData", "audio_common_msgs/msg/AudioInfo"
PERIOD_S = 0.1  # between two looks at what is known
BLOCK_S = 0.02  # of sound in one message


class Bridge:
    """Publishes what a payload tells, and turns it on request.

    Parameters
    ----------
    payload
        The connected client.
    publish
        Called on the client's loop.
    """

    def __init__(self, payload: Payload, publish: Publish) -> None:
        self._payload, self._publish = payload, publish
        self._heard: tuple[float | None, float] = None, -SILENT_S  # its last message, and when it was new

    async def run(self) -> None:
        """Publish bearings, heading and diagnostics until cancelled."""
        while True:
            self.say()
            await asyncio.sleep(PERIOD_S)

    def say(self) -> None:
        """Publish what is known now."""
        view, sources = self._payload.view, self._payload.sources
        pointing = view["pointing"]
        earth = bool(pointing["earth"])
        silent = self._silent(view["standing"]["last"])
        if not silent:
            self._publish("bearings", POSE_ARRAY, conversions.bearings(sources, earth=earth))
            if (heading := conversions.heading(pointing)) is not None:
                self._publish("heading", POSE, heading)
        self._publish("/diagnostics", DIAGNOSTICS, conversions.diagnostics(view, sources, silent=silent))

    def _silent(self, last: float | None) -> bool:
        """Whether nothing was heard of the payload for some time."""
        now = time.monotonic()
        if last != self._heard[0]:
            self._heard = last, now
        return now - self._heard[1] > SILENT_S

    async def turn(self, frame: str, x: float, y: float) -> None:
        """Turn the axis towards a point of a frame.

        Raises
        ------
        ValueError
            When the frame is not the one in which the payload thinks, or the point none beside the array.
        GroundError
            When the payload refuses, fails, or does not answer; says why.
        """
        earth = bool(self._payload.view["pointing"]["earth"])
        if frame != (expected := conversions.frame_of(earth=earth)):
            raise ValueError(f"expected a target in the frame {expected}, got {frame!r}")
        await self._payload.turn(conversions.azimuth_of(x, y, earth=earth))

    async def stop(self) -> None:
        """Decelerate now; whoever cancels a turn wants that."""
        await self._payload.stop()

    def error_deg(self, x: float, y: float) -> float | None:
        """How far the axis points beside a point [deg], for the feedback of a turn; None while nobody tells it."""
        pointing: Any = self._payload.view["pointing"]
        if pointing["heading"] is None:
            return None
        goal = conversions.azimuth_of(x, y, earth=bool(pointing["earth"]))
        return abs(math.remainder(pointing["heading"] - goal, 360))

    async def voice(self, address: str, what: str = "target", rate: int = 16000) -> None:
        """Have a voice sent to this computer, at an ``address`` that the payload reaches, and publish it.

        Until cancelled; then the stream is ended. It is for who asks for it, as the payload announces.
        """
        port = await RtpPort(rate, time.monotonic, time.time).open(address)
        try:
            stream = await self._payload.stream(what, to=port.place, codec=port.codec)
            try:
                await self._played(port)
            finally:
                await self._payload.stop_stream(stream.number)
        finally:
            port.close()

    async def _played(self, port: RtpPort) -> None:
        self._publish("audio_info", AUDIO_INFO, conversions.audio_info(port.rate))
        block, due = round(BLOCK_S * port.rate), time.monotonic()
        while True:
            self._publish("audio", AUDIO, conversions.audio(port.read(block)[0]))
            due += BLOCK_S
            await asyncio.sleep(due - time.monotonic())
