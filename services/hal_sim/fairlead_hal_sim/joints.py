"""Which joints a running robosuite robot has, under the names that robot.yaml gives them.

Commanded joints in wire order: the base's, then per arm its joints and one gripper joint: the
total opening of fingers that slide, the first driven knuckle of a hand that turns. Passive ones
after them: the other fingers, the torso slide; of these a robot.yaml need not name all.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import Measurement
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest

_BASE_NAMES = {"forward": "base_x", "side": "base_y", "yaw": "base_yaw"}


@dataclass(frozen=True)
class JointSource:
    """Where one joint's numbers come from: ``position = sum(sign * qpos[address])``.

    qpos, dofs: addresses into the simulator's positions, and into its velocities and
    forces. signs: +1.0 or -1.0 each (a gripper adds its fingers up).
    """

    name: str
    qpos: tuple[int, ...]
    dofs: tuple[int, ...]
    signs: tuple[float, ...]
    simulator_joints: tuple[str, ...]


@dataclass(frozen=True)
class ArmJoints:
    """One arm of the robot and its gripper, by joint name."""

    side: str
    arm: tuple[str, ...]
    gripper: str


@dataclass(frozen=True)
class RobotJoints:
    """Every joint the HAL publishes, and how they group."""

    commanded: tuple[JointSource, ...]
    passive: tuple[JointSource, ...]
    base: tuple[str, ...]
    arms: tuple[ArmJoints, ...]

    @property
    def names(self) -> tuple[str, ...]:
        """Commanded joints in wire order."""
        return tuple(source.name for source in self.commanded)

    def indices(self, names: tuple[str, ...]) -> tuple[int, ...]:
        """Wire indices of commanded joints."""
        return tuple(self.names.index(name) for name in names)


class JointReader:
    """Reads joints out of the simulator's arrays, all at once."""

    def __init__(self, sources: Sequence[JointSource]) -> None:
        self._count = len(sources)
        self._joint = np.repeat(np.arange(self._count), [len(one.dofs) for one in sources])
        self._fingers = np.array([len(one.dofs) for one in sources])
        self._qpos = np.array([address for one in sources for address in one.qpos])
        self._dofs = np.array([address for one in sources for address in one.dofs])
        self._signs = np.array([sign for one in sources for sign in one.signs])

    def read(self, data: Any) -> Measurement:
        """``qpos``, ``qvel``, ``qfrc_actuator``; of fingers the sum, of their efforts the mean."""
        return Measurement(
            positions=self._sums(data.qpos[self._qpos]),
            velocities=self._sums(data.qvel[self._dofs]),
            efforts=self._sums(data.qfrc_actuator[self._dofs]) / self._fingers,
        )

    def _sums(self, values: FloatArray) -> FloatArray:
        weights = self._signs * values
        return np.bincount(self._joint, weights, self._count).astype(np.float64, copy=False)


def find_joints(env: Any, robot: RobotManifest | None = None) -> RobotJoints:
    """Look at the environment's first robot.

    Args:
        robot: its ``simulator.joints`` say what each joint is called; a joint that it does not
            name, and every joint without it, goes by robosuite's name without the prefix of the
            robot's number, behind the arm's kind (``panda_joint1``).

    Raises:
        ConfigError: for a gripper without fingers, and for a name of the simulator in robot.yaml
            that none of its joints has.
    """
    found = _find_joints(env)
    return found if robot is None else _renamed(found, robot)


def _renamed(found: RobotJoints, robot: RobotManifest) -> RobotJoints:
    sources = {frozenset(one.simulator_joints): one for one in (*found.commanded, *found.passive)}
    declared = {} if robot.simulator is None else robot.simulator.joints
    names: dict[str, str] = {}
    for name, called in declared.items():
        source = sources.get(frozenset(called))
        if source is None:
            valid = [", ".join(one.simulator_joints) for one in sources.values()]
            who = f"hal_sim: simulator.joints of robot.yaml: {name}"
            raise ConfigError(expected(who, "joints of robosuite's robot", list(called), valid))
        names[source.name] = name
    passive = {one.name: one for one in (_named(one, names) for one in found.passive)}
    told = robot.passive_joint_names
    return RobotJoints(
        commanded=tuple(_named(one, names) for one in found.commanded),
        passive=tuple(passive[name] for name in told if name in passive),
        base=tuple(names.get(name, name) for name in found.base),
        arms=tuple(
            ArmJoints(
                arm.side,
                tuple(names.get(name, name) for name in arm.arm),
                names.get(arm.gripper, arm.gripper),
            )
            for arm in found.arms
        ),
    )


