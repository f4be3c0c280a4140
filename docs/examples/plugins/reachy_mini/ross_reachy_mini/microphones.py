"""The audio source ``reachy_mini:HOST:PORT``: two of the four raw microphones of a Reachy Mini.

Its sound card, an XVF3800, gives two channels, which are processed unless the card is told otherwise. So the daemon is
asked over HTTP to let go of the card (``/api/media/release``) and to route two raw microphones to its outputs
(``/api/audio/config``); then the card is opened as any other is. At the end outputs and card are given back.

The card must be one of the computer that the payload runs on: the robot itself, or the one that a Lite is plugged into.
"""

import json
import urllib.error
import urllib.request
from contextlib import suppress
from dataclasses import replace

from ross_payload.audio.sound_card import SETTLING_S, SoundCard
from ross_payload.errors import AudioError, ConfigError
from ross_payload.transport.link_url import tcp_endpoint

CARD = "Reachy Mini Audio"
ANSWER_S = 3.0
OUTPUTS = ("AUDIO_MGR_OP_L", "AUDIO_MGR_OP_R")  # of the card: category and source of the left and the right channel
AMPLIFIED = 3  # the category of raw microphones behind the amplifier
MICROPHONES = 4


class Daemon:
    """What is asked of the daemon, over HTTP."""

    def __init__(self, host, port):
        self._base = f"http://{host}:{port}/api"

    def get(self, path):
        return self._ask(urllib.request.Request(self._base + path))

    def post(self, path, body=None):
        data = json.dumps(body or {}).encode()
        return self._ask(urllib.request.Request(self._base + path, data, {"Content-Type": "application/json"}))

    def _ask(self, request):
        try:
            with urllib.request.urlopen(request, timeout=ANSWER_S) as answer:
                return json.load(answer)
        except urllib.error.HTTPError as error:
            raise AudioError(f"{request.full_url}: HTTP {error.code} {error.reason}") from error
        except urllib.error.URLError as error:
            cause = error.reason if isinstance(error.reason, OSError) else error
            raise AudioError(f"{request.full_url}: no answer: {error.reason}") from cause
        except (OSError, ValueError) as error:
            raise AudioError(f"{request.full_url}: {error}") from error


class Microphones:
    """Opens two microphones, each time it is called."""

    def __init__(self, daemon, card, pair):
        self._daemon, self._card, self._pair = daemon, card, pair

    def __call__(self, on_samples):
        self._daemon.post("/media/release")
        try:
            before = self._route([[AMPLIFIED, microphone] for microphone in self._pair])
            stream = self._card(on_samples)
        except BaseException:
            self._daemon.post("/media/acquire")
            raise
        return OpenMicrophones(stream, self, before)

    def give_back(self, before):
        """Route the outputs as they were, and let the daemon have the card again."""
        self._route(before)
        self._daemon.post("/media/acquire")

    def _route(self, wanted):
        """Route the outputs; return how they were."""
        before = self._outputs()
        if before != wanted:
            config = [{"name": name, "values": values} for name, values in zip(OUTPUTS, wanted, strict=True)]
            self._daemon.post("/audio/config/apply", {"config": config, "verify": True})
            if self._outputs() != wanted:
                todo = "; ".join(f"xvf_host {name} {a} {b}" for name, (a, b) in zip(OUTPUTS, wanted, strict=True))
                raise AudioError(f"the daemon cannot route raw microphones to {CARD}: do it on its computer: {todo}")
        return before

    def _outputs(self):
        return [self._output(name) for name in OUTPUTS]

    def _output(self, name):
        answer = self._daemon.get(f"/audio/config/parameter/{name}")
        try:
            category, source = (int(value) for value in answer["values"])
        except (KeyError, TypeError, ValueError) as error:
            raise AudioError(f"{name}: expected a category and a source, got {str(answer)[:60]}") from error
        return [category, source]


class OpenMicrophones:
    """A feed."""

    def __init__(self, stream, microphones, before):
        self._stream, self._microphones, self._before = stream, microphones, before

    @property
    def alive(self):
        return self._stream.alive

    def close(self):
        self._stream.close()
        before, self._before = self._before, None
        if before is not None:
            with suppress(AudioError):  # a daemon that has gone has let go of everything
                self._microphones.give_back(before)


def audio_source(address, services):
    """Make the source; [audio] channels are microphones of the robot, from 0."""
    host, port = tcp_endpoint(f"tcp:{address}", "audio.source")
    pair = services.wiring.channels
    if max(pair) >= MICROPHONES:
        raise ConfigError(
            f"audio.channels: expected 0 to {MICROPHONES - 1}, microphones of the robot, got {list(pair)}"
        )
    wiring = replace(services.wiring, channels=(0, 1), device_channels=2)  # of the card
    opener = Microphones(Daemon(host, port), SoundCard(CARD, services.audio, wiring), pair)
    return replace(services, wiring=wiring).live(opener, settling=SETTLING_S)
