"""What the simulated mobile manipulator's HAL says of itself, written down by hand."""

from __future__ import annotations

from fairlead.messages import HalCamera, HalPart, HalStatus, ModeRange, pack_floats
from fairlead.modes import ControlMode
from fairlead.robot.manifest import load_robot

ROBOT = load_robot("panda_mobile")
RANGES = {
    "arm": {ControlMode.CARTESIAN_DELTA: [0.05, 0.05, 0.05, 0.5, 0.5, 0.5]},
    "gripper": {ControlMode.GRIPPER_POSITION: [0.08]},
    "base": {ControlMode.JOINT_VELOCITY: [1.0, 1.0, 1.5]},
    "composite": {ControlMode.COMPOSITE_MODE: [1.0]},
}


def hal_part(name: str) -> HalPart:
    ranges = tuple(
        ModeRange(
            mode=mode,
            lower=pack_floats([0.0 if name == "gripper" else -v for v in upper]),
            upper=pack_floats(upper),
        )
        for mode, upper in RANGES[name].items()
    )
    joints = ROBOT.part(name).joints
    return HalPart(name=name, simulator_part="", joints=joints, ranges=ranges)


HAL = HalStatus(
    session=1,
    robot="panda_mobile",
    robot_hash=ROBOT.robot_hash,
    pacing="lockstep",
    period_ns=ROBOT.tick_period_ns,
    tick=1,
    episode_tick=1,
    state="ready",
    detail="",
    joints=ROBOT.joint_names,
    passive_joints=ROBOT.passive_joint_names,
    parts=tuple(hal_part(name) for name in ROBOT.part_names),
    simulator_order=(),
    cameras=(HalCamera(name="front", width=128, height=128, period_ticks=2),),
    has_task=True,
    overruns=0,
)
