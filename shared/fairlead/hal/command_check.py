"""Does one row fit the part it is for? Asked of every command before a backend gets any."""

from __future__ import annotations

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest

QUATERNION_TOLERANCE = 1e-6
"""How far a pose's quaternion may be from length 1; the gate's bound as well."""


class CommandCheck:
    """Part, mode, width, joints, frame and the values with a form of their own.

    Args:
        robot: its manifest.
        profile: safety profile that declares the frames of cartesian modes.
    """

    def __init__(self, robot: RobotManifest, profile: str) -> None:
        self._robot = robot
        limits = robot.profile(profile).parts
        self._frames: dict[tuple[str, ControlMode], tuple[str, ...]] = {  # a profile has all modes
            (part.name, mode): getattr(limits[part.name], mode.yaml_name).frames
            for part in robot.parts
            for mode in part.control_modes
            if mode.is_tool_mode
        }
        number = {name: index for index, name in enumerate(robot.joint_names)}
        self._joints = {part.name: [number[joint] for joint in part.joints] for part in robot.parts}

    def check(self, name: str, command: PartCommand) -> None:
        """Raises `ConfigError` with what was expected and what came.

        Args:
            name: of the part.
        """
        part, mode = self._robot.part(name), command.mode
        who = f"hal: part {name}"
        if mode not in part.control_modes:
            raise ConfigError(expected(who, "a mode", mode.yaml_name, part.modes))
        width = mode.width(self._robot.n_dof)
        if command.values.shape != (width,):
            what = f"{width} value(s) of {mode.yaml_name}"
            raise ConfigError(expected(who, what, f"shape {list(command.values.shape)}"))
        if not np.isfinite(command.values).all():
            raise ConfigError(expected(who, "finite values", command.values.tolist()))
        own = self._joints[name]
        if not set(command.active).issubset(own):
            what = f"active joints out of {own}"
            raise ConfigError(expected(who, what, list(command.active)))
        if mode.is_tool_mode:
            frames = self._frames[name, mode]
            if command.frame_id not in frames:
                what = f"a frame of {mode.yaml_name}"
                raise ConfigError(expected(who, what, repr(command.frame_id), frames))
        _check_values(who, command)


def _check_values(who: str, command: PartCommand) -> None:
    if command.mode is ControlMode.CARTESIAN_POSE:
        length = float(np.linalg.norm(command.values[3:]))
        if abs(length - 1.0) > QUATERNION_TOLERANCE:
            raise ConfigError(expected(who, "a quaternion of length 1", f"length {length:g}"))
    if command.mode is ControlMode.GRIPPER_BINARY and command.values[0] not in (0.0, 1.0):
        raise ConfigError(expected(who, "0 (open) or 1 (closed)", command.values[0]))
