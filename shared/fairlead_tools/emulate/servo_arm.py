"""An arm whose joints six servos move, in MuJoCo and in real time."""

from __future__ import annotations

import math
import random
from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

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
    hand_rad: where a person's hand pulls the joint; None: nobody touches it.
    """

    servo: Sts3215
    direction: int = 1
    mounted_rad: float = 0.0
    way_rad: float = 0.0
    speed_rad_s: float = 0.0
    hand_rad: float | None = None


class ServoArm:
    """Steps the robot's model as time goes by, and keeps its servos' registers true.

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
        self._measure()
        for servo in self.servos:
            servo.power_up()

    def advance(self, now_s: float) -> None:
        """Let the joints move up to ``now_s``."""
        self._now_s = max(self._now_s, now_s - _LONGEST_S)
        while self._now_s + self._step_s <= now_s:
            for index, drive in enumerate(self._drives):
                self._drive(index, drive)
            mujoco.mj_step(self._model, self._data)
            self._now_s += self._step_s
            self._measure()

    def pull(self, servo_id: int, target_rad: float | None) -> None:
        """A person's hand takes a joint to ``target_rad`` and keeps it there; None: lets go."""
        self._drives[servo_id - 1].hand_rad = target_rad

    def positions(self) -> Sequence[float]:
        """Of the joints [rad]."""
        return [float(self._data.qpos[address]) for address in self._qpos]

    def _drive(self, index: int, drive: _Drive) -> None:
        servo, torque = drive.servo, drive.servo.torque_nm
        self._model.actuator_forcerange[index] = (-torque, torque)
        if torque:
            self._follow(drive)
        else:
            drive.way_rad, drive.speed_rad_s = servo.turned_rad, 0.0
        self._data.ctrl[index] = (drive.way_rad - drive.mounted_rad) * drive.direction
        pull = 0.0
        if drive.hand_rad is not None:
            dof = self._dofs[index]
            off = drive.hand_rad - self._data.qpos[self._qpos[index]]
            pull = _HAND_STIFFNESS * off - _HAND_DAMPING * self._data.qvel[dof]
        self._data.qfrc_applied[self._dofs[index]] = np.clip(pull, -_HAND_NM, _HAND_NM)

    def _follow(self, drive: _Drive) -> None:
        """The setpoint goes on to the goal, at the speed and acceleration that the servo has."""
        servo = drive.servo
        fastest = (abs(servo.get(GOAL_SPEED)) or FASTEST_STEPS_S) * RAD_PER_STEP
        faster = servo.get(ACCELERATION) * _ACCELERATION_UNIT * RAD_PER_STEP or math.inf
        left = servo.goal_rad - drive.way_rad
        wanted = min(fastest, abs(left) / self._step_s, math.sqrt(2 * faster * abs(left)))
        change = math.copysign(wanted, left) - drive.speed_rad_s
        drive.speed_rad_s += min(max(change, -faster * self._step_s), faster * self._step_s)
        drive.way_rad += drive.speed_rad_s * self._step_s

    def _measure(self) -> None:
        for index, drive in enumerate(self._drives):
            position, speed = self._data.qpos[self._qpos[index]], self._data.qvel[self._dofs[index]]
            drive.servo.turned_rad = drive.direction * float(position) + drive.mounted_rad
            torque = drive.direction * float(self._data.actuator_force[index])
            drive.servo.strain(torque, self._step_s)
            drive.servo.measure(drive.direction * float(speed), torque)


def _mount(drives: Sequence[_Drive], chance: random.Random) -> None:
    for drive in drives:
        drive.direction = chance.choice((-1, 1))
        drive.mounted_rad = chance.uniform(-math.pi, math.pi)
