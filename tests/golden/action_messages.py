"""What is proposed and what is released."""

from __future__ import annotations

from fairlead.messages import (
    NO_HASH,
    NO_TRACE,
    Acted,
    ActionChunk,
    ActionPart,
    Hold,
    SafeChunk,
    pack_floats,
)
from fairlead.modes import ControlMode
from tests.golden.values import (
    CLAIM,
    EPOCH,
    GOAL,
    HUGE,
    ROBOT_HASH,
    SESSION,
    TINY,
    TRACE,
    U32_MAX,
    U64_MAX,
    VERDICT,
    ramp,
)


def arm_delta(rows: int, first: float = 0.01) -> ActionPart:
    """``rows`` of the arm's cartesian_delta."""
    return ActionPart(
        part=0,
        mode=ControlMode.CARTESIAN_DELTA,
        frame_id="base_link",
        values=ramp(6 * rows, first, 0.001),
        active=(),
    )


def base_velocity(rows: int) -> ActionPart:
    """``rows`` of the base's joint_velocity: three active joints of eleven, zeros elsewhere."""
    one_row = [0.25, -0.5, 0.75] + [0.0] * 8
    return ActionPart(
        part=2,
        mode=ControlMode.JOINT_VELOCITY,
        frame_id="",
        values=pack_floats(one_row * rows),
        active=(0, 1, 2),
    )


def composite(rows: int) -> ActionPart:
    """``rows`` of the composite switch."""
    return ActionPart(
        part=3,
        mode=ControlMode.COMPOSITE_MODE,
        frame_id="",
        values=pack_floats([-1.0] * rows),
        active=(),
    )


def gripper(rows: int) -> ActionPart:
    """``rows`` of the gripper's opening [m]."""
    return ActionPart(
        part=1,
        mode=ControlMode.GRIPPER_POSITION,
        frame_id="",
        values=ramp(rows, 0.01, 0.005),
        active=(),
    )


ACTION = {
    "ActionChunk": ActionChunk(
        robot_hash=ROBOT_HASH,
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        seq=42,
        goal_id=GOAL,
        obs_tick=1006,
        oldest_tick=1002,
        start_tick=1007,
        horizon=2,
        parts=(arm_delta(2), gripper(2), base_velocity(2), composite(2)),
        trace=TRACE,
    ),
    "ActionChunk.one_row": ActionChunk(
        robot_hash=ROBOT_HASH,
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        seq=1,
        goal_id=0,
        obs_tick=1,
        oldest_tick=1,
        start_tick=1,
        horizon=1,
        parts=(composite(1),),
        trace=NO_TRACE,
    ),
    "ActionChunk.empty": ActionChunk(
        robot_hash=NO_HASH,
        session=0,
        epoch=0,
        claim_id=0,
        source="",
        seq=0,
        goal_id=0,
        obs_tick=0,
        oldest_tick=0,
        start_tick=0,
        horizon=0,
        parts=(),
        trace=NO_TRACE,
    ),
    "ActionChunk.full_horizon": ActionChunk(
        robot_hash=ROBOT_HASH,
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner-" + "x" * 40,
        seq=U64_MAX,
        goal_id=U64_MAX,
        obs_tick=2**32,
        oldest_tick=2**32 - 1,
        start_tick=2**32 + 1,
        horizon=64,
        parts=(arm_delta(64, -0.02), gripper(64), base_velocity(64), composite(64)),
        trace=TRACE,
    ),
    "ActionChunk.extremes": ActionChunk(
        robot_hash=ROBOT_HASH,
        session=U64_MAX,
        epoch=U64_MAX,
        claim_id=U64_MAX,
        source="é€😀",
        seq=127,
        goal_id=128,
        obs_tick=255,
        oldest_tick=256,
        start_tick=65_536,
        horizon=U32_MAX,
        parts=(
            ActionPart(
                part=255,
                mode=255,
                frame_id="f" * 256,
                values=pack_floats([float("nan"), float("inf"), float("-inf"), TINY, HUGE, -0.0]),
                active=tuple(range(16)),
            ),
        ),
        trace=TRACE,
    ),
    "SafeChunk": SafeChunk(
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        verdict_id=VERDICT,
        judged_tick=1006,
        first_tick=1007,
        horizon=2,
        after=Acted(hold=Hold.NONE, verdict_id=VERDICT - 1, row=7),
        parts=(arm_delta(2), gripper(2), base_velocity(2), composite(2)),
    ),
    "SafeChunk.after_hold": SafeChunk(
        session=SESSION,
        epoch=EPOCH,
        claim_id=CLAIM,
        source="runner",
        verdict_id=U64_MAX,
        judged_tick=1,
        first_tick=2,
        horizon=1,
        after=Acted(hold=Hold.NO_CLAIM, verdict_id=0, row=0),
        parts=(arm_delta(1),),
    ),
}
