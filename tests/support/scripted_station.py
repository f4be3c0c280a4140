"""A station whose payload answers as a test wants, for the client of scripts, and what such a payload says."""

import asyncio
import math

import pytest

from hand_station import PAYLOAD, HandStation
from ross_payload.ground import Payload
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.commands import Result
from ross_protocols.mavlink.dialect import common, ross
from ross_protocols.mavlink.params import value_message

TURNS = {ross.MAV_CMD_ROSS_TURN, ross.MAV_CMD_ROSS_PARK, ross.MAV_CMD_ROSS_HOME}
NUMBERS = {"EXP_UNIT": 3.0, "EXP_MAX_ROT": 12.0}


def status(seconds, **how):
    told = {"state": ross.ROSS_STATE_IDLE, "earth": True, "heading": 0.0} | how
    return v.Status(round(seconds * 1e6), seconds, **told)


def source(index, azimuth_deg, estimate=1, **how):
    told = {"sigma": 0.02, "confidence": 0.9, "weight": 0.5, "earth": True, "resolved": True} | how
    return v.Source(estimate * 1_000_000, estimate, index, 2, math.radians(-azimuth_deg), **told)


class Scripted(HandStation):
    """A station whose payload answers every command with the results that a test wants; None: with nothing."""

    def __init__(self, *results, text=""):
        super().__init__()
        self.results, self.text = results, text
        self.refuses = False
        self.lists = True  # its parameters
        self.found = ()  # sources of an exploration, told after it was acknowledged
        self.turned = (status(2.0, settled=True),)  # told after a turn was
        self.say(status(1.0))

    def commands(self):
        return [message for message, _ in self.sent if message.get_type() == "COMMAND_LONG"]

    def send(self, message, who=None):
        super().send(message, who)
        kind = message.get_type()
        if kind == "COMMAND_LONG" and message.command >= ross.MAV_CMD_ROSS_EXPLORE:
            for result in self.results:
                asyncio.get_running_loop().call_soon(self.answer, message.command, result)
            if message.command == ross.MAV_CMD_ROSS_EXPLORE:
                k = self.found[0].count if self.found else 0
                asyncio.get_running_loop().call_later(0.1, self.say, status(2.0, k=k), *self.found)
            if message.command in TURNS:
                asyncio.get_running_loop().call_later(0.1, self.say, *self.turned)
            if self.text:
                asyncio.get_running_loop().call_later(0.1, self.say, v.Text(v.Severity.WARNING, self.text))
        elif kind == "COMMAND_LONG":
            self.answer(message.command, Result.UNSUPPORTED)
        elif kind == "PARAM_REQUEST_LIST" and self.lists:
            for index, (name, value) in enumerate(NUMBERS.items()):
                self.say(value_message(name, value, index, len(NUMBERS)))
        elif kind == "PARAM_SET" and not self.refuses:
            self.say(value_message("EXP_UNIT", message.param_value, 0, len(NUMBERS)))

    def answer(self, number, result):
        us = self.system_id, self.component_id
        self.say(common.MAVLink_command_ack_message(number, result, 255, 0, *us))


def with_payload(station, work):
    async def claim():
        async with Payload(station, PAYLOAD) as payload:
            return await work(payload)

    return asyncio.run(asyncio.wait_for(claim(), 60))


async def raised(request):
    with pytest.raises(Exception) as caught:
        await request
    return caught.value
