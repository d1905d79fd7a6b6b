"""What one arm's servos read where its joints are: a file that belongs to its owner."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated, Literal, Self

import yaml
from pydantic import BaseModel, ConfigDict, Field, model_validator

from fairlead.errors import ConfigError, expected
from fairlead.paths import user_calibrations_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.yaml_file import load_yaml

STEPS_PER_RAD = 4096 / (2 * math.pi)
ZERO_STEPS = 2048
Steps = Annotated[int, Field(ge=0, le=4095)]


class CalibratedServo(BaseModel):
    """One servo on its joint; a servo reads 2048 where the joint is at 0 rad.

    homing_offset_steps: what the servo subtracts from its encoder. direction: 1, or -1 where it
    counts down as the joint goes up. lower_steps, upper_steps: its own position limits.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    joint: str
    id: Annotated[int, Field(ge=0, le=253)]
    homing_offset_steps: Annotated[int, Field(ge=-2047, le=2047)]
    direction: Literal[-1, 1]
    lower_steps: Steps
    upper_steps: Steps

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.lower_steps >= self.upper_steps:
            text = f"joint {self.joint!r}: expected lower_steps below upper_steps"
            raise ValueError(f"{text}, got {self.lower_steps} and {self.upper_steps}")
        return self

    def steps(self, position_rad: float) -> int:
        """What it reads at a position."""
        return ZERO_STEPS + round(self.direction * position_rad * STEPS_PER_RAD)

    def rad(self, steps: int) -> float:
        """The position where it reads so."""
        return self.direction * (steps - ZERO_STEPS) / STEPS_PER_RAD

    def share(self, steps: int) -> float:
        """Of its range, where it reads so: 0 at the joint's lower end, 1 at the upper."""
        share = (steps - self.lower_steps) / (self.upper_steps - self.lower_steps)
        return min(max(share if self.direction > 0 else 1.0 - share, 0.0), 1.0)


Arm = Literal["follower", "leader"]


class Calibration(BaseModel):
    """One arm.

    arm: that holds itself and is told where to go, or that a person moves.
    servos: in the order of the robot's joints.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    robot: str
    arm: Arm = "follower"
    servos: tuple[CalibratedServo, ...]

    @model_validator(mode="after")
    def _one_id_each(self) -> Self:
        ids = [servo.id for servo in self.servos]
        if len(set(ids)) != len(ids):
            raise ValueError(f"servos: expected a different id for each, got {ids}")
        return self

    @property
    def ids(self) -> tuple[int, ...]:
        """Of the servos, in the order of the joints."""
        return tuple(servo.id for servo in self.servos)


def calibration_path(name: str) -> Path:
    """The file that a name or a path means; it need not exist."""
    return Path(name) if "/" in name else user_calibrations_dir() / f"{name}.yaml"


def load_calibration(name: str, robot: RobotManifest, arm: Arm = "follower") -> Calibration:
    """The calibration of an arm.

    Raises:
        ConfigError: no such file, or it does not fit the robot or the arm.
    """
    path = calibration_path(name)
    leads = " --arm leader" if arm == "leader" else ""
    how = f"fairlead calibrate so101 --port PORT{leads}"
    if not path.is_file():
        raise ConfigError(f"so101: no calibration {path}; make one with: {how}")
    found = load_yaml(path, Calibration)
    joints = tuple(servo.joint for servo in found.servos)
    if (found.robot, joints) != (robot.id, robot.joint_names):
        wanted = f"servos of {robot.id}: {', '.join(robot.joint_names)}"
        raise ConfigError(expected(str(path), wanted, f"{found.robot}: {', '.join(joints)}"))
    if found.arm != arm:
        raise ConfigError(expected(str(path), f"a {arm}'s calibration ({how})", f"a {found.arm}'s"))
    return found


def save_calibration(path: Path, calibration: Calibration) -> None:
    """Write the file.

    Raises:
        OSError: it cannot be written.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(yaml.safe_dump(calibration.model_dump(), sort_keys=False), encoding="utf-8")
