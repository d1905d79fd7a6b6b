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
START = np.array([0.0, -0.3, 0.0, -2.2, 0.0, 2.0, 0.785, 0.08])


class MinimalArm:
    """robots/panda. A driver would talk to the arm's controller in `read` and `apply`."""

    def __init__(self, robot: RobotManifest, profile: str) -> None:
        self.robot, self.profile, self.period_s = robot, profile, robot.tick_period_ns * 1e-9
        self.positions, self.velocities = START.copy(), np.zeros(8)

    def describe(self) -> BackendDescription:
        robot = self.robot
        parts = tuple(describe_part(robot, part, self.profile) for part in robot.parts)
        return BackendDescription(
            robot.joint_names, robot.passive_joint_names, parts, (), cameras=(), has_task=False
        )

    def read(self) -> Measurement:
        fingers = np.array([0.5, -0.5])  # the gripper is the difference of the two
        positions = np.concatenate([self.positions, fingers * self.positions[7]])
        velocities = np.concatenate([self.velocities, fingers * self.velocities[7]])
        return Measurement(positions, velocities, efforts=np.zeros(10))

    def transforms(self) -> Sequence[FramePose]:
        return [FramePose("odom", "base_link", HERE, UPRIGHT)]

    def static_transforms(self) -> Sequence[FramePose]:
        return [FramePose("map", "odom", HERE, UPRIGHT)]

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        target = self.positions.copy()  # a part without a command keeps its position
        for command in commands.values():
            joints = list(command.active)
            if command.mode == ControlMode.JOINT_POSITION:
                target[joints] = command.values[joints]
            elif command.mode == ControlMode.JOINT_VELOCITY:
                target[joints] += command.values[joints] * self.period_s
            elif command.mode == ControlMode.GRIPPER_POSITION:
                reach = 0.1 * self.period_s  # the hand closes at 0.1 m/s
                target[7] += np.clip(command.values[0] - target[7], -reach, reach)
            else:
                raise ConfigError(expected("arm", "a mode of robot.yaml", command.mode.yaml_name))
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
