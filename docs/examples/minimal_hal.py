"""A complete HAL: an arm whose joints do at once what they are told."""

import sys
from collections.abc import Mapping, Sequence

import numpy as np

from fairlead import ControlMode, RobotManifest
from fairlead.errors import ConfigError, expected
from fairlead.hal import BackendDescription, FramePose, Measurement, PartCommand, describe_part
from fairlead.hal.process import Equipment, run_hal
from fairlead.service import ServiceContext, run_service

HERE, UPRIGHT = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])


class MinimalArm:
    """Any arm. A driver would talk to the arm's controller in `read` and `apply`."""

    def __init__(self, robot: RobotManifest, profile: str) -> None:
        self.robot, self.profile, self.period_s = robot, profile, robot.tick_period_ns * 1e-9
        joints = [*robot.joints, *robot.passive_joints]  # fingers that nobody commands stand still
        start = {j.name: (j.lower + j.upper) / 2 if j.has_bounds else 0.0 for j in joints}
        start |= robot.home.positions if robot.home else {}
        self.positions = np.array([start[joint.name] for joint in joints])
        self.velocities = np.zeros(len(joints))

    def describe(self) -> BackendDescription:
        robot = self.robot
        parts = tuple(describe_part(robot, part, self.profile) for part in robot.parts)
        return BackendDescription(
            robot.joint_names, robot.passive_joint_names, parts, (), cameras=(), has_task=False
        )

    def read(self) -> Measurement:
        efforts = np.zeros(len(self.positions))
        return Measurement(self.positions.copy(), self.velocities.copy(), efforts)

    def transforms(self) -> Sequence[FramePose]:
        return [FramePose("odom", self.robot.base_frame, HERE, UPRIGHT)]

    def static_transforms(self) -> Sequence[FramePose]:
        return [FramePose("map", "odom", HERE, UPRIGHT)]

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        target = self.positions.copy()  # a part without a command keeps its position
        for part, command in commands.items():
            joints = list(command.active)
            if command.mode == ControlMode.JOINT_POSITION:
                target[joints] = command.values[joints]
            elif command.mode == ControlMode.JOINT_VELOCITY:
                target[joints] += command.values[joints] * self.period_s
            elif command.mode == ControlMode.GRIPPER_POSITION:
                hand = self.robot.joint_names.index(self.robot.part(part).joints[0])
                reach = 0.5 * self.robot.joints[hand].velocity_limit * self.period_s
                target[hand] += np.clip(command.values[0] - target[hand], -reach, reach)
            else:
                raise ConfigError(expected(part, "a mode this arm can do", command.mode.yaml_name))
        self.velocities = (target - self.positions) / self.period_s
        self.positions = target

    def task(self) -> None:
        return None

    def reset(self, seed: int) -> None:
        raise ConfigError("arm: expected a simulator for reset_episode, got a real robot")

    def snapshot(self) -> bytes:
        return b""

    def close(self) -> None: ...


async def body(context: ServiceContext) -> None:
    profile = context.deployment.profile
    await run_hal(context, lambda robot: Equipment(MinimalArm(robot, profile)), what="minimal")


sys.exit(run_service("minimal_hal", body))
