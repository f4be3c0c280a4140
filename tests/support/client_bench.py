"""A payload's command, parameter and file servers, and clients of the ground side at the other end of the air."""

from command_bench import Payload
from ross_payload.config import Config
from ross_payload.config.parameter_store import Parameters
from ross_payload.mavlink.component_info import files
from ross_payload.mavlink.ftp_server import FtpServer
from ross_payload.mavlink.param_server import ParamServer
from ross_protocols.mavlink.codec import Decoder, Encoder, chunks
from ross_protocols.mavlink.component_id import ComponentId

WHO = ComponentId(1, 191)
US = ComponentId(255, 190)
OVER = ("done", "refused", "failed", "cancelled", "no_answer")  # states in which an order ends
TICK = 5  # steps of 10 ms between two looks of a client at the time


class Served(Payload):
    """A payload with everything that a client can talk to, and a voice."""

    def __init__(self, sky, content=None):
        super().__init__(sky)
        self.component = self.links.component(191)
        self.parameters = Parameters(Config(), None)
        self.servers = [
            ParamServer(self.component, self.parameters, lambda name, value: None, self.say),
            FtpServer(self.component, files() | (content or {})),
        ]

    def say(self, severity, text):
        super().say(severity, text)
        for chunk in chunks(severity, "RoSS: " + text, len(self.texts)):
            self.component.send(chunk)

    def step(self):
        super().step()
        for server in self.servers:
            server.tick(self.clock.now())


class Station:
    """Hears a payload and calls it, for clients that are fed by hand; ``sent`` is what they have said."""

    def __init__(self, payload, ids=US):
        self.payload, self.clients, self.sent, self.steps = payload, [], [], 0
        self.encoder, self.decoder = Encoder(*ids), Decoder()
        self.lose = lambda message: False

    def send(self, message, who):
        assert who == WHO
        self.sent.append((self.payload.clock.now(), message))
        frame = self.encoder.encode(message)
        if not self.lose(message):
            self.payload.ground.air.call(frame)

    def wait(self, seconds, until=lambda: False):
        """Let time pass, no longer than until something is so; return whether it is."""
        for _ in range(round(seconds * 100)):
            if until():
                break
            self.payload.step()
            self.steps += 1
            now = self.payload.clock.now()
            packets = [p for data in self.payload.ground.air.listen() for p in self.decoder.feed(data)]
            for client in self.clients:
                for packet in packets:
                    client.on_packet(packet, now)
                if self.steps % TICK == 0:
                    client.tick(now)
        return until()
