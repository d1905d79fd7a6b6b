"""So101Backend: six STS3215 servos behind the HAL contract."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

import numpy as np

from fairlead.errors import ConfigError, HardwareError, expected
from fairlead.hal.backend import (
    BackendDescription,
    FramePose,
    Measurement,
    NotCarriedOutError,
    PartCommand,
    TaskReading,
    describe_part,
)
from fairlead.hal.setpoints import Setpoints
from fairlead.hal.tool_motion import ToolMotion, robot_kinematics
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.safety_profile import profile_limits
from fairlead_hal_so101.calibration import STEPS_PER_RAD, Calibration, calibration_path
from fairlead_hal_so101.options import So101Options
from fairlead_hal_so101.servo_bus import GOAL_POSITION, LostAnswerError, calibrated_bus
from fairlead_hal_so101.servo_reading import STALL_NM, ServoHealth, ServoReading

_LOG = logging.getLogger("hal.so101")

_UPRIGHT = np.array([0.0, 0.0, 0.0, 1.0])
_MOST_ACCELERATION = 254
_WHOLE = 1000
_LAST_STEP = 4095
_TORQUE_ROOM = 1.25
"""A servo may push so much more than the profile has: else nobody would see that it does."""
_ACCELERATION_STEPS_S2 = 100
_TORQUE_ENABLE = 40
_SLACK_STEPS = 12
"""How far outside its limits a joint may be found: a degree, by which the servo takes it in."""


class So101Backend:
    """Implements `fairlead.hal.backend.Backend` and, of its model, `FrameModel`.

    Each tick is one read of the bus, of all servos, and one write of all goals. A servo goes to
    its goal no faster than its joint may, also when this process is gone: it then stays there. A
    goal switches torque on, so none is written before the servos have been seen in the same tick
    with torque and the limits that they were given.

    Args:
        profile: safety profile whose limits the servos get.
        calibration: of this arm.

    Raises:
        ConfigError: what is on the port is not this arm.
        HardwareError: it does not answer.
    """

    def __init__(
        self, robot: RobotManifest, profile: str, options: So101Options, calibration: Calibration
    ) -> None:
        self._robot, self._options, self._servos = robot, options, calibration.servos
        timeout_ms = robot.profile(profile).protocol.state_timeout_ms
        if profile == "hardware" and options.lost_ticks * robot.tick_period_ns * 1e-6 > timeout_ms:
            period_ms = robot.tick_period_ns * 1e-6
            what = f"no more than state_timeout_ms, {timeout_ms} ms, at {period_ms:g} ms a tick"
            raise ConfigError(expected("hal_so101: lost_ticks", what, options.lost_ticks))
        self._parts = tuple(describe_part(robot, part, profile) for part in robot.parts)
        file = calibration_path(options.calibration)
        self._bus = calibrated_bus(
            options.port, calibration, file, options.answer_timeout_s, "hal_so101"
        )
        self._health = ServoHealth(
            [self._bus.named([one]) for one in calibration.ids], options.limits
        )
        self._lost = {"measurement": 0, "command": 0}
        self._ever_lost = 0
        self._may_write = False
        try:
            kinematics = robot_kinematics(robot, "hal_so101")
            self._frames = kinematics.frames()
            tools = ToolMotion(robot, profile, kinematics)
            self._setpoints = Setpoints(robot, tools, who="hal_so101", profile=profile)
            self._limits = self._limit_servos(profile)
            self._readings = self._first_readings()
            self._setpoints.restart(self._positions())
            self._take_hold()
            self._may_write = True
        except BaseException:
            self._bus.close()
            raise

    def describe(self) -> BackendDescription:
        """The servos that were found, as the robot's joints."""
        return BackendDescription(
            joints=self._robot.joint_names,
            passive_joints=self._robot.passive_joint_names,
            parts=self._parts,
            simulator_order=(),
            cameras=(),
            has_task=False,
        )

    def read(self) -> Measurement:
        """All servos; where one does not answer in time, what was measured the tick before.

        Raises:
            HardwareError: too many ticks were lost in a row, a servo is limp or has lost its
                limits, the port is gone.
        """
        self._may_write = False
        try:
            self._readings = self._bus.read()
        except LostAnswerError as error:
            self._note_loss("measurement", str(error))
        else:
            self._lost["measurement"] = 0
            self._check_hold()
            self._may_write = True
            was_well = not self._health.complaint
            self._health.look(self._readings)
            if was_well and self._health.complaint:  # nobody may send a row that is refused
                _LOG.warning("%s: the next row is refused", self._health.complaint)
        pairs = list(zip(self._servos, self._readings, strict=True))
        return Measurement(
            positions=self._positions(),
            velocities=np.array([s.direction * r.speed_steps_s / STEPS_PER_RAD for s, r in pairs]),
            efforts=np.array([s.direction * r.effort_nm for s, r in pairs]),
        )

    def transforms(self) -> Sequence[FramePose]:
        """``odom`` to the base frame: the arm stands still."""
        return [FramePose("odom", self._robot.base_frame, np.zeros(3), _UPRIGHT)]

    def static_transforms(self) -> Sequence[FramePose]:
        """``map -> odom``: the same frame."""
        return [FramePose("map", "odom", np.zeros(3), _UPRIGHT)]

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """Write every servo's goal: a joint's target, or its share of a tool's way.

        A measurement is good for one write; where it is missing, each stays at its last goal.

        Raises:
            ConfigError: a servo is beyond a limit of the options or says a fault, or a goal is
                outside the calibrated range: no goal has changed.
            NotCarriedOutError: the bus has lost the measurement or the goals of this tick.
            HardwareError: the port is gone, or the servos were not seen since the last write.
        """
        if commands and self._health.complaint:
            raise ConfigError(f"hal_so101: {self._health.complaint}")
        if not self._may_write:
            if 0 < self._lost["measurement"] <= self._options.lost_ticks:
                if commands:
                    raise NotCarriedOutError("hal_so101: nothing was measured, so nothing is told")
                return
            raise HardwareError("hal_so101: servos that were not seen are told nothing")
        goals = self._setpoints.advance(commands, self._positions())
        try:
            steps = self._steps(goals)
        except ConfigError:
            self._setpoints.undo()
            raise
        self._may_write = False
        try:
            self._bus.write_all(GOAL_POSITION, 2, steps)
        except LostAnswerError as error:
            self._setpoints.undo()
            self._note_loss("command", str(error))
            if commands:
                raise NotCarriedOutError(f"hal_so101: goals were not sent: {error}") from None
        else:
            self._lost["command"] = 0

    def task(self) -> TaskReading | None:
        """None: a real arm has no task."""
        return None

    def reset(self, seed: int) -> None:
        """Raises `ConfigError`: a real arm has no episodes."""
        raise ConfigError("hal_so101: expected a simulator for reset_episode, got a real arm")

    def snapshot(self) -> bytes:
        """Nothing to render from."""
        return b""

    def frame_poses(self, positions: FloatArray | None) -> Sequence[FramePose]:
        """Where the model that cartesian modes go by has the robot's frames."""
        return self._frames.frame_poses(self._positions() if positions is None else positions)

    def close(self) -> None:
        """Torque off where the options say so."""
        try:
            if self._options.torque_off_at_exit:
                self._bus.write_all(_TORQUE_ENABLE, 1, [0] * len(self._servos))
        except (HardwareError, LostAnswerError) as error:
            _LOG.error("torque is still on: %s", error)
        if self._ever_lost:
            _LOG.warning("%d measurements or commands were lost", self._ever_lost)
        self._bus.close()

    def _first_readings(self) -> list[ServoReading]:
        for _ in range(self._options.lost_ticks + 1):
            try:
                return self._bus.read()
            except LostAnswerError as error:
                reason = str(error)
        raise HardwareError(f"hal_so101: {self._options.port}: {reason}")

    def _limit_servos(self, profile: str) -> list[tuple[int, int]]:
        """Give each servo its joint's limits: acceleration, then speed, as registers have them."""
        safety, found = self._robot.profile(profile), list[tuple[int, int]]()
        for one, joint in zip(self._servos, self._robot.joints, strict=True):
            speed, acceleration, effort, _ = profile_limits(joint, safety)
            contact = safety.measured[joint.name].contact_limit or 0.0
            limits = {
                "acceleration": int(acceleration * STEPS_PER_RAD / _ACCELERATION_STEPS_S2),
                "goal_velocity": int(speed * STEPS_PER_RAD),
                "torque_limit": int(_WHOLE * _TORQUE_ROOM * max(effort, contact) / STALL_NM),
            }
            limits["acceleration"] = min(limits["acceleration"], _MOST_ACCELERATION)
            limits["torque_limit"] = min(limits["torque_limit"], _WHOLE)
            for name, value in limits.items():
                if value < 1:  # 0 is no limit to a servo
                    who = f"hal_so101: joint {joint.name}"
                    raise ConfigError(expected(who, f"a limit that is 1 or more of {name}", value))
                self._bus.put(one.id, name, value)
            found.append((limits["acceleration"], limits["goal_velocity"]))
        return found

    def _take_hold(self) -> None:
        """Goals where the joints are, then torque, each acknowledged: nothing moves."""
        for one, reading in zip(self._servos, self._readings, strict=True):
            lowest = max(one.lower_steps - _SLACK_STEPS, 0)
            highest = min(one.upper_steps + _SLACK_STEPS, _LAST_STEP)
            if not lowest <= reading.position_steps <= highest:
                what = f"a position within {one.lower_steps} to {one.upper_steps} steps"
                who = f"hal_so101: servo {self._bus.named([one.id])}"
                got = f"{reading.position_steps}; move it there by hand, or calibrate again"
                raise ConfigError(expected(who, what, got))
        goals = [one.position_steps for one in self._readings]
        for one, goal in zip(self._servos, goals, strict=True):
            self._bus.put(one.id, "goal_position", goal)
            self._bus.put(one.id, "torque_enable", 1)
        self._readings = self._first_readings()
        self._check_hold()
        if [one.goal_steps for one in self._readings] != goals:
            raise HardwareError("hal_so101: a servo did not take its goal; start again")

    def _check_hold(self) -> None:
        """Each servo has torque, and the limits that it was given: it has not started anew."""
        states = zip(self._servos, self._readings, self._limits, strict=True)
        anew = [
            one.id
            for one, reading, limits in states
            if not (reading.has_torque and (reading.acceleration, reading.goal_velocity) == limits)
        ]
        if anew:
            text = "brown-out or reset? support the arm, look at the supply, start again"
            raise HardwareError(f"hal_so101: servo {self._bus.named(anew)}: no torque: {text}")

    def _note_loss(self, what: str, reason: str) -> None:
        """Count it; too many in a row are a fault, with what can be found out about it."""
        self._lost[what] += 1
        self._ever_lost += 1
        if self._lost[what] == 1:
            _LOG.warning("a %s is lost: %s", what, reason)
        if self._lost[what] <= self._options.lost_ticks:
            return
        reason = self._bus.why_lost(reason)
        raise HardwareError(f"hal_so101: {self._lost[what]} {what}s lost in a row: {reason}")

    def _positions(self) -> FloatArray:
        return np.array(
            [
                one.rad(reading.position_steps)
                for one, reading in zip(self._servos, self._readings, strict=True)
            ]
        )

    def _steps(self, positions: FloatArray) -> list[int]:
        steps = [one.steps(p) for one, p in zip(self._servos, positions.tolist(), strict=True)]
        for one, goal in zip(self._servos, steps, strict=True):
            if not one.lower_steps - _SLACK_STEPS <= goal <= one.upper_steps + _SLACK_STEPS:
                low, high = sorted((one.rad(one.lower_steps), one.rad(one.upper_steps)))
                who, what = f"hal_so101: joint {one.joint}", f"{low:.3f} to {high:.3f} rad"
                raise ConfigError(expected(who, f"a goal of {what}, as calibrated", one.rad(goal)))
        return [min(max(goal, 0), _LAST_STEP) for goal in steps]
