"""A payload that answers orders as a test says."""

from client_bench import US, WHO
from ross_payload.ground.client.command_protocol import CommandProtocol
from ross_payload.ground.model.payload_state import PayloadState as Known
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.commands import acknowledgement
from ross_protocols.mavlink.component_id import ComponentId


class Script:
    """A payload that says what it is told to, and keeps what it hears."""

    def __init__(self, *, met=True):
        self.heard = []
        self.now = 0.0
        self.orders = CommandProtocol(lambda message, who: self.heard.append((self.now, message)), *US)
        if met:
            self.orders.on_state(Known(WHO, 0.0, 0.0))
        self.encoder, self.decoder = Encoder(1, 191), Decoder()

    def say(self, message, encoder=None):
        for packet in self.decoder.feed((encoder or self.encoder).encode(message)):
            self.orders.on_packet(packet, self.now)

    def ack(self, number, result, to=US, progress=None, encoder=None):
        self.say(acknowledgement(number, result, ComponentId(*to), progress), encoder)

    def wait(self, seconds):
        for _ in range(round(seconds * 20)):
            self.now = round(self.now + 0.05, 6)
            self.orders.tick(self.now)

    def states(self):
        return [doing.state for doing in self.orders.doing]
