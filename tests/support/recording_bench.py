"""Inputs of a mission, and a recorder that writes them into a folder."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np

from ross_payload.config import Config
from ross_payload.interfaces import Attitude, AudioBlock, Input
from ross_payload.recording.manifest import Beginning
from ross_payload.recording.recorder import Recorder
from ross_payload.recording.session import Session
from ross_payload.recording.shelf import Shelf

HOP = 160
SUPPORT = str(Path(__file__).parent)  # where another process finds this
GRID = 2.0**-23


def block_of(index, raw=None):
    generator = np.random.default_rng(index)
    samples = generator.integers(-(2**23), 2**23, (2, HOP)).astype(np.float32) * np.float32(GRID)
    return AudioBlock(samples, index * HOP, 0.1 + index * 0.01, raw=raw)


def input_of(index, **changes):
    heading = math.sin(index / 7)
    return replace(Input(block_of(index), heading, heading + 1e-9, heading / 3, True, Attitude(0.1)), **changes)


def configured(**recording):
    return Config.model_validate({"recording": recording})


def beginning(config=None, **changes):
    return replace(Beginning("mission", config or Config(), -3.0, math.inf, "ann"), **changes)


def recording(folder, begin=beginning, **limits):
    limits = {"always": True, "min_free_gb": 0} | limits
    return Recorder(Shelf(folder), configured(**limits).recording, begin)


def record(folder, inputs, said=(), **limits):
    with recording(folder, **limits) as recorder:
        for index, heard in enumerate(inputs):
            recorder.heard(heard)
            for event in said:
                recorder.said(event, heard)
            if index % 50 == 49:
                recorder.drain()
    return recorder


def only(folder):
    (kept,) = Shelf(folder).all()
    return Session.open(kept.path)


def equal(one, other):
    assert np.array_equal(one.block.samples, other.block.samples)
    return replace(one, block=None) == replace(other, block=None) and (
        one.block.index, one.block.time, one.block.lost, one.block.flags
    ) == (other.block.index, other.block.time, other.block.lost, other.block.flags)  # fmt: skip
