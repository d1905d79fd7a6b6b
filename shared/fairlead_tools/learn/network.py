"""The network: features of the state, a multilayer perceptron of scikit-learn, written as ONNX."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead.messages import FloatArray

REACH_M, STAGING_M = 0.55, 0.40
GRIP_M, HOVER_M, LIFTED_M = 0.03, 0.105, 0.16
OBJECT_BOTTOM_M = 0.05
"""The expert's distances: of the base from what it reaches for, of the hand above the object, of
its centre above what it stands on."""

FINE = (0.01, 0.04, 0.15)
"""Lengths [m, rad] at which differences that decide are seen."""

BATCH = 128
RATES = ((0.6, 1e-3), (0.25, 3e-4), (0.15, 1e-4))
"""Share of the epochs, and Adam's learning rate in it."""

OPSET, IR_VERSION = 17, 8


@dataclass(frozen=True)
class Features:
    """``tanh(state @ weights + bias)`` beside ``state @ linear``; of the normalised state.

    weights: float64 ``[30, n]``; bias: ``[n]``; linear: ``[30, m]``.
    """

    weights: FloatArray
    bias: FloatArray
    linear: FloatArray

    def __call__(self, states: FloatArray) -> FloatArray:
        """Of states ``[k, 30]``: ``[k, n + m]``."""
        return np.hstack([np.tanh(states @ self.weights + self.bias), states @ self.linear])


def features(centre: FloatArray, spread: FloatArray) -> Features:
    """For ``mobile_pick_30d``, whose normalised numbers are (x - centre) / spread.

    Seen at several lengths: object and goal from the hand, and both from where the base stands to
    grasp and to place. The object's own rotation, which is any, is left out.
    """
    rows, offsets = [], []

    def see(offset: float, scales: tuple[float, ...], **terms: float) -> None:
        row = np.zeros(len(centre))
        for name, factor in terms.items():
            row[int(name[1:])] = factor
        for scale in scales:
            rows.append(row / scale)
            offsets.append(-offset / scale)

    for axis in range(3):
        for offset in (0.0,) if axis < 2 else (0.0, -GRIP_M, -HOVER_M, -LIFTED_M):
            see(offset, FINE, **{f"s{16 + axis}": 1.0, f"s{axis}": -1.0})
        see(0.0, FINE, **{f"s{23 + axis}": 1.0, f"s{axis}": -1.0})
        see(0.0, FINE, **{f"s{23 + axis}": 1.0, f"s{16 + axis}": -1.0})
    for first, places in ((16, (REACH_M,)), (23, (REACH_M, REACH_M + STAGING_M))):
        for ahead in places:
            see(ahead, FINE, **{f"s{first}": 1.0})
        see(0.0, FINE, **{f"s{first + 1}": 1.0})
    see(0.0, FINE, s12=2.0)  # the base's heading, and the goal's in the base
    see(0.0, FINE, s28=2.0)
    see(OBJECT_BOTTOM_M, FINE, s18=1.0, s25=-1.0)  # above the shelf
    see(0.03, (0.002, 0.005, 0.02), s14=1.0)
    for axis in range(3):  # where the hand is carried
        see((REACH_M, 0.0, 0.2)[axis], FINE, **{f"s{axis}": 1.0})
    raw = np.array(rows).T
    used = [*range(19), *range(23, 30)]
    linear = np.eye(len(centre))[:, used]
    return Features(raw * spread[:, None], centre @ raw + np.array(offsets), linear)


def fit(
    inputs: FloatArray, outputs: FloatArray, seed: int, widths: tuple[int, ...], epochs: int
) -> Any:
    """scikit-learn's ``MLPRegressor`` on ``[n, k]`` and ``[n, m]``; the same seed, the same net."""
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.neural_network import MLPRegressor
    from threadpoolctl import threadpool_limits  # scikit-learn needs it too

    net = MLPRegressor(
        hidden_layer_sizes=widths, batch_size=min(BATCH, len(inputs)), alpha=1e-6,
        random_state=seed, tol=0.0, n_iter_no_change=epochs, warm_start=True,
    )  # fmt: skip
    with warnings.catch_warnings(), threadpool_limits(1):  # sums do not depend on the machine
        warnings.simplefilter("ignore", ConvergenceWarning)  # it always trains that long
        for share, rate in RATES:
            net.set_params(max_iter=max(1, round(epochs * share)), learning_rate_init=rate)
            net.fit(inputs.astype(np.float32), outputs.astype(np.float32))
    return net


def onnx_bytes(seen: Features, net: Any, horizon: int, dim: int) -> bytes:
    """The whole as an ONNX model: ``state [1, 30]`` to ``actions [1, horizon, dim]``, float32."""
    from onnx import TensorProto, helper, numpy_helper

    constants: dict[str, npt.NDArray[Any]] = {
        "fine": seen.weights, "offset": seen.bias, "linear": seen.linear
    }  # fmt: skip
    nodes = [
        helper.make_node("Gemm", ["state", "fine", "offset"], ["scaled"]),
        helper.make_node("Tanh", ["scaled"], ["near"]),
        helper.make_node("MatMul", ["state", "linear"], ["plain"]),
        helper.make_node("Concat", ["near", "plain"], ["layer0"], axis=1),
    ]
    for index, (weights, bias) in enumerate(zip(net.coefs_, net.intercepts_, strict=True)):
        constants |= {f"w{index}": weights, f"b{index}": bias}
    nodes += perceptron(len(net.coefs_))
    nodes.append(helper.make_node("Reshape", ["flat", "shape"], ["actions"]))
    initial = [numpy_helper.from_array(a.astype(np.float32), n) for n, a in constants.items()]
    initial.append(numpy_helper.from_array(np.array([1, horizon, dim], np.int64), "shape"))
    value = helper.make_tensor_value_info
    graph = helper.make_graph(
        nodes,
        "behaviour cloning",
        [value("state", TensorProto.FLOAT, [1, len(seen.weights)])],
        [value("actions", TensorProto.FLOAT, [1, horizon, dim])],
        initial,
    )
    return model_bytes(graph)


def perceptron(layers: int) -> list[Any]:
    """Nodes from ``layer0`` to ``flat``, with weights ``w0``, ``b0`` and so on."""
    from onnx import helper

    nodes, last = [], layers - 1
    for index in range(layers):
        out = "flat" if index == last else f"sum{index}"
        nodes.append(helper.make_node("Gemm", [f"layer{index}", f"w{index}", f"b{index}"], [out]))
        if index < last:
            nodes.append(helper.make_node("Relu", [out], [f"layer{index + 1}"]))
    return nodes


def model_bytes(graph: Any) -> bytes:
    """A checked model of a graph."""
    import onnx
    from onnx import helper

    opset = helper.make_opsetid("", OPSET)
    model = helper.make_model(graph, opset_imports=[opset], ir_version=IR_VERSION)
    onnx.checker.check_model(model)
    data: bytes = model.SerializeToString()
    return data
