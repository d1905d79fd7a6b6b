"""Setpoints: where every joint is told to be, period by period. No simulator in here."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot import RobotManifest
from fairlead.robot_part import Part

LEAD_PERIODS = 2.0
"""Periods of full speed by which a moving setpoint may lead its joint."""


class Setpoints:
    """Position setpoints of the commanded joints, in wire order [rad or m].

    joint_position: the setpoint is the command. joint_velocity: it moves at the commanded
    rate, ends at the joint's position limits, and leads the joint by no more than it travels
    in `LEAD_PERIODS` at full speed: a joint that is blocked does not leap when it comes free.
    gripper_position: it travels to the
    command at the gripper's own speed limit. A part without a command follows its hold
    law: ``ramp_to_zero`` slows its joints down by their acceleration limits, the others
    leave the setpoint (a gripper: its target) where it is.

    Args:
        robot: every mode of its parts must be in `MODES`.

    Raises:
        ConfigError: for a mode, or a hold law, that position servos cannot follow.
    """

    def __init__(self, robot: RobotManifest) -> None:
        self._robot = robot
        self._period_s = robot.tick_period_ns * 1e-9
        bounded = [joint if joint.has_bounds else None for joint in robot.joints]
        self._lower = np.array([joint.lower if joint else -np.inf for joint in bounded])
        self._upper = np.array([joint.upper if joint else np.inf for joint in bounded])
        self._speed = np.array([joint.velocity_limit for joint in robot.joints])
        self._slowing = np.array([joint.acceleration_limit for joint in robot.joints])
        self._own = {
            part.name: [robot.joint_names.index(name) for name in part.joints]
            for part in robot.parts
        }
        for part in robot.parts:
            _check_part(part)
        self.restart(np.zeros(robot.n_dof))

    def restart(self, positions: FloatArray) -> None:
        """Stand still at ``positions``, shape ``[n_dof]``."""
        self.positions = positions.copy()
        self._velocities = np.zeros(len(positions))
        self._measured = positions.copy()
        self._openings: dict[str, float] = {}

    def advance(self, commands: Mapping[str, PartCommand], measured: FloatArray) -> FloatArray:
        """The setpoints at the end of the next period; a refused command changes nothing.

        Args:
            commands: by part name; a part that is absent holds.
            measured: positions of the commanded joints now, shape ``[n_dof]``.

        Raises:
            ConfigError: for a part, mode, width or joint that does not fit.
        """
        for name, command in commands.items():
            self._check(name, command)
        self._measured = measured
        for part in self._robot.parts:
            given = commands.get(part.name)
            if given is None:
                self._hold(part)
            else:
                MODES[given.mode](self, part, given)
        return self.positions.copy()

    def _check(self, name: str, command: PartCommand) -> None:
        part = self._robot.part(name)
        who = f"hal_mujoco: part {name}"
        if command.mode not in part.control_modes:
            raise ConfigError(expected(who, "a mode", command.mode.yaml_name, part.modes))
        width = command.mode.width(self._robot.n_dof)
        if command.values.shape != (width,):
            what = f"{width} value(s) of {command.mode.yaml_name}"
            raise ConfigError(expected(who, what, f"shape {list(command.values.shape)}"))
        own = self._own[name]
        if not set(command.active) <= set(own):
            what = f"active joints out of {own}"
            raise ConfigError(expected(who, what, list(command.active)))

    def _hold(self, part: Part) -> None:
        own = self._own[part.name]
        if part.hold == "ramp_to_zero":
            less = self._slowing[own] * self._period_s
            rates = self._velocities[own]
            self._drive(own, np.sign(rates) * np.maximum(np.abs(rates) - less, 0.0))
            return
        self._velocities[own] = 0.0
        self._close_in(part)

    def _joint_position(self, part: Part, command: PartCommand) -> None:
        active = list(command.active)
        self._velocities[self._own[part.name]] = 0.0
        self.positions[active] = command.values[active]

    def _joint_velocity(self, part: Part, command: PartCommand) -> None:
        active = list(command.active)
        self._velocities[self._own[part.name]] = 0.0
        self._drive(active, command.values[active])

    def _gripper_position(self, part: Part, command: PartCommand) -> None:
        self._openings[part.name] = float(command.values[0])
        self._close_in(part)

    def _composite_mode(self, part: Part, command: PartCommand) -> None:
        """No composite controller here: accepted, and does nothing."""

    def _drive(self, joints: list[int], rates: FloatArray) -> None:
        self._velocities[joints] = rates
        now, measured = self.positions[joints], self._measured[joints]
        lead = LEAD_PERIODS * self._speed[joints] * self._period_s
        # A setpoint that leads by more already (it was a position command) may only come back.
        lowest, highest = np.minimum(measured - lead, now), np.maximum(measured + lead, now)
        moved = np.clip(now + rates * self._period_s, lowest, highest)
        self.positions[joints] = np.clip(moved, self._lower[joints], self._upper[joints])

    def _close_in(self, part: Part) -> None:
        """Move a gripper on towards its newest target, if it has one."""
        target = self._openings.get(part.name)
        if target is not None:
            joint = self._own[part.name][0]
            reach = self._speed[joint] * self._period_s
            self.positions[joint] += np.clip(target - self.positions[joint], -reach, reach)


MODES: dict[ControlMode, Callable[[Setpoints, Part, PartCommand], None]] = {
    ControlMode.JOINT_POSITION: Setpoints._joint_position,
    ControlMode.JOINT_VELOCITY: Setpoints._joint_velocity,
    ControlMode.GRIPPER_POSITION: Setpoints._gripper_position,
    ControlMode.COMPOSITE_MODE: Setpoints._composite_mode,
}
"""The modes this HAL can follow."""


def _check_part(part: Part) -> None:
    who, valid = f"hal_mujoco: part {part.name}", [mode.yaml_name for mode in MODES]
    for mode in part.control_modes:
        if mode not in MODES:
            raise ConfigError(expected(who, "a mode of this HAL", mode.yaml_name, valid))
        if mode is ControlMode.GRIPPER_POSITION and len(part.joints) != 1:
            got = f"{len(part.joints)} joints"
            raise ConfigError(expected(who, "one joint for gripper_position", got))
    if part.joints and part.hold == "write_default":
        laws = ("keep_position", "zero_delta", "ramp_to_zero", "keep_command")
        raise ConfigError(expected(who, "a hold law for joints", part.hold, laws))