def _named(source: JointSource, names: Mapping[str, str]) -> JointSource:
    return replace(source, name=names.get(source.name, source.name))


def _find_joints(env: Any) -> RobotJoints:
    robot = env.robots[0]
    model = robot.robot_model
    base = [_single(env, _base_name(joint), joint) for joint in model.base_joints]
    torso = [
        _single(env, joint.removeprefix(model.base.naming_prefix).removeprefix("joint_"), joint)
        for joint in model.torso_joints
    ]
    commanded, passive, arms = list(base), [], []
    for side in robot.arms:
        prefix = _arm_prefix(robot, side)
        own = _arm_joint_names(robot, side)
        arm = [_single(env, prefix + j.removeprefix(model.naming_prefix), j) for j in own]
        fingers = [
            _single(env, prefix + joint.removeprefix(robot.gripper[side].naming_prefix), joint)
            for joint in robot.gripper_joints[side]
        ]
        opening = _opening(env, prefix + "gripper", side, fingers)
        commanded += [*arm, opening]
        passive += [one for one in fingers if one.qpos != opening.qpos]
        arms.append(ArmJoints(side, tuple(j.name for j in arm), opening.name))
    return RobotJoints(
        commanded=tuple(commanded),
        passive=(*passive, *torso),
        base=tuple(joint.name for joint in base),
        arms=tuple(arms),
    )


def finger_range(env: Any, joint: str) -> tuple[float, float]:
    """Travel of a finger joint [m or rad]."""
    model = env.sim.model
    low, high = model.jnt_range[model.joint_name2id(joint)]
    return float(low), float(high)


def _single(env: Any, name: str, joint: str) -> JointSource:
    model = env.sim.model
    return JointSource(
        name=name,
        qpos=(int(model.get_joint_qpos_addr(joint)),),
        dofs=(int(model.get_joint_qvel_addr(joint)),),
        signs=(1.0,),
        simulator_joints=(joint,),
    )


def _opening(env: Any, name: str, side: str, fingers: list[JointSource]) -> JointSource:
    """Of fingers that slide the total opening: travel away from closed counts as positive.

    Of a hand that turns the joint that its first actuator drives.
    """
    model = env.sim.model
    joints = [finger.simulator_joints[0] for finger in fingers]
    if not fingers:
        raise ConfigError(expected("hal_sim", "a gripper with fingers", "none"))
    if not all(slides(env, joint) for joint in joints):
        actuator = model.actuator_name2id(env.robots[0].gripper[side].actuators[0])
        driven = model.joint_id2name(int(model.actuator_trnid[actuator, 0]))
        return _single(env, name, driven)
    return JointSource(
        name=name,
        qpos=tuple(finger.qpos[0] for finger in fingers),
        dofs=tuple(finger.dofs[0] for finger in fingers),
        signs=tuple(1.0 if sum(finger_range(env, joint)) > 0 else -1.0 for joint in joints),
        simulator_joints=tuple(joints),
    )


def slides(env: Any, joint: str) -> bool:
    """Whether a joint of the simulator slides."""
    model = env.sim.model
    return int(model.jnt_type[model.joint_name2id(joint)]) == int(mujoco.mjtJoint.mjJNT_SLIDE)


def _base_name(joint: str) -> str:
    axis = joint.rsplit("_", 1)[-1]
    return _BASE_NAMES.get(axis, joint)


def _arm_prefix(robot: Any, side: str) -> str:
    """``panda_``, or ``right_panda_`` on a robot with more than one arm."""
    kinds = getattr(robot.robot_model, "default_arms", {side: robot.name})
    kind = str(kinds.get(side, robot.name)).lower()
    return f"{kind}_" if len(robot.arms) == 1 else f"{side}_{kind}_"


def _arm_joint_names(robot: Any, side: str) -> list[str]:
    joints: list[str] = robot.robot_model.arm_joints
    count = len(joints) // len(robot.arms)
    start = list(robot.arms).index(side) * count
    return joints[start : start + count]
