"""The simulated robot behind that part of its daemon's interface that is used here.

``python -m ross_reachy_mini.emulated_daemon [PORT]``. Paths and JSON are those of the daemon's OpenAPI description and
sources, as they were on 24 November 2026.
"""

import asyncio
import json
import sys
from contextlib import suppress

from aiohttp import WSMsgType, web

from ross_reachy_mini.simulated_robot import Robot
from ross_sim.devices.far_end import Fault

STEP_S = 0.005  # of the simulated mechanics


class EmulatedDaemon:
    """State and handlers."""

    def __init__(self):
        self.robot = Robot()
        self.released = False
        self.outputs = {"AUDIO_MGR_OP_L": [8, 0], "AUDIO_MGR_OP_R": [0, 0]}
        self.takes_integers = True  # some daemons refuse to write registers of whole numbers

    def application(self):
        app = web.Application()
        app.add_routes(
            [
                web.get("/api/state/ws/full", self.states),
                web.get("/api/move/ws/set_target", self.targets),
                web.post("/api/motors/set_mode/{mode}", self.motors),
                web.post("/api/media/{what}", self.media),
                web.get("/api/media/status", self.media_status),
                web.get("/api/audio/config/parameter/{name}", self.parameter),
                web.post("/api/audio/config/apply", self.apply),
                web.post("/emulator/{what}", self.emulator),
            ]
        )
        app.on_startup.append(self.start)
        return app

    async def start(self, app):
        app["mechanics"] = asyncio.create_task(self.mechanics())

    async def mechanics(self):
        while True:
            self.robot.live(asyncio.get_running_loop().time())
            await asyncio.sleep(STEP_S)

    async def states(self, request):
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        period = 1 / float(request.query.get("frequency", 10))
        with suppress(ConnectionResetError):  # the other end has gone
            while not socket.closed:
                await socket.send_str(json.dumps(self.robot.state()))
                await asyncio.sleep(period)
        return socket

    async def targets(self, request):
        socket = web.WebSocketResponse()
        await socket.prepare(request)
        async for message in socket:
            if message.type is WSMsgType.TEXT:
                self.robot.take(json.loads(message.data))
        return socket

    async def motors(self, request):
        self.robot.take({"motors": request.match_info["mode"]})
        return web.json_response({"status": "ok"})

    async def media(self, request):
        self.released = request.match_info["what"] == "release"
        return web.json_response({"status": "ok"})

    async def media_status(self, request):
        return web.json_response({"available": not self.released, "released": self.released, "no_media": False})

    async def parameter(self, request):
        name = request.match_info["name"]
        return web.json_response({"name": name, "values": self.outputs[name]})

    async def apply(self, request):
        body = await request.json()
        if self.takes_integers:
            self.outputs |= {pair["name"]: [float(value) for value in pair["values"]] for pair in body["config"]}
        return web.json_response({"applied": self.takes_integers})

    async def emulator(self, request):
        """What befalls the robot; no part of the daemon's interface."""
        what = request.match_info["what"]
        if what == "sleep":
            self.robot.lie_down()
        elif what == "refuse-integers":
            self.takes_integers = False
        elif what == "state":
            return web.json_response({"angle": self.robot.angle(), "outputs": self.outputs, "released": self.released})
        else:
            self.robot.afflict(Fault(what))
        return web.json_response({"status": "ok"})


async def serve(port):
    runner = web.AppRunner(EmulatedDaemon().application())
    await runner.setup()
    site = web.TCPSite(runner, "127.0.0.1", port)
    await site.start()
    print(f"the emulated daemon listens on 127.0.0.1:{runner.addresses[0][1]}", flush=True)
    await asyncio.Event().wait()


if __name__ == "__main__":
    with suppress(KeyboardInterrupt):
        asyncio.run(serve(int(sys.argv[1]) if len(sys.argv) > 1 else 8000))
