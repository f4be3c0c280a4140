"""Live listening through the page while the payload restarts, or sends nothing."""

from contextlib import asynccontextmanager
from dataclasses import replace

import aiohttp

from ground_page import page
from ports import free_port
from ross_payload.ground.station import Station
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.stream_values import Selection
from voice_payload import VoicePayload
from waiting import wait_for_async

PAYLOAD = ComponentId(1, 191)


class Restarting(VoicePayload):
    """Can start again: its time does, and it streams nothing."""

    age = _before = 0.0

    def restart(self):
        """Be as after a loss of power."""
        self._before = self.age
        self.stream = replace(self.stream, on=False, selection=Selection.NONE)

    def _tell(self, age):
        self.age = age
        super()._tell(age - self._before)


class Silent(VoicePayload):
    """Says that it streams, and does not."""

    def _send(self, packet):
        pass


@asynccontextmanager
async def relayed(kind):
    """A payload, and what relays its sound; on the loop of a station that hears it."""
    port = free_port()
    with kind(port) as payload:
        async with Station([f"udpin:127.0.0.1:{port}"]) as station, page(station) as served:
            await wait_for_async(lambda: PAYLOAD in station.fleet.payloads)
            await wait_for_async(lambda: station.fleet.payloads[PAYLOAD].audio)
            async with aiohttp.ClientSession() as client, client.ws_connect(_url(served)) as socket:
                yield payload, station, socket


def _url(served):
    return f"{served.url.split('?')[0]}listen?id={PAYLOAD}"


async def test_a_payload_that_has_restarted_is_asked_again():
    async with relayed(Restarting) as (payload, _, socket):
        await socket.send_json({"type": "choose", "what": "source", "source": 2})
        await wait_for_async(lambda: payload.stream.on)
        await wait_for_async(lambda: payload.age > 20.5)  # the station has heard more than its first words
        orders = len(payload.orders)
        payload.restart()
        await wait_for_async(lambda: payload.stream.on)
        again = next(each for each in payload.orders[orders:] if each.selection is not Selection.NONE)
        assert (again.selection, again.source) == (Selection.SOURCE, 2)
        assert (again.address, again.port) == (payload.orders[0].address, payload.orders[0].port)


async def test_nothing_is_given_on_before_anything_has_come():
    async with relayed(Silent) as (payload, _, socket):
        await socket.send_json({"type": "choose", "what": "target"})
        await wait_for_async(lambda: payload.stream.on)
        for _ in range(6):  # words that come four times a second
            message = await socket.receive(30)
            assert message.type is aiohttp.WSMsgType.TEXT
            assert message.json()["state"] != "playing"
