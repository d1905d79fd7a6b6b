"""A small convolutional network for one picture and the state, trained by jax and optax.

Convolutions see where in the picture something is (the mean place of each feature, a spatial
softmax); a multilayer perceptron makes a chunk of rows of these places and the state.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead_tools.learn.network import model_bytes, perceptron

FILTERS = ((5, 2, 16), (3, 2, 32), (3, 1, 32))
"""Side, stride and number of each layer's filters."""

HIDDEN = (128, 128)
BATCH, RATE = 64, 1e-3
Weights = dict[str, npt.NDArray[np.float32]]


def draw_weights(side: int, state_dim: int, out_dim: int, seed: int) -> Weights:
    """The network before training, for pictures ``[3, side, side]``."""
    rng = np.random.default_rng(seed)
    made: dict[str, Any] = {}
    channels = 3
    for index, (size, stride, count) in enumerate(FILTERS):
        fan = channels * size * size
        made[f"k{index}"] = rng.normal(0, (2 / fan) ** 0.5, (count, channels, size, size))
        made[f"c{index}"] = np.zeros(count)
        channels, side = count, (side - size) // stride + 1
    widths = (2 * channels + state_dim, *HIDDEN, out_dim)
    for index, (fan, width) in enumerate(pairwise(widths)):
        made[f"w{index}"] = rng.normal(0, (2 / fan) ** 0.5, (fan, width))
        made[f"b{index}"] = np.zeros(width)
    made["places"] = _places(side)
    return {name: array.astype(np.float32) for name, array in made.items()}


def _places(side: int) -> npt.NDArray[np.float64]:
    """Where the numbers of a feature's map lie: ``[side * side, 2]``, from -1 to 1."""
    axis = np.linspace(-1, 1, side)
    return np.stack(np.meshgrid(axis, axis, indexing="ij"), -1).reshape(-1, 2)


def forward(weights: Any, pictures: Any, states: Any) -> Any:
    """jax: pictures float32 ``[n, 3, side, side]`` from 0 to 1, states ``[n, dim]``."""
    import jax

    seen = pictures
    for index, (_, stride, _) in enumerate(FILTERS):
        seen = jax.lax.conv_general_dilated(
            seen, weights[f"k{index}"], (stride, stride), "VALID",
            dimension_numbers=("NCHW", "OIHW", "NCHW"),
        ) + weights[f"c{index}"][None, :, None, None]  # fmt: skip
        if index < len(FILTERS) - 1:
            seen = jax.nn.relu(seen)
    maps = jax.nn.softmax(seen.reshape(*seen.shape[:2], -1), axis=2)
    places = (maps @ weights["places"]).reshape(len(pictures), -1)
    layer = jax.numpy.concatenate([places, states], axis=1)
    for index in range(len(HIDDEN)):
        layer = jax.nn.relu(layer @ weights[f"w{index}"] + weights[f"b{index}"])
    return layer @ weights[f"w{len(HIDDEN)}"] + weights[f"b{len(HIDDEN)}"]


def fit_pictures(
    pictures: npt.NDArray[np.uint8],
    given: Callable[[npt.NDArray[np.uint8]], npt.NDArray[np.float32]],
    states: npt.NDArray[np.float32],
    outputs: npt.NDArray[np.float32],
    seed: int,
    epochs: int,
    say: Callable[[str], None],
) -> Weights:
    """Least squares, by Adam with a rate that falls to 0.

    Args:
        pictures: uint8 ``[n, side, side, 3]``.
        given: makes of some of them what the policy is given, float32 ``[n, 3, side, side]``.
        states, outputs: normalised, ``[n, dim]``.
    """
    import jax
    import optax

    count, rng = len(states), np.random.default_rng(seed)
    weights = draw_weights(pictures.shape[1], states.shape[1], outputs.shape[1], seed)
    fixed = {"places": weights.pop("places")}
    batches = -(-count // BATCH)
    adam = optax.adam(optax.cosine_decay_schedule(RATE, batches * epochs))

    def loss(now: Any, seen: Any, state: Any, wanted: Any) -> Any:
        return ((forward(now | fixed, seen, state) - wanted) ** 2).mean()

    @partial(jax.jit, donate_argnums=(0, 1))
    def step(now: Any, memory: Any, seen: Any, state: Any, wanted: Any) -> Any:
        error, slope = jax.value_and_grad(loss)(now, seen, state, wanted)
        change, memory = adam.update(slope, memory)
        return optax.apply_updates(now, change), memory, error

    now: Any = jax.tree.map(jax.numpy.asarray, weights)
    memory = adam.init(now)
    for epoch in range(epochs):
        errors = []
        for chosen in np.split(np.resize(rng.permutation(count), batches * BATCH), batches):
            now, memory, error = step(
                now, memory, given(pictures[chosen]), states[chosen], outputs[chosen]
            )
            errors.append(float(error))
        if epoch % 5 == 4 or epoch == epochs - 1:
            say(f"epoch {epoch + 1} of {epochs}: {np.mean(errors):.4f} of a variance")
    return {name: np.asarray(array) for name, array in now.items()} | fixed


def sight_onnx(weights: Weights, name: str, side: int, horizon: int, dim: int) -> bytes:
    """The network as an ONNX model: ``name [1, 3, side, side]`` and ``state`` to ``actions``."""
    from onnx import TensorProto, helper, numpy_helper

    filters, value = FILTERS[-1][2], helper.make_tensor_value_info
    shapes = {"as_maps": [1, filters, -1], "as_row": [1, 2 * filters], "as_rows": [1, horizon, dim]}
    arrays = weights | {key: np.array(shape, np.int64) for key, shape in shapes.items()}
    state_dim = len(weights["w0"]) - 2 * filters
    graph = helper.make_graph(
        [*_seeing(name), *_deciding()],
        "behaviour cloning from pictures",
        [value(name, TensorProto.FLOAT, [1, 3, side, side]),
         value("state", TensorProto.FLOAT, [1, state_dim])],
        [value("actions", TensorProto.FLOAT, [1, horizon, dim])],
        [numpy_helper.from_array(array, key) for key, array in arrays.items()],
    )  # fmt: skip
    return model_bytes(graph)


def _seeing(name: str) -> list[Any]:
    """From the picture to the places of its features, ``found``."""
    from onnx import helper

    nodes, seen = [], name
    for index, (size, stride, _) in enumerate(FILTERS):
        weights = [f"k{index}", f"c{index}"]
        sizes: dict[str, Any] = {"kernel_shape": [size, size], "strides": [stride, stride]}
        nodes.append(helper.make_node("Conv", [seen, *weights], [f"seen{index}"], **sizes))
        seen = f"seen{index}"
        if index < len(FILTERS) - 1:
            nodes.append(helper.make_node("Relu", [seen], [f"some{index}"]))
            seen = f"some{index}"
    return [
        *nodes,
        helper.make_node("Reshape", [seen, "as_maps"], ["maps"]),
        helper.make_node("Softmax", ["maps"], ["shares"], axis=2),
        helper.make_node("MatMul", ["shares", "places"], ["where"]),
        helper.make_node("Reshape", ["where", "as_row"], ["found"]),
    ]


def _deciding() -> list[Any]:
    """From the places and the state to the rows."""
    from onnx import helper

    return [
        helper.make_node("Concat", ["found", "state"], ["layer0"], axis=1),
        *perceptron(len(HIDDEN) + 1),
        helper.make_node("Reshape", ["flat", "as_rows"], ["actions"]),
    ]
