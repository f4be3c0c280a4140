"""The packets of one stream, without a network: their places in time, and what is sent once more."""

import numpy as np
import pytest
from aiortc.rtp import (
    RTCP_RTPFB_NACK,
    RtcpPacket,
    RtcpReceiverInfo,
    RtcpRrPacket,
    RtcpRtpfbPacket,
    RtcpSrPacket,
    RtpPacket,
)

from ross_payload.audio.sinks.rtp_sender import ONCE_MORE, RtpSender
from ross_payload.interfaces import VoiceBlock
from ross_payload.transport.rtp.receiver import RtpReceiver
from ross_payload.transport.rtp.session_description import Media

RATE = 16000
L16 = Media.of("L16", RATE)
PACKET = L16.packet
RAMP = np.linspace(-0.5, 0.5, 100 * PACKET).astype(np.float32)


@pytest.fixture
def sender():
    return RtpSender(RATE, L16, 48000)


def sent(sender, count, first=0, begin=0):
    """Return the next packets as bytes; ``first`` is the index of the first sample, ``begin`` its place in the ramp."""
    packets = []
    for number in range(count):
        place = begin + number * PACKET
        block = VoiceBlock(RAMP[place : place + PACKET], first + number * PACKET, 0.0)
        packets += sender.packets(block)
    return packets


def asking(sender, packets, ssrc=None):
    """Return the request of a receiver for packets."""
    read = [RtpPacket.parse(each) for each in packets]
    numbers = [each.sequence_number for each in read]
    return bytes(RtcpRtpfbPacket(RTCP_RTPFB_NACK, 1, read[0].ssrc if ssrc is None else ssrc, numbers))


def test_who_asks_for_everything_gets_a_quarter_of_what_was_sent(sender):
    """Else a forged request would have a payload send a flood to whoever is named in it."""
    packets = sent(sender, 40)
    again = [each for _ in range(50) for each in sender.on_report(asking(sender, packets), 1.0)]
    assert len(again) == round(ONCE_MORE * len(packets)) == 10
    assert set(again) <= set(packets)
    sent(sender, 4, first=40 * PACKET)
    assert len(sender.on_report(asking(sender, packets), 1.0)) == 1


def test_a_request_about_another_stream_is_not_answered(sender):
    packets = sent(sender, 40)
    assert sender.on_report(asking(sender, packets[:2], ssrc=7), 1.0) == []
    assert sender.on_report(asking(sender, packets[:2]), 1.0) == packets[:2]


def test_what_another_stream_lost_is_not_told_as_lost_here(sender):
    ssrc = RtpPacket.parse(sent(sender, 1)[0]).ssrc

    def report(about, lost):
        info = RtcpReceiverInfo(about, 0, lost, highest_sequence=0, jitter=0, lsr=0, dlsr=0)
        return bytes(RtcpRrPacket(1, [info]))

    sender.on_report(report(7, 99), 1.0)
    assert sender.packets_lost is None
    sender.on_report(report(ssrc, 3), 1.0)
    assert sender.packets_lost == 3
    sender.on_report(report(ssrc, -2), 1.0)  # RFC 3550: more came than were sent, as some came twice
    assert sender.packets_lost == 0


def test_a_source_that_is_opened_again_goes_on_in_time(sender):
    """Its indices start again; a timestamp that went back would be a packet that came too late."""
    before = [RtpPacket.parse(each) for each in sent(sender, 10, first=50 * PACKET)]
    after = [RtpPacket.parse(each) for each in sent(sender, 10, first=0)]
    stamps = np.array([each.timestamp for each in (*before, *after)], np.int64)
    assert np.array_equal(np.diff(stamps) % 2**32, np.full(19, PACKET))
    numbers = np.array([each.sequence_number for each in (*before, *after)])
    assert np.array_equal(np.diff(numbers) % 2**16, np.full(19, 1))
    (later,) = [RtpPacket.parse(each) for each in sent(sender, 1, first=15 * PACKET)]
    assert (later.timestamp - after[-1].timestamp) % 2**32 == 6 * PACKET, "what was left out since is a pause"


CLICKS = np.zeros(4 * RATE, np.float32)
CLICKS[RATE // 20 :: RATE // 10] = 0.8  # every 0.1 s
CLICKS[2 * RATE - 8] = 0.8  # the resampler holds it when the pause begins
CLICKS = np.convolve(CLICKS, np.hanning(33), "same").astype(np.float32)  # 2 ms each


@pytest.mark.parametrize("rate", [8000, 44100, 48000])
def test_at_another_rate_sound_keeps_its_time_after_a_pause(rate):
    """What the resampler holds of the sound before a pause is no part of that after it."""
    media = Media.of("L16", rate)
    sender, heard = RtpSender(RATE, media, 48000), np.zeros(4 * rate + media.packet)
    blocks = [begin for begin in range(0, len(CLICKS), 256) if not 2 * RATE <= begin < 2.4 * RATE]
    packets = [
        RtpPacket.parse(packet)
        for begin in blocks
        for packet in sender.packets(VoiceBlock(CLICKS[begin : begin + 256], begin, begin / RATE))
    ]
    last = 0
    for packet in packets:
        place = (packet.timestamp - packets[0].timestamp) % 2**32
        assert place >= last, "no packet covers another"
        last = place + media.packet
        heard[place:last] = np.frombuffer(packet.payload, ">i2") / 32767
    for moment in (*np.arange(0.05, 1.9, 0.1), 2.0 - 8 / RATE, *np.arange(2.45, 3.9, 0.1)):
        around = heard[round((moment - 0.02) * rate) : round((moment + 0.02) * rate)]
        assert abs(int(around.argmax()) - 0.02 * rate) <= 2 * max(1, rate / RATE), f"the click at {moment:.2f} s"


def test_the_receiver_tells_what_it_lost_and_which_report_it_answers(sender):
    receiver = RtpReceiver(L16, 0.05)
    packets = sent(sender, 60)
    for number, packet in enumerate(packets):
        if number % 20 != 7:
            receiver.on_datagram(packet, 0.02 * number, "payload")
        receiver.read(PACKET, 0.02 * number)
    report = sender.report(1.2, 1.7e9)
    receiver.on_datagram(report, 1.21, "payload")
    (answer,) = [each for each in RtcpPacket.parse(receiver.feedback(1.25)[0]) if isinstance(each, RtcpRrPacket)]
    (info,) = answer.reports
    (own,) = [each for each in RtcpPacket.parse(report) if isinstance(each, RtcpSrPacket)]
    assert info.packets_lost == receiver.reception(1.25).lost > 0
    assert info.lsr == own.sender_info.ntp_timestamp >> 16 & 0xFFFFFFFF  # RFC 3550, section 6.4.1
    assert info.dlsr == pytest.approx(0.04 * 65536, abs=1)
    assert 0 < info.fraction_lost < 256 * 0.2


def test_a_packet_that_was_overtaken_before_anything_was_played_is_played(sender):
    receiver = RtpReceiver(L16, 0.05)
    first, second = sent(sender, 2)
    receiver.on_datagram(second, 0.0, "payload")
    receiver.on_datagram(first, 0.001, "payload")
    assert receiver.reception(0.001).duplicates == 0
    assert receiver.reception(0.001).received == 2
