"""The gripper beside a part that is driven: told nothing until the person opens or closes it."""

from __future__ import annotations

from fairlead.errors import ConfigError
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.mode_limits import GripperPositionMode, JointPositionMode
from fairlead.robot.part import Part
from fairlead.robot.safety_profile import SafetyProfile
from fairlead_tools.teleop.device import Deflection

SHARE = 0.8
"""Of what the gate lets pass, and of the joint's speed."""
HALF = 0.5


def grips(robot: RobotManifest, part: Part) -> bool:
    """Whether a part is a gripper."""
    roles = {robot.joint(name).role for name in part.joints}
    return part.only_grips or roles == {"gripper"}


def gripper_beside(robot: RobotManifest, part: str) -> str:
    """The part that opens and closes the end effector of another part; "" if there is none."""
    tool = robot.part(part).end_effector
    joint = robot.end_effector(tool).gripper_joint if tool else None
    beside = (
        one.name
        for one in robot.parts
        if joint in one.joints and one.name != part and grips(robot, one)
    )
    return next(beside, "")


class Grip:
    """What a gripper is told; nothing before the person says so, so that a grasp is kept.

    Attributes:
        part, mode: of the robot.
        joint: whose measured position `target` wants.
    """

    def __init__(self, robot: RobotManifest, limits: SafetyProfile, part: str) -> None:
        self.part, self.joint = part, robot.part(part).joints[0]
        own, joint = limits.parts[part], robot.joint(self.joint)
        tolerance = limits.measured[self.joint].tolerance or 0.0
        fastest = joint.velocity_limit * robot.tick_period_ns * 1e-9
        self._target: float | None = None
        block: GripperPositionMode | JointPositionMode
        if own.gripper_position is not None:
            self.mode, block = ControlMode.GRIPPER_POSITION, own.gripper_position
            self._lower, self._upper, most = block.lower, block.upper, block.step_limit
        elif own.joint_position is not None:
            self.mode, block = ControlMode.JOINT_POSITION, own.joint_position
            self._lower, self._upper, most = joint.lower, joint.upper, block.step_limits[0]
        elif own.gripper_binary is not None:
            self.mode, self._lower, self._upper, most = ControlMode.GRIPPER_BINARY, 0.0, 1.0, 1.0
        else:
            raise ConfigError(f"part {part}: none of its modes opens and closes it by hand")
        self._step = SHARE * min(fastest, most)
        self._lead = most + 0.5 * tolerance

    def target(self, measured: float, asked: Deflection) -> float | None:
        """What it is told in this tick, in its mode's unit; None: nothing.

        Args:
            measured: where its joint is [m or rad].
        """
        if not asked.clutch or not (asked.grip or asked.opening is not None):
            return self._target
        if self.mode is ControlMode.GRIPPER_BINARY:
            opens = asked.grip > 0 if asked.opening is None else asked.opening > HALF
            self._target = 0.0 if opens else 1.0
            return self._target
        now = measured if self._target is None else self._target
        if asked.opening is None:
            way = self._step * min(max(asked.grip, -1.0), 1.0)
        else:
            way = self._lower + asked.opening * (self._upper - self._lower) - now
            most = self._step * min(max(asked.speed, 0.0), 1.0)
            way = min(max(way, -most), most)
        now += way
        now = min(max(now, measured - self._lead), measured + self._lead)
        self._target = min(max(now, self._lower), self._upper)
        return self._target
