"""The wire ``reachy_mini:HOST:PORT``: JSON to and from the robot's daemon over two WebSockets, and HTTP for the motors.

A thread of its own speaks with the daemon, so that nothing here waits. Only the newest set-point counts. A connection
that has gone is opened again once a second; until then `receive` says so.
"""

import asyncio
import json
import threading
from contextlib import suppress
from queue import SimpleQueue

import aiohttp

from ross_payload.errors import LinkError
from ross_payload.transport.link_url import tcp_endpoint

ANSWER_S = 3.0  # with a connection, a state, an answer
AGAIN_S = 1.0  # between two attempts to connect
STATE = "/api/state/ws/full?frequency=50&with_antenna_positions=false"
TARGET = "/api/move/ws/set_target"
MOTORS = "/api/motors/set_mode/"


class DaemonPort:
    """A connection to a daemon; the first state has arrived when it is made."""

    def __init__(self, host, port, name):
        self._base, self._name = f"http://{host}:{port}", name
        self._states = SimpleQueue()
        self._gone = "no answer"
        self._first = threading.Event()
        self._loop = asyncio.new_event_loop()
        self._target, self._motors = None, []
        self._thread = threading.Thread(target=self._run, name="reachy_mini", daemon=True)
        self._thread.start()
        if not self._first.wait(ANSWER_S) or self._gone:
            why = self._gone or "no answer"
            self.close()
            raise LinkError(f"{name}: the daemon of the robot does not answer: {why}")

    def send(self, frame):
        with suppress(RuntimeError):  # it was closed
            self._loop.call_soon_threadsafe(self._put, frame)

    def receive(self):
        states = []
        while not self._states.empty():
            states.append(self._states.get())
        if self._gone and not states:
            raise LinkError(f"{self._name}: {self._gone}")
        return states

    def close(self):
        with suppress(RuntimeError):
            self._loop.call_soon_threadsafe(self._task.cancel)
        self._thread.join(ANSWER_S)

    # ------------------------------------------------------------------------------------------ in the thread

    def _run(self):
        self._task = self._loop.create_task(self._live())
        with suppress(asyncio.CancelledError):
            self._loop.run_until_complete(self._task)
        self._loop.close()

    async def _live(self):
        self._due = asyncio.Event()
        while True:
            try:
                async with aiohttp.ClientSession(
                    timeout=aiohttp.ClientTimeout(total=None, connect=ANSWER_S)
                ) as session:
                    await self._talk(session)
                self._gone = "the daemon closed the connection"
            except (aiohttp.ClientError, OSError, TimeoutError, ValueError) as error:
                self._gone = str(error) or type(error).__name__
            self._target, self._motors = None, []  # what was meant for a robot that has gone
            self._first.set()
            await asyncio.sleep(AGAIN_S)

    async def _talk(self, session):
        async with session.ws_connect(self._base + STATE) as states, session.ws_connect(self._base + TARGET) as targets:
            telling = asyncio.ensure_future(self._tell(session, targets))
            listening = asyncio.ensure_future(self._listen(states))
            try:
                done, _ = await asyncio.wait({telling, listening}, return_when=asyncio.FIRST_COMPLETED)
                for task in done:
                    task.result()
            finally:
                for task in (telling, listening):
                    task.cancel()
                    with suppress(asyncio.CancelledError, Exception):
                        await task

    async def _listen(self, states):
        while True:
            message = await states.receive(timeout=ANSWER_S)
            if message.type is not aiohttp.WSMsgType.TEXT:
                return
            self._states.put(json.loads(message.data))
            self._gone = ""
            self._first.set()

    async def _tell(self, session, targets):
        while True:
            await self._due.wait()
            self._due.clear()
            target, self._target = self._target, None
            motors, self._motors = self._motors, []
            if target is not None:
                await targets.send_str(json.dumps(target))
            for mode in motors:
                async with session.post(self._base + MOTORS + mode) as answer:
                    if answer.status != 200:
                        raise ValueError(f"motors/set_mode/{mode}: HTTP {answer.status}")

    def _put(self, frame):
        if "motors" in frame:
            self._motors.append(frame["motors"])
        else:
            self._target = frame
        self._due.set()


class Wire:
    """Opens what an URL names."""

    def check(self, url):
        tcp_endpoint("tcp:" + url.partition(":")[2], f"wire '{url}'")

    def open(self, url, clock):
        host, port = tcp_endpoint("tcp:" + url.partition(":")[2], f"wire '{url}'")
        return DaemonPort(host, port, f"wire '{url}'")


wire = Wire()
