"""Players of others, on real sockets: what they play, and how late it comes out of them."""

import shutil
from contextlib import ExitStack

import numpy as np
import pytest

from lossy_network import voiced
from ports import free_port
from ross_payload.audio.sinks import info_of
from ross_sim.study.rows.rtp_rows import PlayerRow
from rtp_players import Player, delay_of, ffmpeg, found_in, gstreamer, in_use
from voice_sender import RATE, opened, talking
from waiting import wait_for

pytestmark = pytest.mark.alone
VOICE = voiced(30.0, RATE) + 0.01 * np.random.default_rng(1).standard_normal(30 * RATE).astype(np.float32)
SECONDS = 2.0  # that are played


SAID = {ffmpeg: "ffmpeg", gstreamer: "GStreamer, jitter buffer of 60 ms"}
CASES = [(player, codec) for player in (ffmpeg, gstreamer) for codec in ("opus", "L16")]


@pytest.fixture(scope="module")
def heard(tmp_path_factory):
    """What each player makes of a stream of its own, at the same time: when the voice began, and `Player.end`."""
    with ExitStack() as stack:
        sinks, playing = {}, {}
        for player, codec in CASES:
            if shutil.which(player("", 0, codec)[0]) is None:
                continue
            folder = tmp_path_factory.mktemp(f"{player.__name__}-{codec}")
            port = free_port(2)  # the next one is for RTCP
            sinks[player, codec] = sink = stack.enter_context(opened(port, folder, codec=codec))
            (folder / "voice.sdp").write_text(info_of(sink).sdp)
            playing[player, codec] = one = Player(player(str(folder / "voice.sdp"), port, codec))
            stack.callback(one.end)
            wait_for(lambda port=port: in_use(port))
        began = {case: stack.enter_context(talking(sink, VOICE)) for case, sink in sinks.items()}
        wait_for(lambda: all(one.seconds > SECONDS for one in playing.values()))
        yield {case: (began[case], *one.end()) for case, one in playing.items()}


@pytest.mark.parametrize(("player", "codec"), CASES, ids=[f"{player.__name__}-{codec}" for player, codec in CASES])
def test_a_player_of_others_plays_it_at_once(heard, player, codec, written):
    command = player("voice.sdp", 0, codec)[0]
    if (player, codec) not in heard:
        pytest.skip(f"{command} is missing; see tests/support/debian_packages.sh")
    began, samples, times, counts = heard[player, codec]
    place, quality = found_in(VOICE, samples)
    delay = delay_of(place, began, samples, times, counts)
    written("rtp-players.csv", [PlayerRow(SAID[player], codec, round(1000 * delay, 1), round(float(quality), 3))])
    assert quality > {"opus": 10, "L16": 60}[codec]
    assert -0.03 < delay < 0.4
