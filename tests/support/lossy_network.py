"""A stream of RTP through a network that loses, delays and repeats packets, in simulated time."""

import heapq
from dataclasses import dataclass, field

import numpy as np

from ross_payload.audio.sinks.rtp_sender import RtpSender
from ross_payload.interfaces import VoiceBlock
from ross_payload.transport.rtp.receiver import Reception, RtpReceiver
from ross_payload.transport.rtp.session_description import Media

HOP = 0.01  # of the payload, of who plays, and of reports [s]


@dataclass(frozen=True)
class Network:
    """What happens to packets: shares from 0 to 1, times in seconds."""

    loss: float = 0.0
    twice: float = 0.0
    jitter: float = 0.0  # delays are evenly distributed from 0 to it
    delay: float = 0.002  # both ways
    drift: float = 0.0  # by which the clock of who plays is faster, such as 1e-4
    answers: bool = True  # reports of the receiver reach the sender


@dataclass
class Heard:
    """What came out."""

    samples: np.ndarray
    receiver: RtpReceiver
    reception: Reception
    sent: int  # packets of sound, each counted once
    again: int  # packets sent once more
    total_delays: list[float] = field(default_factory=list)


def heard(voice, rate, codec="opus", network=Network(), *, seed=0, delay_s=0.0, bit_rate=48000, start=1000.0):
    """Send a voice (n,) and play it for as long as it lasts."""
    rng = np.random.default_rng(seed)
    media = Media.of(codec, rate)
    sender, receiver = RtpSender(rate, media, bit_rate), RtpReceiver(media, delay_s)
    hop, taken = round(HOP * rate), round(HOP * media.rate)
    wire: list[tuple[float, int, str, bytes]] = []
    out, delays, sent, again = [], [], 0, 0

    def transmit(now: float, way: str, packet: bytes) -> None:
        for _ in range(1 + (rng.random() < network.twice)):
            if rng.random() >= network.loss:
                heapq.heappush(
                    wire, (now + network.delay + network.jitter * rng.random(), rng.integers(1 << 60), way, packet)
                )

    played = 0
    for step in range(len(voice) // hop):
        now = start + step * HOP
        block = VoiceBlock(voice[step * hop : (step + 1) * hop].astype(np.float32), step * hop, now - HOP)
        for packet in sender.packets(block):
            sent += 1
            transmit(now, "out", packet)
        if (report := sender.report(now, now + 1.7e9)) is not None:
            transmit(now, "out", report)
        while wire and wire[0][0] <= now + HOP:
            when, _, way, packet = heapq.heappop(wire)
            if way == "out":
                receiver.take(packet, when, "payload")
            else:
                for each in sender.on_report(packet, when):
                    again += 1
                    transmit(when, "out", each)
        for report in receiver.feedback(now + HOP):
            if network.answers:
                transmit(now + HOP, "back", report)
        while played * taken / media.rate <= (step + 1) * HOP * (1 + network.drift):
            out.append(receiver.read(taken, now + HOP))
            played += 1
            if (total := receiver.total_delay(now + HOP + 1.7e9)) is not None:
                delays.append(total)
    return Heard(np.concatenate(out), receiver, receiver.reception(start + len(voice) / rate), sent, again, delays)
