"""Chunks, states and verdicts of a made-up run of the mobile robot."""

from __future__ import annotations

import msgspec
import numpy as np
import numpy.typing as npt

from fairlead.messages import (
    NO_HASH,
    NO_TRACE,
    Acted,
    ActionChunk,
    ActionPart,
    Hold,
    JointState,
    Outcome,
    Verdict,
    pack_floats,
)
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot

ROBOT = load_robot("panda_mobile")
ROW = Acted(hold=Hold.NONE, verdict_id=9, row=0)
NO_ROW = Acted(hold=Hold.NO_ROW, verdict_id=0, row=0)
ARM, GRIPPER, BASE = (ROBOT.part_names.index(name) for name in ("arm", "gripper", "base"))


def part(index: int, mode: ControlMode, rows: npt.ArrayLike, active: tuple[int, ...]) -> ActionPart:
    frame = ROBOT.base_frame if index == ARM else ""
    return ActionPart(
        part=index, mode=mode, frame_id=frame, values=pack_floats(rows), active=active
    )


def some_parts() -> tuple[ActionPart, ...]:
    arm = [[0.03, 0.04, 0.0, 0.0, 0.0, 0.1], [0.0] * 6]
    base = np.zeros((2, ROBOT.n_dof))
    base[:, 0] = [0.5, 0.25]
    return (
        part(ARM, ControlMode.CARTESIAN_DELTA, arm, ()),
        part(GRIPPER, ControlMode.GRIPPER_POSITION, [[0.08], [0.0]], ()),
        part(BASE, ControlMode.JOINT_VELOCITY, base, (0, 1)),
    )


def candidate(source: str = "runner", start_tick: int = 10) -> ActionChunk:
    return ActionChunk(
        robot_hash=NO_HASH, session=1, epoch=1, claim_id=1, source=source, seq=1, goal_id=1,
        obs_tick=start_tick, oldest_tick=start_tick, start_tick=start_tick, horizon=2,
        parts=some_parts(), trace=NO_TRACE,
    )  # fmt: skip


def joints(
    tick: int,
    acted: tuple[Acted, ...],
    yaw: float = 0.0,
    first_joint: float = 0.0,
    base_x: float | None = None,
) -> JointState:
    n = len(ROBOT.measured_joint_names)
    positions, velocities = np.zeros(n), np.zeros(n)
    positions[ROBOT.joint_names.index("panda_gripper")] = 0.001 * tick
    positions[ROBOT.joint_names.index("base_yaw")] = yaw
    positions[ROBOT.joint_names.index("panda_joint1")] = first_joint
    velocities[0] = 0.01 * tick if base_x is None else base_x
    return JointState(
        session=1, tick=tick, episode_tick=1, stamp_ns=0, positions=pack_floats(positions),
        velocities=pack_floats(velocities), efforts=pack_floats(np.zeros(n)), acted=acted,
        robot_hash=NO_HASH,
    )  # fmt: skip


def verdict(
    seq: int, outcome: Outcome, code: int = 0, source: str = "runner", released: int = 0
) -> Verdict:
    return Verdict(
        verdict_id=seq, session=1, epoch=1, claim_id=1, source=source, seq=seq, outcome=outcome,
        code=code, row=-1, part="", axis="", value=0.0, limit=0.0, margin=0.0, limit_source="",
        released_first=released, released_last=released, config_hash=NO_HASH, latency_ns=0,
    )  # fmt: skip


def replace_parts(parts: list[ActionPart]) -> ActionChunk:
    return msgspec.structs.replace(candidate(), parts=tuple(parts))
