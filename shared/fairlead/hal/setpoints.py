"""Setpoints: where every joint is told to be, period by period. No simulator in here."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Protocol

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead.robot.safety_profile import profile_limits

TRAVEL_SHARE = 0.9
"""Of its speed limit: a gripper's servo overshoots by up to 7 % where it turns back."""
TOOL_SHARE = 0.95
"""Of its speed limit, at which a tool's motion moves a joint: its servo is up to 2 % faster."""
LEAD_PERIODS = 2.0
"""Periods of full speed by which a moving setpoint may lead its joint."""


class SetpointLimits:
    """Position limits, speeds and the lead of a robot's commanded joints.

    Attributes:
        lower, upper: position limits [rad or m], infinite for a joint without.
        reach: farthest way in one period [rad or m].
        slowing: how joints slow down [rad/s^2 or m/s^2], as the gate predicts it.
    """

    def __init__(self, robot: RobotManifest, profile: str = "") -> None:
        bounded = [joint if joint.has_bounds else None for joint in robot.joints]
        self.lower = np.array([joint.lower if joint else -np.inf for joint in bounded])
        self.upper = np.array([joint.upper if joint else np.inf for joint in bounded])
        speed = np.array([joint.velocity_limit for joint in robot.joints])
        self.slowing = np.array([joint.acceleration_limit for joint in robot.joints])
        if profile:
            safety = robot.profile(profile)
            limits = [profile_limits(joint, safety)[:2] for joint in robot.joints]
            speed, self.slowing = np.array(limits).T
        self.reach = speed * robot.tick_period_ns * 1e-9

    def ends(
        self, joints: Sequence[int], setpoints: FloatArray, measured: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Where the setpoints of ``joints`` may go, both ways: as far as they are, at least.

        Args:
            setpoints, measured: of these joints, now.
        """
        own = list(joints)
        lead = LEAD_PERIODS * self.reach[own]
        # A setpoint that leads by more already (it was a position command) may only come back.
        lowest, highest = np.minimum(measured - lead, setpoints), measured + lead
        highest = np.maximum(highest, setpoints)
        # One outside the position limits may only come back, and step by
        # step: limits that left it out would pull it in at once.
        lower = np.minimum(self.lower[own], setpoints)
        upper = np.maximum(self.upper[own], setpoints)
        return np.clip(lowest, lower, upper), np.clip(highest, lower, upper)

    def lead_less(
        self, joints: Sequence[int], setpoints: FloatArray, measured: FloatArray
    ) -> FloatArray:
        """These setpoints, leading by no more than one that moves may."""
        lead = LEAD_PERIODS * self.reach[list(joints)]
        return np.clip(setpoints, measured - lead, measured + lead)

    def step_scale(
        self, joints: Sequence[int], steps: FloatArray, setpoints: FloatArray, measured: FloatArray
    ) -> float:
        """How much of these steps every joint can do in one period: 1.0, or less for all."""
        lowest, highest = self.ends(joints, setpoints, measured)
        reach, moving = TOOL_SHARE * self.reach[list(joints)], steps != 0.0
        most = np.minimum(highest - setpoints, reach)
        least = np.maximum(lowest - setpoints, -reach)
        possible = np.where(steps > 0.0, most, least)[moving] / steps[moving]
        return float(np.clip(np.min(possible, initial=1.0), 0.0, 1.0))


class ToolSteps(Protocol):
    """How far the joints of a part have to go for a cartesian command."""

    def steps(self, part: str, command: PartCommand, positions: FloatArray) -> FloatArray:
        """Change per joint of the part in one period [rad or m], from all joints' setpoints."""


class Setpoints:
    """Position setpoints of the commanded joints, in wire order [rad or m].

    joint_position, dex_hand_joint: the setpoint is the command. joint_velocity: it moves at
    the commanded rate. cartesian modes: it moves so that the tool would be where the command
    wants it, at the setpoint's own pose plus the command; all joints of the part slow down
    together where one of them could not follow, so the tool never leaves its way. Setpoints
    that move do so no faster than the joints may, end at their position limits (one outside
    may only come back, at the rate it is told), and lead a joint by no more than it travels
    in two periods at full speed: one that is blocked does not leap when it comes free.
    gripper_position, gripper_binary (0 the upper position limit, 1 the lower): it travels to
    the command at `TRAVEL_SHARE` of the gripper's speed limit.

    Where a part's rows end, a setpoint that leads its joint by more, as rows of positions can
    while something blocks it, comes back to that once: what blocks it is not pushed on and on.

    A part without a command, and a joint that a joint mode leaves out, follow the part's hold
    law: ``ramp_to_zero`` slows joints down by their acceleration limits, the others leave the
    setpoint where it is; with ``keep_command`` a gripper travels on to its target, which any
    other law and any other mode forgets. It is never anchored to the measured pose again, so
    nothing drifts.

    Args:
        robot: every mode of its parts must be in `MODES`.
        tools: needed by parts with cartesian modes.
        parts: those that position servos move; None: all.
        who: the HAL, as errors call it.
        profile: a safety profile whose tighter speeds and accelerations bind setpoints that move;
            "": none.

    Raises:
        ConfigError: for a mode, a hold law or a base that position servos cannot follow.
    """

    def __init__(
        self,
        robot: RobotManifest,
        tools: ToolSteps | None = None,
        parts: Sequence[Part] | None = None,
        who: str = "hal",
        profile: str = "",
    ) -> None:
        self._tools, self._parts = tools, robot.parts if parts is None else tuple(parts)
        self._period_s = robot.tick_period_ns * 1e-9
        self._limits = SetpointLimits(robot, profile)
        self._own = {
            part.name: [robot.joint_names.index(name) for name in part.joints]
            for part in self._parts
        }
        for part in self._parts:
            _check_part(part, who)
            if profile and set(part.joints) & set(robot.base_joints):
                check_command_frame(robot, profile, who)
        self.restart(np.zeros(robot.n_dof))

    def restart(self, positions: FloatArray) -> None:
        """Stand still at ``positions``, shape ``[n_dof]``."""
        self.positions = positions.copy()
        self._velocities = np.zeros(len(positions))
        self._measured = positions.copy()
        self._openings: dict[str, float] = {}
        self._going: set[str] = set()  # parts that had a row, of no gripper, in the last period

    def stand_at(self, part: str, measured: FloatArray) -> None:
        """Let a part's setpoints begin at ``measured``: somebody else may have moved it.

        Args:
            measured: of all joints, shape ``[n_dof]``.
        """
        own = self._own[part]
        self.positions[own], self._velocities[own] = measured[own], 0.0
        self._openings.pop(part, None)

    def advance(self, commands: Mapping[str, PartCommand], measured: FloatArray) -> FloatArray:
        """Where the joints are told to be at the end of the next period, shape ``[n_dof]``.

        Args:
            commands: by part name; a part that is absent holds.
            measured: positions of the commanded joints now, shape ``[n_dof]``.
        """
        self._measured = measured
        self._before = (
            self.positions.copy(), self._velocities.copy(), dict(self._openings), set(self._going),
        )  # fmt: skip
        # A pose is reached for last, from where the other parts are told to be by then.
        poses = [
            name for name, given in commands.items() if given.mode is ControlMode.CARTESIAN_POSE
        ]
        for part in sorted(self._parts, key=lambda part: part.name in poses):
            given = commands.get(part.name)
            if given is None:
                self._hold(part)
                self._going.discard(part.name)
            else:
                if not given.mode.is_gripper_mode:
                    self._openings.pop(part.name, None)
                    self._going.add(part.name)
                MODES[given.mode](self, part, given)
        return self.positions.copy()

    def undo(self) -> None:
        """As before the last `advance`: what came of it was not told."""
        positions, velocities, openings, going = self._before
        self.positions, self._velocities = positions.copy(), velocities.copy()
        self._openings, self._going = dict(openings), set(going)

    def _hold(self, part: Part) -> None:
        own = self._own[part.name]
        if part.name in self._going:
            told, measured = self.positions[own], self._measured[own]
            self.positions[own] = self._limits.lead_less(own, told, measured)
        self._slow_down(part, own)
        if part.hold == "keep_command":
            self._close_in(part)
        else:
            self._openings.pop(part.name, None)

    def _slow_down(self, part: Part, joints: list[int]) -> None:
        """Joints that nothing is told: they come to rest as the part's hold law says."""
        rates = np.zeros(len(joints))
        if part.hold == "ramp_to_zero":
            less = self._limits.slowing[joints] * self._period_s
            now = self._velocities[joints]
            rates = np.sign(now) * np.maximum(np.abs(now) - less, 0.0)
        self._drive(joints, rates)

    def _joint_position(self, part: Part, command: PartCommand) -> None:
        active = self._active(part, command)
        self._velocities[active] = 0.0
        self.positions[active] = command.values[active]

    def _joint_velocity(self, part: Part, command: PartCommand) -> None:
        active = self._active(part, command)
        self._drive(active, command.values[active])

    def _active(self, part: Part, command: PartCommand) -> list[int]:
        """The joints a row is for; the part's others hold."""
        left_out = [joint for joint in self._own[part.name] if joint not in command.active]
        self._slow_down(part, left_out)
        return list(command.active)

    def _cartesian(self, part: Part, command: PartCommand) -> None:
        assert self._tools is not None, "checked in __init__ of the backend"
        own = self._own[part.name]
        steps = self._tools.steps(part.name, command, self.positions)
        scale = self._limits.step_scale(own, steps, self.positions[own], self._measured[own])
        self._drive(own, steps * scale / self._period_s)

    def _gripper_position(self, part: Part, command: PartCommand) -> None:
        self._openings[part.name] = float(command.values[0])
        self._close_in(part)

    def _gripper_binary(self, part: Part, command: PartCommand) -> None:
        ends = self._limits.lower if command.values[0] == 1.0 else self._limits.upper
        self._openings[part.name] = float(ends[self._own[part.name][0]])
        self._close_in(part)

    def _composite_mode(self, part: Part, command: PartCommand) -> None:
        """No composite controller here: accepted, and nothing moves."""
        self._velocities[self._own[part.name]] = 0.0

    def _drive(self, joints: list[int], rates: FloatArray) -> None:
        fastest = self._limits.reach[joints] / self._period_s
        rates = np.clip(rates, -fastest, fastest)
        self._velocities[joints] = rates
        lowest, highest = self._limits.ends(joints, self.positions[joints], self._measured[joints])
        moved = self.positions[joints] + rates * self._period_s
        self.positions[joints] = np.clip(moved, lowest, highest)

    def _close_in(self, part: Part) -> None:
        """Move a gripper on towards its newest target, if it has one."""
        self._velocities[self._own[part.name]] = 0.0
        target = self._openings.get(part.name)
        if target is not None:
            joint = self._own[part.name][0]
            reach = TRAVEL_SHARE * self._limits.reach[joint]
            self.positions[joint] += np.clip(target - self.positions[joint], -reach, reach)


MODES: dict[ControlMode, Callable[[Setpoints, Part, PartCommand], None]] = {
    ControlMode.JOINT_POSITION: Setpoints._joint_position,
    ControlMode.JOINT_VELOCITY: Setpoints._joint_velocity,
    ControlMode.CARTESIAN_POSE: Setpoints._cartesian,
    ControlMode.CARTESIAN_DELTA: Setpoints._cartesian,
    ControlMode.CARTESIAN_TWIST: Setpoints._cartesian,
    ControlMode.GRIPPER_BINARY: Setpoints._gripper_binary,
    ControlMode.GRIPPER_POSITION: Setpoints._gripper_position,
    ControlMode.DEX_HAND_JOINT: Setpoints._joint_position,
    ControlMode.COMPOSITE_MODE: Setpoints._composite_mode,
}
"""The modes this HAL can follow."""


def check_command_frame(robot: RobotManifest, profile: str, who: str, frame: str = "odom") -> None:
    """Raises `ConfigError` for a profile whose base is told otherwise than this HAL tells it."""
    base = robot.profile(profile).base
    if base is not None and base.command_frame != frame:
        what = f"{who}: {robot.id}: safety.{profile}.base.command_frame"
        raise ConfigError(expected(what, frame, base.command_frame))


def _check_part(part: Part, hal: str) -> None:
    who, valid = f"{hal}: part {part.name}", [mode.yaml_name for mode in MODES]
    for mode in part.control_modes:
        if mode not in MODES:
            raise ConfigError(expected(who, "a mode of this HAL", mode.yaml_name, valid))
    if part.joints and part.hold == "write_default":
        laws = ("keep_position", "zero_delta", "ramp_to_zero", "keep_command")
        raise ConfigError(expected(who, "a hold law for joints", part.hold, laws))
