"""KinematicBackend: a robot that does what it is told, instantly and without physics.

Velocities are integrated over the period, positions are reached at a bounded speed, and
end-effector deltas and twists move the part's joints by a fixed linear map (not inverse
kinematics). End-effector poses it refuses.
Deterministic, microseconds per tick: for trying a deployment without a simulator, for
long runs, and for tests of everything around it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.hal import (
    BackendDescription,
    FramePose,
    Measurement,
    PartCommand,
    TaskReading,
    describe_part,
)
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.safety_profile import profile_limits


def finger_shares(robot: RobotManifest) -> FloatArray:
    """How passive joints follow commanded ones: ``passive = shares @ commanded``.

    A gripper that is the difference of two fingers opens each by half; others stand still.
    """
    shares = np.zeros((len(robot.passive_joints), robot.n_dof))
    for column, joint in enumerate(robot.joint_names):
        fingers = robot.simulator_joints(joint)
        if len(fingers) != 2:
            continue
        for row, passive in enumerate(robot.passive_joint_names):
            if robot.simulator_joints(passive) == (fingers[0],):
                shares[row, column] = 0.5
            elif robot.simulator_joints(passive) == (fingers[1],):
                shares[row, column] = -0.5
    return shares


DELTA_GAIN = 0.1
"""Joint motion [rad] per m or rad of an end-effector delta, or of a twist in a second."""
SPREAD = 0.01
"""Share of its range by which a seed moves a joint at most: links stay apart."""
NO_ROTATION = np.array([0.0, 0.0, 0.0, 1.0])


class KinematicBackend:
    """Implements `fairlead.hal.backend.Backend` and `fairlead.hal.backend.TraceSource`.

    The base frame stands in ``odom`` at (base_x, base_y, base_yaw) where the robot has base
    joints, else at its origin.

    Args:
        robot: its manifest; joints start at its ``home``, or, where it declares none, in the
            middle of their range, and stay in that.
        profile: safety profile whose limits are told as command ranges.
        frames: further frames that stand still in ``odom``: name to xyz [m].

    Raises:
        ConfigError: for a part with a mode that needs physics or geometry.
    """

    def __init__(
        self,
        robot: RobotManifest,
        profile: str = "sim",
        frames: Mapping[str, Sequence[float]] | None = None,
    ) -> None:
        _check_modes(robot)
        self._robot = robot
        self._period_s = robot.tick_period_ns * 1e-9
        self._joints = {name: index for index, name in enumerate(robot.joint_names)}
        bounded = [joint if joint.has_bounds else None for joint in robot.joints]
        self._lower = np.array([joint.lower if joint else -np.inf for joint in bounded])
        self._upper = np.array([joint.upper if joint else np.inf for joint in bounded])
        safety = robot.profile(profile)
        self._speed = np.array([profile_limits(joint, safety)[0] for joint in robot.joints])
        self._slides = [self._joints[name] for name in robot.base_joints[:2]]
        self._is_turned = safety.base is not None and safety.base.command_frame == "against_yaw"
        self._shares = finger_shares(robot)
        self._start = _start(robot, robot.joints)
        # A finger is where its gripper is.
        follows = self._shares.any(axis=1)
        self._still = np.where(follows, 0.0, _start(robot, robot.passive_joints))
        self._parts = tuple(describe_part(robot, part, profile) for part in robot.parts)
        self._frames = {name: np.array(xyz, dtype=float) for name, xyz in (frames or {}).items()}
        self._packed: npt.NDArray[np.float32] = np.zeros(0, dtype=np.float32)
        self._positions = np.zeros(robot.n_dof)
        self._velocities = np.zeros(robot.n_dof)
        self.reset(0)

    def describe(self) -> BackendDescription:
        """What the manifest declares: there is nothing else to look at."""
        return BackendDescription(
            joints=self._robot.joint_names,
            passive_joints=self._robot.passive_joint_names,
            parts=self._parts,
            simulator_order=(),
            cameras=(),
            has_task=False,
        )

    def read(self) -> Measurement:
        """Where the joints were told to be; nothing weighs anything, so efforts are 0."""
        passive = self._still + self._shares @ self._positions
        positions = np.concatenate([self._positions, passive])
        velocities = np.concatenate([self._velocities, self._shares @ self._velocities])
        return Measurement(positions, velocities, np.zeros_like(positions))

    def transforms(self) -> Sequence[FramePose]:
        """``odom`` to the base frame by the base joints, and the frames given, which stand."""
        x, y, yaw = self._base_pose()
        rotation = np.array([0.0, 0.0, np.sin(yaw / 2), np.cos(yaw / 2)])
        base = FramePose("odom", self._robot.base_frame, np.array([x, y, 0.0]), rotation)
        still = [FramePose("odom", name, xyz, NO_ROTATION) for name, xyz in self._frames.items()]
        return [base, *still]

    def static_transforms(self) -> Sequence[FramePose]:
        """``map -> odom``: the same frame."""
        return [FramePose("map", "odom", np.zeros(3), NO_ROTATION)]

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """Every joint does at once what its command says, within its bounds."""
        target = self._positions.copy()
        for name, command in commands.items():
            self._move(target, name, command)
        target = np.clip(target, self._lower, self._upper)
        self._velocities = (target - self._positions) / self._period_s
        self._positions = target
        values = [commands[name].values for name in self._robot.part_names if name in commands]
        self._packed = np.concatenate([np.zeros(0), *values]).astype(np.float32)

    def task(self) -> TaskReading | None:
        """None: there is nothing to succeed at."""
        return None

    def reset(self, seed: int) -> None:
        """Back to the start; ``seed`` moves each bounded joint by up to 1 % of its range."""
        span = np.where(np.isfinite(self._lower), self._upper - self._lower, 0.0)
        off = span * np.random.default_rng(seed).uniform(-SPREAD, SPREAD, len(span))
        self._positions = np.clip(self._start + off, self._lower, self._upper)
        self._velocities = np.zeros(len(span))
        self._packed = np.zeros(0, dtype=np.float32)

    def snapshot(self) -> bytes:
        """Nothing to render from."""
        return b""

    def close(self) -> None:
        """Nothing to release."""

    def packed(self) -> npt.NDArray[np.float32]:
        """The values of the newest `apply` in robot order, as float32."""
        return self._packed.copy()

    def generalized_state(self) -> tuple[FloatArray, FloatArray]:
        """Positions and velocities of the commanded joints."""
        return self._positions.copy(), self._velocities.copy()

    def _base_pose(self) -> tuple[float, float, float]:
        indices = [self._joints[name] for name in self._robot.base_joints]
        if len(indices) != 3:
            return 0.0, 0.0, 0.0
        x, y, yaw = (float(self._positions[index]) for index in indices)
        return x, y, yaw

    def _move(self, target: FloatArray, name: str, command: PartCommand) -> None:
        own = [self._joints[joint] for joint in self._robot.part(name).joints]
        _MOVES[command.mode](self, target, own, command)

    def _joint_position(self, target: FloatArray, own: list[int], command: PartCommand) -> None:
        self._reach(target, list(command.active), command.values[list(command.active)])

    def _joint_velocity(self, target: FloatArray, own: list[int], command: PartCommand) -> None:
        told = command.values.copy()
        if self._is_turned and set(self._slides) <= set(command.active):
            x, y, yaw = *command.values[self._slides], self._base_pose()[2]
            told[self._slides] = (
                x * np.cos(yaw) + y * np.sin(yaw),
                y * np.cos(yaw) - x * np.sin(yaw),
            )
        for joint in command.active:
            target[joint] += told[joint] * self._period_s

    def _cartesian_delta(self, target: FloatArray, own: list[int], command: PartCommand) -> None:
        self._spread(target, own, DELTA_GAIN * command.values)

    def _cartesian_twist(self, target: FloatArray, own: list[int], command: PartCommand) -> None:
        self._spread(target, own, DELTA_GAIN * command.values * self._period_s)

    def _spread(self, target: FloatArray, own: list[int], motion: FloatArray) -> None:
        """Axes of a tool onto joints, none faster than it may: the gate bounds only the tool."""
        step = self._speed[own] * self._period_s
        target[own] += np.clip(np.resize(motion, len(own)), -step, step)

    def _gripper_binary(self, target: FloatArray, own: list[int], command: PartCommand) -> None:
        self._reach(target, own, (self._lower if command.values[0] == 1.0 else self._upper)[own])

    def _gripper_position(self, target: FloatArray, own: list[int], command: PartCommand) -> None:
        self._reach(target, own, np.full(len(own), command.values[0]))

    def _body_twist(self, target: FloatArray, own: list[int], command: PartCommand) -> None:
        _, _, yaw = self._base_pose()
        vx, vy, turn = command.values[0], command.values[1], command.values[5]
        world = (vx * np.cos(yaw) - vy * np.sin(yaw), vx * np.sin(yaw) + vy * np.cos(yaw), turn)
        for joint, velocity in zip(own, world, strict=True):
            target[joint] += velocity * self._period_s

    def _composite_mode(self, target: FloatArray, own: list[int], command: PartCommand) -> None:
        """No composite controller here: accepted, and does nothing."""

    def _reach(self, target: FloatArray, joints: list[int], goal: FloatArray) -> None:
        step = self._speed[joints] * self._period_s
        target[joints] += np.clip(goal - target[joints], -step, step)


_Move = Callable[[KinematicBackend, FloatArray, list[int], PartCommand], None]

_MOVES: dict[ControlMode, _Move] = {
    ControlMode.JOINT_POSITION: KinematicBackend._joint_position,
    ControlMode.JOINT_VELOCITY: KinematicBackend._joint_velocity,
    ControlMode.CARTESIAN_DELTA: KinematicBackend._cartesian_delta,
    ControlMode.CARTESIAN_TWIST: KinematicBackend._cartesian_twist,
    ControlMode.GRIPPER_BINARY: KinematicBackend._gripper_binary,
    ControlMode.GRIPPER_POSITION: KinematicBackend._gripper_position,
    ControlMode.DEX_HAND_JOINT: KinematicBackend._joint_position,
    ControlMode.BODY_TWIST: KinematicBackend._body_twist,
    ControlMode.COMPOSITE_MODE: KinematicBackend._composite_mode,
}


def _start(robot: RobotManifest, joints: Sequence[Joint]) -> FloatArray:
    """Where joints are when an episode starts [rad or m]."""
    home = {} if robot.home is None else robot.home.positions
    middles = ((one, 0.5 * (one.lower + one.upper) if one.has_bounds else 0.0) for one in joints)
    return np.array([home.get(one.name, middle) for one, middle in middles])


def _check_modes(robot: RobotManifest) -> None:
    valid = [mode.yaml_name for mode in _MOVES]
    for part in robot.parts:
        for mode in part.control_modes:
            if mode not in _MOVES:
                who = f"hal_kinematic: part {part.name}"
                raise ConfigError(expected(who, "a mode it can do", mode.yaml_name, valid))
