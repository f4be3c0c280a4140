"""RTP at length: recorded voices through bad networks, and an hour of it; the rows of measured-live.md."""

import gc
import tracemalloc

import numpy as np
import pytest

from lossy_network import Network, compared, heard
from ross_payload.audio.sinks.rtp_sender import RtpSender
from ross_payload.interfaces import VoiceBlock
from ross_payload.transport.rtp.receiver import RtpReceiver
from ross_payload.transport.rtp.session_description import Media
from ross_sim.study.rows.rtp_rows import NetworkRow
from ross_sim.talkers.speech import load_folder

RATE = 16000
SECONDS = 60
SEPARATED_DB = 12.0  # SI-SDR of what is sent: a separated voice
NETWORKS = {
    "ideal": Network(),
    "50 ms of jitter": Network(jitter=0.05),
    "5 % lost, 50 ms of jitter": Network(loss=0.05, jitter=0.05),
    "the same, 100 ms for the round trip": Network(loss=0.05, jitter=0.05, delay=0.05),
    "5 % lost, 50 ms of jitter, nothing sent once more": Network(loss=0.05, jitter=0.05, answers=False),
}


def spoken(speech):
    voice = np.concatenate([talker.speech for talker in load_folder(speech, RATE)])
    return 0.5 * np.resize(voice / np.abs(voice).max(), SECONDS * RATE)


@pytest.mark.soak
@pytest.mark.parametrize("codec", ["opus", "L16"])
def test_a_bad_network_costs_little(speech, codec, written):
    voice = spoken(speech)
    noise = np.random.default_rng(0).standard_normal(len(voice))
    separated = voice + 10 ** (-SEPARATED_DB / 20) * np.std(voice) * noise
    figures, rows = {}, []
    for name, network in NETWORKS.items():
        for delay in (0.0, 0.2):
            out = heard(separated, RATE, codec, network, delay_s=delay)
            quality = compared(voice, out.samples, RATE, after=5.0)[1] if delay else np.nan  # adapting shifts time
            made_up = out.reception.concealed_s / SECONDS
            figures[name, delay] = quality, made_up
            late, known = round(1000 * float(np.median(out.total_delays)), 1), round(quality, 3) if delay else None
            rows.append(NetworkRow(name, codec, 1000 * delay or None, known, round(100 * made_up, 4), late))
            print(rows[-1])  # noqa: T201
    written("rtp-networks.csv", rows)
    clean, lossy = figures["ideal", 0.2], figures["5 % lost, 50 ms of jitter", 0.2]
    assert clean[0] - lossy[0] < 1.0
    assert lossy[1] < 0.01


@pytest.mark.soak
def test_an_hour_loses_no_count_and_grows_no_memory():
    rng = np.random.default_rng(0)
    sender, receiver = RtpSender(RATE, Media.of("opus", RATE), 48000), RtpReceiver(Media.of("opus", RATE))
    tone = (0.2 * np.sin(np.arange(RATE) / 9)).astype(np.float32)
    sent = lost = 0
    grown = []
    tracemalloc.start()
    for step in range(3600 * 50):
        now = 0.02 * step
        place = 320 * step % RATE
        for packet in sender.packets(VoiceBlock(tone[place : place + 320], 320 * step, now)):
            sent += 1
            if rng.random() < 0.02:
                lost += 1
            else:
                receiver.on_datagram(packet, now + 0.02 * rng.random(), "sender")
        receiver.read(320, now + 0.02)
        receiver.feedback(now + 0.02)
        if step % 30000 == 29999:
            gc.collect()
            grown.append(tracemalloc.get_traced_memory()[0])
    tracemalloc.stop()
    reception = receiver.reception(3600.0)
    print(f"{sent} packets, {lost} lost; {reception}; memory {grown}")  # noqa: T201
    assert reception.received + lost == sent
    assert lost - 5 <= reception.lost <= lost  # the last ones may not be missed yet
    assert grown[-1] < 1.1 * grown[-2] < 1_000_000  # what is remembered of lost packets is full by then
