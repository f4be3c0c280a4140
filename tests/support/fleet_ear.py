"""What payloads say, and a picture that hears it."""

import math

from ross_payload.ground.model.fleet import Fleet
from ross_payload.ground.model.view import view
from ross_protocols.mavlink import values as v
from ross_protocols.mavlink.codec import Decoder, Encoder
from ross_protocols.mavlink.component_id import ComponentId
from ross_protocols.mavlink.stream_values import Codec, Selection, StreamReport

WHO = ComponentId(1, 191)

RTP = StreamReport(
    1_000_000, 0, 2, "rtp", Selection.SOURCE, True, 48000, on=True, source=2, azimuth=-math.pi / 2, group=1,
    codec=Codec.OPUS, address="192.168.1.20", port=5004, gain=-6.0, level=-23.0, delay=0.12, separated=True,
)  # fmt: skip
FILE = StreamReport(
    1_000_000, 1, 2, "file", Selection.TARGET, True, 16000, on=True, codec=Codec.FLAC, address="target.flac",
    records=True,
)  # fmt: skip


def status(time, **how):
    return v.Status(**{"time_usec": round(time * 1e6), "mission_time": time, "state": 2, "earth": True} | how)


def source(index, azimuth, estimate=1, count=3, time=1.0, **how):
    told = {"sigma": 0.02, "confidence": 0.9, "weight": 0.3, "earth": True, "resolved": True} | how
    return v.Source(round(time * 1e6), estimate, index, count, azimuth, **told)


class Ground:
    """Hears what components say."""

    def __init__(self):
        self.fleet, self.decoder, self.at = Fleet(), Decoder(), 0.0
        self.encoders = {}

    def frames(self, *said, who=(1, 191), sender=0):
        encoder = self.encoders.setdefault((*who, sender), Encoder(*who))
        return [encoder.encode(each) for each in said]

    def say(self, *said, who=(1, 191), sender=0):
        self.hear(self.frames(*said, who=who, sender=sender))

    def hear(self, frames):
        for frame in frames:
            for packet in self.decoder.feed(frame):
                self.fleet.on_packet(packet, self.at)

    @property
    def known(self):
        return self.fleet.payloads[WHO]

    @property
    def view(self):
        return view(self.known)
