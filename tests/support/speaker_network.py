"""A small network of speakers as an ONNX file, and something that it can tell apart.

The network takes the spread of filter banks over time, and projects it to a few numbers.
"""

import numpy as np
import onnx
from onnx import TensorProto, helper, numpy_helper

from ross_payload.voiceprint.features import RATE

SIZE = 16


def speaker_network(
    bands=80, size=SIZE, seed=0, *, over_time=True, licence="CC0-1.0", frames="frames", last="embedding"
):
    """Return its bytes; ``last`` is what it gives.

    ``nothing`` are zeros, ``roots`` those of numbers of either sign, ``by_frame`` as many numbers as there are frames,
    ``fixed`` the same of every voice; ``endless`` never comes.
    """
    weights = np.random.default_rng(seed).standard_normal((bands, size)).astype(np.float32)
    nodes = [
        helper.make_node("Abs", ["feats"], ["size"]),
        helper.make_node("ReduceMean", ["size"], ["mean"], axes=[1], keepdims=0 if over_time else 1),
        helper.make_node("MatMul", ["mean", "weights"], ["embedding"]),
        helper.make_node("Sub", ["embedding", "embedding"], ["nothing"]),
        helper.make_node("Sqrt", ["embedding"], ["roots"]),
        helper.make_node("ReduceMean", ["size"], ["by_frame"], axes=[2], keepdims=0),
        helper.make_node("Add", ["nothing", "one"], ["fixed"]),
    ]
    if last == "endless":
        nodes.append(helper.make_node("Loop", ["", "true", "embedding"], ["endless"], body=_unchanged()))
    feats = helper.make_tensor_value_info("feats", TensorProto.FLOAT, ["batch", frames, bands])
    shape = ["batch", size] if over_time else ["batch", 1, size]
    embedding = helper.make_tensor_value_info(
        last, TensorProto.FLOAT, shape if last != "by_frame" else ["batch", frames]
    )
    constants = {"weights": weights, "one": np.float32(1.0), "true": np.array(True)}
    kept = [numpy_helper.from_array(np.asarray(value), name) for name, value in constants.items()]
    graph = helper.make_graph(nodes, "speakers", [feats], [embedding], kept)
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 13)], ir_version=8)
    if licence:
        helper.set_model_props(model, {"license": licence})
    onnx.checker.check_model(model)
    return model.SerializeToString()


def _unchanged():
    """Return the body of a loop that passes on what it is given, and goes on."""
    inputs = [
        helper.make_tensor_value_info("turn", TensorProto.INT64, []),
        helper.make_tensor_value_info("on", TensorProto.BOOL, []),
        helper.make_tensor_value_info("held", TensorProto.FLOAT, None),
    ]
    nodes = [helper.make_node("Identity", [a], [b]) for a, b in (("on", "still_on"), ("held", "passed_on"))]
    outputs = [
        helper.make_tensor_value_info("still_on", TensorProto.BOOL, []),
        helper.make_tensor_value_info("passed_on", TensorProto.FLOAT, None),
    ]
    return helper.make_graph(nodes, "unchanged", inputs, outputs)


def vowel(pitch=120.0, formant=700.0, seconds=4.0, seed=0):
    """Something voiced whose spectrum has one formant; (n,) at RATE."""
    time = np.arange(round(seconds * RATE)) / RATE
    wander = 1 + 0.02 * np.sin(2 * np.pi * 3 * time + seed)
    phase = 2 * np.pi * np.cumsum(pitch * wander) / RATE
    heights = [np.exp(-(((k * pitch - formant) / 300) ** 2)) + 0.01 for k in range(1, 50) if k * pitch < 7000]
    voiced = sum(height * np.sin(k * phase) for k, height in enumerate(heights, 1))
    syllables = 0.6 + 0.4 * np.sin(2 * np.pi * 4 * time)
    return 0.1 * voiced * syllables + 1e-4 * np.random.default_rng(seed).standard_normal(len(time))
