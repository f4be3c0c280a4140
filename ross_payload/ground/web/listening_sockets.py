"""The sockets over which browsers listen: one per browser and payload, open for as long as it listens.

To the browser: sound in binary messages (`sound_queue.frame_of`), and how it goes as text. From it, as text: the first
message chooses what is heard, as do later ones; a ``ping`` is answered at once, so that a browser can tell the way.
"""

from __future__ import annotations

import asyncio
import json

from aiohttp import WSCloseCode, WSMsgType, web

from ross_payload.bounded_files import parsed_json
from ross_payload.ground.audio.sound_queue import Listener
from ross_payload.ground.audio.voice_relay import VoiceRelay
from ross_payload.ground.errors import GroundError
from ross_payload.ground.web.faults import report, write_line
from ross_payload.ground.web.page_state import PageState
from ross_payload.ground.web.websocket_sessions import browser_name, close_all, opened
from ross_protocols.mavlink.component_id import ComponentId

MAX_LISTENERS = 16
MAX_MESSAGE_BYTES = 2048  # of what a browser says
WRITE_BUFFER_BYTES = 8192  # that may wait in this process for one browser
STALLED_S = 5.0  # that a browser may take nothing
END_S = 0.3  # for payloads to take the last orders


class ListeningSockets:
    """Everybody who listens.

    Parameters
    ----------
    state
        What all browsers share.
    address
        Of this computer as payloads reach it; empty: that of the way on which they are heard.
    """

    def __init__(self, state: PageState, address: str = "") -> None:
        self._state, self._address = state, address
        self._relays: dict[ComponentId, VoiceRelay] = {}
        self._sockets: set[web.WebSocketResponse] = set()

    def relay(self, who: ComponentId) -> VoiceRelay:
        """Return what relays the sound of a payload."""
        if who not in self._relays:
            state = self._state
            self._relays[who] = VoiceRelay(who, state.station, state.client.orders, write_line, self._address)
        return self._relays[who]

    async def tick(self) -> None:
        """Do what is due; call it ten times a second."""
        for relay in self._relays.values():
            relay.tick()

    async def close(self) -> None:
        """End all streams, and tell the browsers."""
        for relay in self._relays.values():
            relay.end()
        await close_all(self._sockets)
        if self._relays:
            await asyncio.sleep(END_S)
        for relay in self._relays.values():
            relay.close()

    async def serve(self, request: web.Request) -> web.StreamResponse:
        """Let one browser listen until it goes."""
        socket = await opened(request, MAX_MESSAGE_BYTES, WRITE_BUFFER_BYTES)
        listener = Listener(browser_name(request))
        if len(self._sockets) >= MAX_LISTENERS:
            await _refuse(socket, f"{MAX_LISTENERS} browsers listen already: no more are served")
            return socket
        self._sockets.add(socket)
        writer = asyncio.create_task(_write(listener, socket, request))
        relay = None
        try:
            relay = self.relay(self._known(request.query.get("id", "")))
            async for message in socket:
                if message.type is WSMsgType.TEXT:
                    await _on_message(relay, listener, message.data)
                    await asyncio.sleep(0)  # for others: the next one may have come, and is taken without waiting
        except (GroundError, ValueError) as error:
            await _refuse(socket, error.message if isinstance(error, GroundError) else str(error))
        finally:
            self._sockets.discard(socket)
            if relay is not None:
                relay.leave(listener)
            writer.cancel()
            await asyncio.gather(writer, return_exceptions=True)
        return socket

    def _known(self, text: str) -> ComponentId:
        if not self._state.live:
            raise ValueError("a recorded flight has no live sound")
        who = ComponentId.parse(text)
        if who not in self._state.station.fleet.payloads:
            raise ValueError(f"id: expected a payload that was received, got {who}")
        return who


async def _on_message(relay: VoiceRelay, listener: Listener, text: str) -> None:
    """Do what a browser asks for.

    Raises
    ------
    ValueError
        When it cannot be done.
    """
    message = parsed_json(text)
    kind = message.get("type") if isinstance(message, dict) else None
    if kind == "ping":
        listener.send({"type": "pong", "at": message.get("at")})
    elif kind != "choose":
        raise ValueError(f"type: expected choose or ping, got {str(kind)[:40]}")
    elif listener in relay.listeners:
        relay.choose(message)
    else:
        await relay.join(listener, message)


async def _refuse(socket: web.WebSocketResponse, why: str) -> None:
    if not socket.closed:
        await socket.send_str(json.dumps({"type": "refused", "why": why}))
        await socket.close(code=WSCloseCode.POLICY_VIOLATION, message=b"refused")


async def _write(listener: Listener, socket: web.WebSocketResponse, request: web.Request) -> None:
    """Send what is due until the browser goes or takes nothing for long: then it is cut off."""
    try:
        while True:
            await listener.wake.wait()
            messages, frames = listener.due()
            async with asyncio.timeout(STALLED_S):
                for message in messages:
                    await socket.send_str(json.dumps(message, separators=(",", ":")))
                for frame in frames:
                    await socket.send_bytes(frame)
    except ConnectionError:
        return
    except TimeoutError:
        write_line(f"{listener.name} takes no sound: it is cut off")
    except Exception as error:
        report(error)
    if request.transport is not None:
        request.transport.abort()
