"""From the policy's rows to a candidate: the chunk that is proposed to the gate.

Pure arithmetic along routes that `fairlead.skill.routes` has resolved; which dimension goes
where, and what is discarded, has been decided and checked there.
"""

from __future__ import annotations

from collections.abc import Sequence

import msgspec
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import ActionChunk, ActionPart, FloatArray, encode, floats, pack_floats
from fairlead.policy import Actions
from fairlead.skill.routes import Route
from fairlead_skill_runner.chunk_tracker import SentChunk
from fairlead_skill_runner.control_rows import control_rows
from fairlead_skill_runner.observation_buffer import TimedObservation
from fairlead_skill_runner.run_setup import RunSetup
from fairlead_skill_runner.seam import ReleasedRows, Seam, held_rows


def candidate(
    setup: RunSetup,
    seq: int,
    asked: TimedObservation,
    actions: Actions,
    now_tick: int,
    positions: FloatArray,
    before: ReleasedRows | None = None,
    others_act: bool = False,
) -> SentChunk:
    """The chunk of all parts for one answer of the policy, encoded once.

    Lockstep: only the rows that will be executed; realtime: all, the gate drops by index
    those that have passed.

    Args:
        seq: the chunk's number within the claim.
        asked: the observation the policy answered; its tick is the first row's.
        actions: float32 ``[H, dim]``, the policy's answer.
        now_tick: the newest tick, from which the gate's verdict is awaited.
        positions: of the measured joints in that tick, in wire order [rad or m].
        before: released rows that act now and next.
        others_act: rows of the goal before this one act now. They are not known here: nothing
            leads over from them, nor from where the joints are, which would lead back.

    Raises:
        ConfigError: if ``actions`` is not as wide as the skill's action contract.
    """
    steps = min(len(actions), setup.skill.execute_steps) if setup.lockstep else len(actions)
    horizon = steps * setup.periods
    tick = asked.observation.tick
    widths = [route.width for route in setup.routes]
    proposed = dispatch(setup.routes, actions, setup.skill.action_contract.dim)
    parts = _completed(
        setup,
        control_rows(proposed, widths, setup.periods, setup.skill.between, horizon),
        positions,
    )
    seam = setup.skill.seam
    if seam is not None and not setup.lockstep:
        if before is None or before.last_tick < now_tick:
            before = held_rows(() if others_act else parts, positions[: setup.n_dof], now_tick)
        parts = Seam(before, now_tick, seam.blend_ticks).blended(parts, widths, tick)
    message = ActionChunk(
        robot_hash=setup.robot_hash,
        session=setup.session,
        epoch=setup.epoch,
        claim_id=setup.claim_id,
        source=setup.source,
        seq=seq,
        goal_id=setup.goal_id,
        obs_tick=tick,
        oldest_tick=asked.oldest_tick,
        start_tick=tick,
        horizon=horizon,
        parts=parts,
        trace=setup.trace_of(seq),
    )
    return SentChunk(seq, tick, horizon, now_tick, encode(message), parts)


def _completed(
    setup: RunSetup, parts: tuple[ActionPart, ...], positions: FloatArray
) -> tuple[ActionPart, ...]:
    """Rows of tools with free axes, these filled in."""
    made = []
    for part in parts:
        free = setup.free_axes.get(part.part)
        if free is not None:
            rows = free.completed(floats(part.values, 6), positions)
            part = msgspec.structs.replace(part, values=pack_floats(rows))
        made.append(part)
    return tuple(made)


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
