"""Players of others, on real sockets: what they play, and how late it comes out of them."""

import shutil

import numpy as np
import pytest

from lossy_network import voiced
from ross_payload.audio.sinks import info_of
from rtp_players import Player, delay_of, ffmpeg, found_in, gstreamer, in_use
from voice_sender import RATE, ear, opened, talking
from waiting import wait_for

pytestmark = pytest.mark.alone
VOICE = voiced(30.0, RATE) + 0.01 * np.random.default_rng(1).standard_normal(30 * RATE).astype(np.float32)
SECONDS = 3.0  # that are played


@pytest.mark.parametrize("codec", ["opus", "L16"])
@pytest.mark.parametrize("player", [ffmpeg, gstreamer], ids=lambda player: player.__name__)
def test_a_player_of_others_plays_it_at_once(tmp_path, player, codec):
    command = player("voice.sdp", 0, codec)[0]
    if shutil.which(command) is None:
        pytest.skip(f"{command} is missing; see tests/support/debian_packages.sh")
    with ear() as sock:
        port = sock.getsockname()[1]
    with opened(port, tmp_path, codec=codec) as sink:
        (tmp_path / "voice.sdp").write_text(info_of(sink).sdp)
        playing = Player(player(str(tmp_path / "voice.sdp"), port, codec))
        try:
            wait_for(lambda: in_use(port))
            with talking(sink, VOICE) as began:
                wait_for(lambda: playing.seconds > SECONDS)
        finally:
            samples, times, counts = playing.end()
    place, quality = found_in(VOICE, samples)
    delay = delay_of(place, began, samples, times, counts)
    print(f"{command} {codec}: {quality:.1f} dB, {1000 * delay:.0f} ms after the microphone")  # noqa: T201 - the figure
    assert quality > {"opus": 10, "L16": 60}[codec]
    assert -0.03 < delay < 0.4
