"""A stream of RTP through a network that loses, delays and repeats packets, in simulated time."""

import heapq
from collections import Counter
from dataclasses import dataclass, field

import numpy as np
import scipy.signal

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
    arrived: Counter[bytes]  # how often each of them came
    again: int  # packets sent once more
    total_delays: list[float] = field(default_factory=list)


def heard(
    voice, rate, codec="opus", network=Network(), *, seed=0, delay_s=0.0, bit_rate=48000, start=1000.0, media=None
):
    """Send a voice (n,) and play it for as long as it lasts."""
    rng = np.random.default_rng(seed)
    media = media or Media.of(codec, rate)
    sender, receiver = RtpSender(rate, media, bit_rate), RtpReceiver(media, delay_s)
    hop, taken = round(HOP * rate), round(HOP * media.rate)
    wire: list[tuple[float, int, str, bytes]] = []
    out, delays, sent, again = [], [], 0, 0
    sounds: set[bytes] = set()
    arrived: Counter[bytes] = Counter()

    def transmit(now: float, way: str, packet: bytes) -> None:
        for _ in range(1 + (rng.random() < network.twice)):
            if rng.random() >= network.loss:
                heapq.heappush(
                    wire, (now + network.delay + network.jitter * rng.random(), rng.integers(1 << 60), way, packet)
                )

    heapq.heappush(wire, (start, -1, "read", b""))
    for step in range(len(voice) // hop):
        now = start + step * HOP
        block = VoiceBlock(voice[step * hop : (step + 1) * hop].astype(np.float32), step * hop, now - HOP)
        for packet in sender.packets(block):
            sent += 1
            sounds.add(packet)
            transmit(now, "out", packet)
        if (report := sender.report(now, now + 1.7e9)) is not None:
            transmit(now, "out", report)
        while wire[0][0] < now + HOP:
            when, _, way, packet = heapq.heappop(wire)
            if way == "out":
                arrived[packet] += packet in sounds
                receiver.take(packet, when, "payload")
            elif way == "back":
                for each in sender.on_report(packet, when):
                    again += 1
                    transmit(when, "out", each)
            else:
                out.append(receiver.read(taken, when))
                heapq.heappush(wire, (start + len(out) * HOP / (1 + network.drift), -1, "read", b""))
                if (total := receiver.total_delay(when + 1.7e9)) is not None:
                    delays.append(total)
        for report in receiver.feedback(now + HOP):
            if network.answers:
                transmit(now + HOP, "back", report)
    return Heard(
        np.concatenate(out), receiver, receiver.reception(start + len(voice) / rate), sent, +arrived, again, delays
    )


def voiced(seconds, rate, seed=0):
    """Something like a voice, (n,): harmonics of a pitch that moves, in syllables with pauses between them."""
    rng = np.random.default_rng(seed)
    time = np.arange(round(seconds * rate)) / rate
    pitch = 120 + 30 * np.sin(2 * np.pi * 0.7 * time) + 10 * np.sin(2 * np.pi * 2.3 * time)
    phase = 2 * np.pi * np.cumsum(pitch) / rate
    tones = sum(np.sin(k * phase + rng.uniform(0, 6)) / k for k in range(1, 25))
    syllables = np.clip(np.sin(2 * np.pi * 3.1 * time) + 0.4 * np.sin(2 * np.pi * 0.31 * time), 0, 1)
    return (0.2 * tones * syllables + 1e-3 * rng.standard_normal(len(time))).astype(np.float32)


def compared(voice, samples, rate, after=2.0):
    """Return how late [s] samples (n,) are, and their SI-SDR [dB], from ``after`` on to the last second."""
    first = round(after * rate)
    reference = voice[first : len(voice) - rate].astype(float)
    late = int(np.argmax(scipy.signal.correlate(samples[first:], reference, "valid", "fft")))
    played = samples[first + late :][: len(reference)]
    scaled = reference * (reference @ played) / (reference @ reference)
    return late / rate, 10 * np.log10(scaled @ scaled / ((played - scaled) @ (played - scaled)))
