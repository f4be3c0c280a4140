"""What comes out of the receiver, whatever the network did: in simulated time, through the real sender and codecs."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import scipy.signal
from aiortc.rtp import RtcpPacket, RtcpRtpfbPacket, RtpPacket
from hypothesis import given, settings
from hypothesis import strategies as st

from examples import examples, in_soak, rows_in_soak
from lossy_network import Network, compared, heard, voiced
from ross_payload.audio.sinks.rtp_sender import RtpSender
from ross_payload.interfaces import VoiceBlock
from ross_payload.transport.rtp.receiver import RtpReceiver
from ross_payload.transport.rtp.session_description import Media

RATE = 16000
VOICE = voiced(12.0, RATE)
BRIEF = VOICE[: 6 * RATE]
BAD = Network(loss=0.05, jitter=0.05)


def test_samples_come_out_as_they_went_in():
    out = heard(VOICE, RATE, "L16", Network(delay=0.0), delay_s=0.05)
    late, quality = compared(VOICE, out.samples, RATE)
    assert quality > 60  # 16 bits
    assert out.reception.concealed_s == out.reception.adjusted_s == out.reception.lost == 0
    assert 0.05 < late < 0.09  # what it waits, and up to a packet and two hops
    assert np.median(out.total_delays) == pytest.approx(late, abs=0.002)  # as the sender's reports tell it


@pytest.mark.parametrize("rate", in_soak(44100, 48000, 16000, 24000))
def test_opus_keeps_the_voice_at_every_rate(rate):
    voice = voiced(5.0, rate)
    out = heard(voice, rate, "opus", delay_s=0.05)
    if out.receiver.rate != rate:
        voice = voiced(5.0, out.receiver.rate)
    late, quality = compared(voice, out.samples, out.receiver.rate)
    assert quality > 12
    assert np.median(out.total_delays) == pytest.approx(late, abs=0.004)


def test_l16_goes_out_at_a_rate_that_a_player_wants():
    slow = voiced(5.0, RATE)
    out = heard(slow, RATE, network=Network(delay=0.0), delay_s=0.05, media=Media.of("L16", 44100))
    late, quality = compared(scipy.signal.resample_poly(slow, 441, 160), out.samples, 44100)
    assert quality > 20
    assert np.median(out.total_delays) == pytest.approx(late, abs=0.004)


@pytest.mark.parametrize(
    ("codec", "answers"), [("L16", True), ("opus", False), *rows_in_soak(("L16", False), ("opus", True))]
)
def test_every_packet_is_counted(codec, answers):
    out = heard(BRIEF, RATE, codec, Network(loss=0.1, twice=0.1, jitter=0.03, answers=answers), delay_s=0.12)
    reception = out.reception
    assert reception.received == len(out.arrived)
    assert reception.duplicates == out.arrived.total() - len(out.arrived)
    not_known_yet = 10  # that may still come, or were lost at the very end
    assert out.sent - not_known_yet <= reception.received + reception.lost <= out.sent
    assert (reception.asked > 0, out.again > 0) == (True, answers)


@cache
def separated_quality(codec, network):
    """Of a voice that was separated with 12 dB, as it is heard [dB]."""
    separated = BRIEF + 10 ** (-12 / 20) * np.std(BRIEF) * np.random.default_rng(1).standard_normal(len(BRIEF))
    return compared(BRIEF, heard(separated, RATE, codec, network, delay_s=0.2).samples, RATE)[1]


@pytest.mark.parametrize(
    ("codec", "answers", "worst"), rows_in_soak(("opus", True, 0.5), ("opus", False, 2.0), ("L16", True, 1.0))
)
def test_five_percent_lost_and_fifty_milliseconds_of_jitter_cost_little(codec, answers, worst):
    """A voice that was separated with 12 dB loses less than `worst` dB."""
    clean, lossy = separated_quality(codec, Network()), separated_quality(codec, replace(BAD, answers=answers))
    assert clean > 10
    assert clean - lossy < worst


def test_almost_nothing_is_made_up_when_the_sender_repeats_what_was_lost():
    share = heard(BRIEF, RATE, "L16", BAD, delay_s=0.2).reception.concealed_s / 6
    alone = heard(BRIEF, RATE, "L16", Network(loss=0.05, jitter=0.05, answers=False), delay_s=0.2)
    assert alone.reception.concealed_s / 6 == pytest.approx(0.05, abs=0.02)
    assert share < 0.01


def test_forward_error_correction_replaces_what_was_lost():
    out = heard(VOICE, RATE, "opus", Network(loss=0.05, answers=False), delay_s=0.1)
    assert out.reception.recovered > out.reception.lost / 2
    made_up = out.reception.lost - out.reception.recovered
    assert out.reception.concealed_s == pytest.approx(0.02 * made_up, abs=0.05)


@pytest.mark.parametrize(
    ("jitter", "least", "most"),
    [(0.0, 0.0, 0.03), (0.15, 0.06, 0.2), pytest.param(0.05, 0.02, 0.07, marks=pytest.mark.soak)],
)
def test_the_delay_adapts_to_the_network(jitter, least, most):
    reception = heard(VOICE, RATE, "L16", Network(jitter=jitter)).reception
    assert least < reception.delay_s < most
    assert reception.lost == 0
    assert reception.late < 0.02 * reception.received


@pytest.mark.parametrize(("codec", "drift"), [("L16", 1e-3), *rows_in_soak(("L16", -1e-3), ("opus", 1e-3))])
def test_clocks_that_differ_are_followed(codec, drift):
    """The clock of who plays is faster by 0.1 %: in 24 s, 24 ms are put in, and nothing is made up."""
    voice = np.tile(VOICE, 2)
    reception = heard(voice, RATE, codec, Network(drift=drift), delay_s=0.06).reception
    assert reception.adjusted_s == pytest.approx(24 * drift, abs=0.012)
    assert reception.delay_s == pytest.approx(0.06, abs=0.02)
    assert reception.concealed_s == 0


def test_following_a_clock_makes_no_clicks():
    """No two neighbouring samples differ by more than those of the voice itself do."""
    out = heard(VOICE, RATE, "L16", Network(drift=1e-3), delay_s=0.06)
    assert out.reception.adjusted_s != 0
    assert np.abs(np.diff(out.samples)).max() < 1.2 * np.abs(np.diff(VOICE)).max()


@pytest.mark.parametrize("codec", ["L16", "opus"])
def test_the_first_sound_is_heard_within_a_tenth_of_a_second(codec):
    tone = np.full(RATE, 0.3) * np.sin(np.arange(RATE))
    samples = heard(tone, RATE, codec, Network(delay=0.0)).samples
    assert np.flatnonzero(np.abs(samples) > 0.05)[0] < 0.13 * RATE  # 60 ms that it waits, a packet, and two hops


def test_a_pause_of_the_sender_stays_as_long():
    sender, receiver = RtpSender(RATE, Media.of("L16", RATE), 0), RtpReceiver(Media.of("L16", RATE), 0.05)
    out = []
    for step in range(300):
        now = 1000 + 0.01 * step
        if not 100 <= step < 140:
            block = VoiceBlock(np.full(160, 0.25, np.float32), step * 160, now)
            for packet in sender.packets(block):
                receiver.on_datagram(packet, now)
        out.append(receiver.read(160, now))
    silent = np.flatnonzero(np.concatenate(out)[8000:40000] == 0)
    assert len(silent) == pytest.approx(0.4 * RATE, abs=0.09 * RATE)  # some of it is what sounded before, fading
    assert receiver.reception(1003.0).lost == 0


def packet_of(sequence, timestamp, ssrc=7, payload=b"\x10\x00" * 320):
    return RtpPacket(96, 0, sequence % 2**16, timestamp % 2**32, ssrc, payload).serialize()


def played(packets, seconds=2.0, step=0.02):
    """Give one packet every 20 ms to a receiver of L16, and read as much."""
    receiver, now = RtpReceiver(Media.of("L16", RATE), 0.05), 100.0
    for datagram in packets:
        receiver.on_datagram(datagram, now)
        receiver.read(320, now)
        now += step
    return receiver, now


def test_numbers_that_wrap_are_no_loss():
    packets = [packet_of(65500 + each, 2**32 - 3200 + 320 * each) for each in range(100)]
    receiver, now = played(packets)
    reception = receiver.reception(now)
    assert (reception.received, reception.lost, reception.concealed_s) == (100, 0, 0)


def test_lost_packets_are_asked_for_where_numbers_wrap():
    receiver, asked = RtpReceiver(Media.of("L16", RATE), 0.1), []
    for each in sorted({*range(40)} - {17, 19, 20, 22}):
        now = 0.02 * each
        receiver.on_datagram(packet_of(65516 + each, 320 * each), now)
        receiver.read(320, now)
        for answer in receiver.feedback(now):
            asked += [report for report in RtcpPacket.parse(answer) if isinstance(report, RtcpRtpfbPacket)]
    wanted = {number % 2**16 for request in asked for number in request.lost}
    assert wanted == {65533, 65535, 0, 2}
    assert receiver.reception(now).lost == 4


def test_a_stranger_is_not_heard_while_the_sender_is():
    ours = [packet_of(each, 320 * each) for each in range(50)]
    strange = [packet_of(each, 320 * each, ssrc=8, payload=b"\x7f\xff" * 320) for each in range(50)]
    receiver, now = played([each for pair in zip(ours, strange, strict=True) for each in pair], step=0.01)
    assert receiver.reception(now).bad == 50
    assert np.abs(receiver.read(320, now)).max() < 0.2


def test_a_sender_that_begins_again_is_heard_again():
    sender = RtpSender(RATE, Media.of("L16", RATE), 0)
    block = VoiceBlock(np.full(320, 0.5, np.float32), 0, 0.0)
    receiver, now = played([packet_of(each, 320 * each) for each in range(50)])
    for step in range(200):
        receiver.on_datagram(next(sender.packets(VoiceBlock(block.samples, 320 * step, now))), now)
        out = receiver.read(320, now)
        now += 0.02
    assert out == pytest.approx(0.5, abs=1e-3)
    receiver.on_datagram(sender.goodbye(), now)
    assert receiver.reception(now).ended
    receiver, now = played(
        [packet_of(each, 320 * each) for each in range(50)]
        + [packet_of(20000 + each, 320 * each) for each in range(100)]
    )
    assert np.abs(receiver.read(320, now)).max() == pytest.approx(4096 / 32768, rel=0.01)


def test_silence_when_nothing_comes_and_sound_again_when_it_does():
    receiver, now = played([packet_of(each, 320 * each) for each in range(50)])
    for _ in range(100):
        quiet = receiver.read(320, now)
        now += 0.02
    assert not quiet.any()
    assert receiver.reception(now).concealed_s < 1.1  # then silence is no more of what was sent
    assert not receiver.reception(now).playing
    for each in range(150, 170):
        receiver.on_datagram(packet_of(each, 320 * each), now)
        out = receiver.read(320, now)
        now += 0.02
    assert out.any()
    assert receiver.reception(now).lost == 100  # what was sent meanwhile


def test_who_did_not_read_hears_what_is_new():
    receiver, now = played([packet_of(each, 320 * each) for each in range(50)])
    for each in range(50, 550):
        receiver.on_datagram(packet_of(each, 320 * each), now)
        now += 0.02
    for each in range(550, 600):
        receiver.on_datagram(packet_of(each, 320 * each), now)
        out = receiver.read(320, now)
        now += 0.02
    reception = receiver.reception(now)
    assert out.any()
    assert reception.skipped > 300
    assert reception.delay_s < 0.13  # and falls
    assert (reception.received, reception.lost) == (600, 0)


VALID = [packet_of(each, 320 * each) for each in range(20)]
DATAGRAMS = st.one_of(
    st.binary(max_size=80),
    st.sampled_from(VALID),
    st.builds(
        lambda packet, place, value: packet[:place] + bytes([value]) + packet[place + 1 :],
        *(st.sampled_from(VALID), st.integers(0, 20), st.integers(0, 255)),
    ),
    st.builds(lambda kind, rest: bytes([0x81, kind]) + rest, st.integers(192, 208), st.binary(max_size=60)),
)


@given(st.lists(st.tuples(DATAGRAMS, st.floats(0, 0.5), st.integers(0, 2000)), max_size=30))
@settings(max_examples=examples(60))
@pytest.mark.parametrize("media", [Media.of("L16", RATE), Media("opus", RATE, 96)])
def test_whatever_arrives_as_much_is_played_as_is_asked_for(media, arrivals):
    receiver, now = RtpReceiver(media), 0.0
    for datagram, pause, count in arrivals:
        now += pause
        receiver.on_datagram(datagram, now)
        samples = receiver.read(count, now)
        assert samples.shape == (count,)
        assert np.isfinite(samples).all()
        for answer in receiver.feedback(now):
            assert isinstance(answer, bytes)
        receiver.reception(now)
