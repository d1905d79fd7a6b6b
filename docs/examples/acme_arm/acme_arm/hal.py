"""The HAL of Acme's arm: joints that do at once what they are told."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from pydantic import BaseModel, ConfigDict

from fairlead import ControlMode, RobotManifest
from fairlead.errors import ConfigError, expected
from fairlead.hal import BackendDescription, FramePose, Measurement, PartCommand, describe_part
from fairlead.hal.process import Equipment, HalDriver

HERE, UPRIGHT = np.zeros(3), np.array([0.0, 0.0, 0.0, 1.0])


class AcmeOptions(BaseModel):
    """start_rad: where both joints are when the HAL starts."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    start_rad: tuple[float, float] = (0.0, 0.0)


class AcmeArm:
    """The backend. A driver would talk to the arm's controller in `read` and `apply`."""

    def __init__(self, robot: RobotManifest, profile: str, options: AcmeOptions) -> None:
        self._robot, self._profile = robot, profile
        self._period_s = robot.tick_period_ns * 1e-9
        self._positions, self._velocities = np.array(options.start_rad), np.zeros(2)

    def describe(self) -> BackendDescription:
        robot = self._robot
        parts = tuple(describe_part(robot, part, self._profile) for part in robot.parts)
        return BackendDescription(robot.joint_names, (), parts, (), cameras=(), has_task=False)

    def read(self) -> Measurement:
        return Measurement(self._positions, self._velocities, efforts=np.zeros(2))

    def transforms(self) -> Sequence[FramePose]:
        return [FramePose("odom", "base_link", HERE, UPRIGHT)]

    def static_transforms(self) -> Sequence[FramePose]:
        return [FramePose("map", "odom", HERE, UPRIGHT)]

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        target = self._positions.copy()  # without a command it keeps its position
        for command in commands.values():
            if command.mode != ControlMode.JOINT_POSITION:
                raise ConfigError(expected("acme", "joint_position", command.mode.yaml_name))
            joints = list(command.active)
            target[joints] = command.values[joints]
        self._velocities = (target - self._positions) / self._period_s
        self._positions = target

    def task(self) -> None:
        return None

    def reset(self, seed: int) -> None:
        raise ConfigError("acme: expected a simulator for reset_episode, got a real robot")

    def snapshot(self) -> bytes:
        return b""

    def close(self) -> None: ...


def equip(robot: RobotManifest, profile: str, options: AcmeOptions) -> Equipment:
    return Equipment(AcmeArm(robot, profile, options))


DRIVER = HalDriver(AcmeOptions, equip)
