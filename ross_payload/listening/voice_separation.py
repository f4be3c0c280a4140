"""Frames of the mixture in, groups out: one live separator, started again whenever the scene is another one."""

from __future__ import annotations

import logging
from collections import deque
from typing import Any

import numpy as np

from ross_payload.config import Config
from ross_payload.dsp.noise import quiet_psd
from ross_payload.dsp.stft import Stft
from ross_payload.errors import PluginError
from ross_payload.interfaces import Complex, Groups, LiveSeparator, Real, Scene
from ross_payload.listening.learning import Learner, LearningRequest
from ross_payload.listening.scene_tracker import Placement

LEAST_S = 0.5  # of audio from which anything is learnt
EARLY_S = 2.0  # of a stretch, after which there is less to be learnt again
LATER = 2  # periods of learning from one time to the next by then
LEAD_IN_S = 4.0  # of the noise that is kept
JUDGED_S = 2.0  # of what comes after the lead-in, by which is told whether that was quiet

log = logging.getLogger(__name__)


class VoiceSeparation:
    """Separates what is heard at one heading after another; everything belongs to one thread.

    Parameters
    ----------
    separator
        What separates.
    learner
        Learns for it.
    stft
        Frames.
    config
        Geometry, seed, window and period of learning.
    """

    def __init__(self, separator: LiveSeparator, learner: Learner, stft: Stft, config: Config) -> None:
        self._separator = separator
        self._learner = learner
        self._stft = stft
        self._config = config
        self._every = max(round(config.listening.learn_s / stft.period), 1)
        self._early = round(EARLY_S / stft.period)
        self._least = max(round(LEAST_S / stft.period), 1)
        self._window: deque[Complex] = deque(maxlen=max(round(config.listening.window_s / stft.period), self._least))
        self._lead_in: deque[Complex] = deque(maxlen=round(LEAD_IN_S / stft.period))
        self._noise_psd: Real | None = None
        self._state: Any = None
        self._learnt: Any = None
        self._stretch = -1
        self._n_frames = 0  # in this stretch
        self.fault = ""

    def hear_noise(self, frame: Complex) -> None:
        """Take a frame (2, n_freqs) in which the mission takes nobody to talk."""
        if self._noise_psd is not None:
            self._lead_in.clear()
            self._noise_psd = None
        self._lead_in.append(frame)

    def step(self, frame: Complex, placement: Placement | None) -> Groups | None:
        """Hear a frame (2, n_freqs); return the groups of ``lookahead`` frames ago, None where there are none."""
        if placement is None:
            self.reset()
            return None
        if placement.stretch != self._stretch:
            self.reset()
            self._stretch = placement.stretch
        elif self.fault:
            return None
        try:
            groups = self._separated(frame, self._scene(placement.tau), still=placement.still)
        except PluginError as error:
            self._fail(str(error))
            return None
        self._n_frames += 1
        return groups if self._n_frames > self._separator.lookahead else None

    def reset(self) -> None:
        """Forget this stretch."""
        self._state = self._learnt = None
        self._stretch, self._n_frames, self.fault = -1, 0, ""
        self._window.clear()

    def _separated(self, frame: Complex, scene: Scene, *, still: bool) -> Groups:
        if self._state is None:
            self._state = self._separator.start(scene)
        if still:  # what is heard in a turn tells nothing about either heading
            self._renew(scene)
            self._window.append(frame)
        self._state, groups = self._separator.step(self._state, frame, scene)
        return groups

    def _renew(self, scene: Scene) -> None:
        """Take over what was learnt, and have it learnt again."""
        outcome = self._learner.outcome()
        if outcome is not None and outcome.stretch == self._stretch:
            if outcome.fault:
                raise PluginError(outcome.fault)
            self._learnt = outcome.learnt
            self._state = self._separator.renewed(self._state, outcome.learnt)
        every = self._every if self._n_frames < self._early else LATER * self._every
        enough = len(self._window) >= self._least and self._n_frames % every == 0
        if enough and self._learner.idle:
            window = np.stack(tuple(self._window), axis=-1)
            self._measure_noise(window)
            self._learner.begin(LearningRequest(self._stretch, window, scene, self._learnt))

    def _measure_noise(self, window: Complex) -> None:
        """Take the noise from the lead-in, if that was quiet against what is heard since."""
        if self._noise_psd is None and self._lead_in and window.shape[-1] * self._stft.period >= JUDGED_S:
            self._noise_psd = quiet_psd(np.stack(tuple(self._lead_in), axis=-1), window)
            if self._noise_psd is None:
                self._lead_in.clear()

    def _scene(self, tau: Real) -> Scene:
        array = self._config.array
        return Scene(
            frequencies=self._stft.frequencies,
            spacing=array.spacing_m,
            speed_of_sound=array.speed_of_sound_m_s,
            n_sources=len(tau),
            tau=tau,
            noise_psd=self._noise_psd,
            seed=self._config.seed,
            hop=self._stft.hop,
        )

    def _fail(self, why: str) -> None:
        """Go on without voices until the next stretch."""
        self.fault = why
        self._state = None
        log.error("%s", why)
