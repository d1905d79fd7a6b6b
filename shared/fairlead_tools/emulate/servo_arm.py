"""An arm whose joints six servos move, in MuJoCo and in real time."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco

from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.emulate.sts3215 import (
    ACCELERATION,
    FASTEST_STEPS_S,
    GOAL_SPEED,
    STEPS_PER_TURN,
    Sts3215,
)

RAD_PER_STEP = 2 * math.pi / STEPS_PER_TURN
_ACCELERATION_UNIT = 100  # steps/s2
_LONGEST_S = 0.5
"""A process that was stopped for longer does not catch up."""
_HAND_NM, _HAND_STIFFNESS, _HAND_DAMPING = 5.0, 40.0, 2.0


@dataclass
class _Drive:
    """A servo on its joint.

    direction, mounted_rad: ``turned_rad = direction * joint + mounted_rad``.
    way_rad, speed_rad_s: where its setpoint is on the way to the goal, as `Sts3215.turned_rad`.
    hand_rad: where a person's hand keeps the joint; None: nobody touches it.
    hand_stays: it also does when the servo gets torque.
    """

    servo: Sts3215
    direction: int = 1
    mounted_rad: float = 0.0
    way_rad: float = 0.0
    speed_rad_s: float = 0.0
    hand_rad: float | None = None
    hand_stays: bool = False


class ServoArm:
    """Steps the robot's model as time goes by, and keeps its servos' registers true.

    Somebody holds it in its home pose until the servos do. Nothing is in its way, no table either.

    Args:
        robot: its ``ROBOT.xml`` has one position actuator for each commanded joint.
        mounting_seed: None: each servo is in the middle of its turn where its joint is at 0, and
            turns as it does; else horns at random angles, some the other way round.

    Attributes:
        servos: by joint, ids from 1.
    """

    def __init__(self, robot: RobotManifest, now_s: float, mounting_seed: int | None) -> None:
        path = robot_dir(robot.id) / f"{robot.id}.xml"
        self._model = mujoco.MjModel.from_xml_path(str(path))
        self._model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
        self._data = mujoco.MjData(self._model)
        mujoco.mj_resetDataKeyframe(self._model, self._data, 0)
        mujoco.mj_forward(self._model, self._data)
        self._step_s = float(self._model.opt.timestep)
        self._now_s = now_s
        joints = [self._model.joint(name) for name in robot.joint_names]
        self._qpos = [int(joint.qposadr[0]) for joint in joints]
        self._dofs = [int(joint.dofadr[0]) for joint in joints]
        self.servos = tuple(Sts3215(index + 1) for index in range(len(joints)))
        self._drives = [_Drive(servo) for servo in self.servos]
        if mounting_seed is not None:
            _mount(self._drives, random.Random(mounting_seed))  # noqa: S311 - for variety
        for index, drive in enumerate(self._drives):
            drive.hand_rad = float(self._data.qpos[self._qpos[index]])
        self._measure()
        for servo in self.servos:
            servo.power_up()

    def advance(self, now_s: float) -> None:
        """Let the joints move up to ``now_s``."""
        self._now_s = max(self._now_s, now_s - _LONGEST_S)
        steps = int((now_s - self._now_s) / self._step_s)
        if steps < 1:
            return
        torques = [servo.torque_nm for servo in self.servos]
        self._model.actuator_forcerange[:] = [(-torque, torque) for torque in torques]
        goals = [servo.goal_rad for servo in self.servos]
        paces = [_pace(servo) for servo in self.servos]
        for _ in range(steps):
            for index, drive in enumerate(self._drives):
                self._drive(index, drive, goals[index] if torques[index] else None, paces[index])
            mujoco.mj_step(self._model, self._data)
        self._now_s += steps * self._step_s
        self._measure(steps * self._step_s)

    def pull(self, servo_id: int, target_rad: float | None) -> None:
        """A person's hand takes a joint to ``target_rad`` and keeps it there; None: lets go."""
        drive = self._drives[servo_id - 1]
        drive.hand_rad, drive.hand_stays = target_rad, target_rad is not None

    def position(self, servo_id: int) -> float:
        """Of the joint that a servo moves [rad]."""
        return float(self._data.qpos[self._qpos[servo_id - 1]])

    def _drive(
        self, index: int, drive: _Drive, goal_rad: float | None, pace: tuple[float, float]
    ) -> None:
        position, dof = self._data.qpos[self._qpos[index]], self._dofs[index]
        if goal_rad is None:  # limp
            drive.way_rad = drive.direction * float(position) + drive.mounted_rad
            drive.speed_rad_s = 0.0
        else:
            self._follow(drive, goal_rad, *pace)
            if not drive.hand_stays:
                drive.hand_rad = None
        self._data.ctrl[index] = (drive.way_rad - drive.mounted_rad) * drive.direction
        self._data.qfrc_applied[dof] = 0.0
        if drive.hand_rad is not None:
            pull = _HAND_STIFFNESS * (drive.hand_rad - position)
            pull -= _HAND_DAMPING * self._data.qvel[dof]
            self._data.qfrc_applied[dof] = min(max(pull, -_HAND_NM), _HAND_NM)

    def _follow(
        self, drive: _Drive, goal_rad: float, fastest_rad_s: float, faster_rad_s2: float
    ) -> None:
        """The setpoint goes on to the goal, at the speed and acceleration that the servo has."""
        left = goal_rad - drive.way_rad
        braking = math.sqrt(2 * faster_rad_s2 * abs(left))
        wanted = math.copysign(min(fastest_rad_s, abs(left) / self._step_s, braking), left)
        most = faster_rad_s2 * self._step_s
        drive.speed_rad_s += min(max(wanted - drive.speed_rad_s, -most), most)
        drive.way_rad += drive.speed_rad_s * self._step_s

    def _measure(self, period_s: float = 0.0) -> None:
        for index, drive in enumerate(self._drives):
            position, speed = self._data.qpos[self._qpos[index]], self._data.qvel[self._dofs[index]]
            drive.servo.turned_rad = drive.direction * float(position) + drive.mounted_rad
            torque = drive.direction * float(self._data.actuator_force[index])
            drive.servo.strain(torque, period_s)
            drive.servo.measure(drive.direction * float(speed), torque)


def _pace(servo: Sts3215) -> tuple[float, float]:
    """The speed [rad/s] and acceleration [rad/s2] that it is told; 0 in a register: the most."""
    fastest = (abs(servo.get(GOAL_SPEED)) or FASTEST_STEPS_S) * RAD_PER_STEP
    return fastest, servo.get(ACCELERATION) * _ACCELERATION_UNIT * RAD_PER_STEP or math.inf


def _mount(drives: Sequence[_Drive], chance: random.Random) -> None:
    for drive in drives:
        drive.direction = chance.choice((-1, 1))
        drive.mounted_rad = chance.uniform(-math.pi, math.pi)
