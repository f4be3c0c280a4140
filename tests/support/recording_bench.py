"""Inputs of a mission, and a recorder that writes them into a folder."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from ross_payload.config import Config
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.pointing import Pointing
from ross_payload.sessions.manifest import Beginning
from ross_payload.sessions.recorder import Recorder
from ross_payload.sessions.session_reader import RecordedSession
from ross_payload.sessions.session_store import SessionStore

HOP = 160
SUPPORT = str(Path(__file__).parent)  # where another process finds this
GRID = 2.0**-23


def block_of(index):
    generator = np.random.default_rng(index)
    samples = generator.integers(-(2**23), 2**23, (2, HOP)).astype(np.float32) * np.float32(GRID)
    return AudioBlock(samples, index * HOP, 0.1 + index * 0.01)


def input_of(index, **changes):
    heading = math.sin(index / 7)
    pointing = Pointing(0.1 + index * 0.01, heading / 3, 0.1, heading, earth=True)
    heard = replace(Input(block_of(index), heading, pointing, True, Attitude(0.1)), **changes)
    return replace(heard, pointing=replace(heard.pointing, earth=heard.attitude.known))


def configured(**recording):
    return Config.model_validate({"recording": recording})


def beginning(config=None, **changes):
    return replace(Beginning("mission", config or Config(), -3.0, math.inf, "ann"), **changes)


def recording(folder, begin=beginning, **limits):
    limits = {"always": True, "min_free_gb": 0} | limits
    return Recorder(SessionStore(folder), configured(**limits).recording, begin)


def record(folder, inputs, said=(), **limits):
    with recording(folder, **limits) as recorder:
        for index, heard in enumerate(inputs):
            recorder.on_input(heard)
            for event in said:
                recorder.on_event(event, heard)
            if index % 50 == 49:
                recorder.drain()
    return recorder


def only(folder):
    (kept,) = SessionStore(folder).all()
    return RecordedSession.open(kept.path)


def equal(one, other):
    assert np.array_equal(one.block.samples, other.block.samples)
    return replace(one, block=None) == replace(other, block=None) and (
        one.block.index, one.block.time, one.block.lost, one.block.flags
    ) == (other.block.index, other.block.time, other.block.lost, other.block.flags)  # fmt: skip
