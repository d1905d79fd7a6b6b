"""Dispatch: a policy's flat float32 rows become typed action parts in SI.

Pure arithmetic along routes that `fairlead.skill.routes` has resolved; which dimension goes
where, and what is discarded, has been decided and checked there.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import ActionPart, FloatArray, pack_floats
from fairlead.policy import Actions
from fairlead.skill.routes import Route


def dispatch(routes: Sequence[Route], actions: Actions, dim: int) -> tuple[ActionPart, ...]:
    """One action part per route, rows in the order given.

    Args:
        routes: from `fairlead.skill.routes.resolve_routes`.
        actions: float32 ``[H, dim]``, the policy's normalised output.
        dim: the action contract's width.

    Returns:
        Parts with float64 values ``[H, width]`` in SI; joint modes are padded with 0.0
        to the robot's joints and name the commanded ones in ``active``, and a binary
        gripper with a threshold gets exactly 0.0 or 1.0.

    Raises:
        ConfigError: if ``actions`` is not ``[H >= 1, dim]`` of float32.
    """
    if (
        actions.dtype != np.float32
        or actions.ndim != 2
        or actions.shape[1] != dim
        or not len(actions)
    ):
        got = f"{actions.dtype} {list(actions.shape)}"
        raise ConfigError(expected("dispatch", f"float32 [H >= 1, {dim}]", got))
    return tuple(_part(route, actions) for route in routes)


def _part(route: Route, actions: Actions) -> ActionPart:
    # float64 before scaling: the HAL undoes the scale and rounds to float32, which gives
    # the policy's own bits back.
    outputs = actions[:, route.sources].astype(np.float64)
    values = np.zeros((len(actions), route.width))
    values[:, route.columns] = outputs * np.asarray(route.scale)
    # Adding 0.0 would turn the policy's -0.0 into 0.0, and the bits would differ.
    for output, column, offset in zip(outputs.T, route.columns, route.offset, strict=True):
        if offset != 0.0:
            values[:, column] += _beside(offset, output) if route.threshold is None else offset
    if route.threshold is not None:
        # What is no number stays what it is: the gate stops for it, and no gripper opens.
        values = np.where(np.isfinite(values), values >= route.threshold, values)
    return ActionPart(
        part=route.part,
        mode=int(route.mode),
        frame_id=route.frame_id,
        values=pack_floats(values),
        active=route.active,
    )


def _beside(offset: float, output: FloatArray) -> FloatArray:
    """The offset; for an output of -0.0 the number next to it, by which the HAL knows that zero."""
    is_negative_zero = (output == 0.0) & np.signbit(output)
    return np.where(is_negative_zero, np.nextafter(offset, 0.0), offset)
