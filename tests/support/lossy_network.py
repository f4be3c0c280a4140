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


class Wire:
    """Carries packets both ways: loses, delays and repeats them, and hands them over in the order of their arrival."""

    def __init__(self, network: Network, seed: int) -> None:
        self._network, self._rng = network, np.random.default_rng(seed)
        self._under_way: list[tuple[float, int, str, bytes]] = []

    def transmit(self, now: float, way: str, packet: bytes) -> None:
        """Send a packet, once or twice, if at all."""
        network, rng = self._network, self._rng
        for _ in range(1 + (rng.random() < network.twice)):
            if rng.random() >= network.loss:
                due = now + network.delay + network.jitter * rng.random()
                heapq.heappush(self._under_way, (due, rng.integers(1 << 60), way, packet))

    def due(self, when: float, way: str) -> None:
        """Have something happen at a time, before what arrives then."""
        heapq.heappush(self._under_way, (when, -1, way, b""))

    def next_before(self, end: float) -> tuple[float, str, bytes] | None:
        """Return what happens next: when, which way, and the packet; None when nothing does before the end."""
        if not self._under_way or self._under_way[0][0] >= end:
            return None
        when, _, way, packet = heapq.heappop(self._under_way)
        return when, way, packet


def heard(
    voice, rate, codec="opus", network=Network(), *, seed=0, delay_s=0.0, bit_rate=48000, start=1000.0, media=None
):
    """Send a voice (n,) and play it for as long as it lasts."""
    media = media or Media.of(codec, rate)
    receiver = RtpReceiver(media, delay_s)
    call = Call(RtpSender(rate, media, bit_rate), receiver, network, Wire(network, seed), start)
    hop = round(HOP * rate)
    for step in range(len(voice) // hop):
        now = start + step * HOP
        call.send(VoiceBlock(voice[step * hop : (step + 1) * hop].astype(np.float32), step * hop, now - HOP), now)
        call.live(now + HOP)
    reception = receiver.reception(start + len(voice) / rate)
    played = np.concatenate(call.played)
    return Heard(played, receiver, reception, call.sent, +call.arrived, call.again, call.total_delays)


class Call:
    """A sender, a receiver and who plays, and the wire between them."""

    def __init__(self, sender: RtpSender, receiver: RtpReceiver, network: Network, wire: Wire, start: float) -> None:
        self._sender, self._receiver, self._network, self._wire = sender, receiver, network, wire
        self._start, self._taken = start, round(HOP * receiver.rate)
        self._sounds: set[bytes] = set()
        self.played: list[np.ndarray] = []
        self.total_delays: list[float] = []
        self.arrived: Counter[bytes] = Counter()
        self.sent = self.again = 0
        wire.due(start, "read")

    def send(self, block: VoiceBlock, now: float) -> None:
        """Send the packets of a block, and a report when it is time."""
        for packet in self._sender.packets(block):
            self.sent += 1
            self._sounds.add(packet)
            self._wire.transmit(now, "out", packet)
        if (report := self._sender.report(now, now + 1.7e9)) is not None:
            self._wire.transmit(now, "out", report)

    def live(self, end: float) -> None:
        """Let arrive and play what does until the end, then let the receiver report."""
        while (happens := self._wire.next_before(end)) is not None:
            when, way, packet = happens
            if way == "out":
                self.arrived[packet] += packet in self._sounds
                self._receiver.on_datagram(packet, when, "payload")
            elif way == "back":
                for each in self._sender.on_report(packet, when):
                    self.again += 1
                    self._wire.transmit(when, "out", each)
            else:
                self._play(when)
        for report in self._receiver.feedback(end):
            if self._network.answers:
                self._wire.transmit(end, "back", report)

    def _play(self, when: float) -> None:
        self.played.append(self._receiver.read(self._taken, when))
        self._wire.due(self._start + len(self.played) * HOP / (1 + self._network.drift), "read")
        if (total := self._receiver.total_delay(when + 1.7e9)) is not None:
            self.total_delays.append(total)


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
