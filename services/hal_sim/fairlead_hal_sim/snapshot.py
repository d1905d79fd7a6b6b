"""A simulator's pose state as bytes, enough to draw it in another process.

Content: qpos, mocap positions and quaternions, body positions and quaternions (an
environment may move fixtures by editing the model), each float64 in the model's order.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from fairlead.errors import MessageError


def take_snapshot(sim: Any) -> bytes:
    """Pose state of a robosuite simulation."""
    return b"".join(np.ascontiguousarray(a, dtype="<f8").tobytes() for a in _blocks(sim))


def restore_snapshot(sim: Any, snapshot: bytes) -> None:
    """Put a simulation of the same model into the snapshot's poses, ready to render.

    Raises:
        MessageError: if the snapshot was taken from another model.
    """
    blocks = _blocks(sim)
    size = 8 * sum(block.size for block in blocks)
    if len(snapshot) != size:
        raise MessageError(f"snapshot: expected {size} bytes for this model, got {len(snapshot)}")
    start = 0
    for block in blocks:
        values = np.frombuffer(snapshot, dtype="<f8", count=block.size, offset=start)
        block[...] = values.reshape(block.shape)
        start += 8 * block.size
    sim.forward()


def _blocks(sim: Any) -> list[Any]:
    model, data = sim.model._model, sim.data._data
    return [data.qpos, data.mocap_pos, data.mocap_quat, model.body_pos, model.body_quat]
