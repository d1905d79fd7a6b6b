"""Which joints and servos of a MuJoCo model move and measure each of the robot's joints."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.robot.joint import Joint
from fairlead.robot.manifest import RobotManifest

_ONE_COORDINATE = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)
_RANGE_SLACK = 1e-6


@dataclass(frozen=True)
class Source:
    """One joint of the robot in the simulator: ``position = sum(sign * qpos[address])``.

    qpos, dofs: addresses into positions, and into velocities and forces. signs: +1.0 or
    -1.0 each; two of them make a gripper's opening, the difference of its fingers.
    servos: actuator of each, empty for a passive joint.
    """

    qpos: tuple[int, ...]
    dofs: tuple[int, ...]
    signs: tuple[float, ...]
    servos: tuple[int, ...]

    def sum(self, values: FloatArray, addresses: tuple[int, ...]) -> float:
        """The joint's number out of the simulator's."""
        return float(sum(s * values[a] for s, a in zip(self.signs, addresses, strict=True)))

    def shares(self, value: float) -> FloatArray:
        """What each simulator joint contributes to ``value``, evenly."""
        return np.array(self.signs) * value / len(self.signs)


def find_sources(model: mujoco.MjModel, robot: RobotManifest, who: str) -> tuple[Source, ...]:
    """The source of every joint: commanded ones, then passive ones.

    A joint that ``simulator.joints`` of the manifest does not name is called alike.

    Args:
        who: the HAL, as errors call it.

    Raises:
        ConfigError: for a joint the model lacks or bounds more tightly than the manifest,
            and for a commanded one without a position servo.
    """
    return tuple(
        find_source(model, robot, joint, who) for joint in (*robot.joints, *robot.passive_joints)
    )


def find_source(model: mujoco.MjModel, robot: RobotManifest, joint: Joint, who: str) -> Source:
    """The source of one joint; as `find_sources`."""
    names, commanded = robot.simulator_joints(joint.name), joint in robot.joints
    ids = [_joint_id(model, joint, name, who) for name in names]
    signs = (1.0, -1.0)[: len(ids)]
    _check_range(model, joint, ids, signs, who)
    return Source(
        qpos=tuple(int(model.jnt_qposadr[index]) for index in ids),
        dofs=tuple(int(model.jnt_dofadr[index]) for index in ids),
        signs=signs,
        servos=tuple(_servo(model, joint, index, who) for index in ids) if commanded else (),
    )


def _joint_id(model: mujoco.MjModel, joint: Joint, name: str, who: str) -> int:
    valid = [
        model.joint(index).name
        for index in range(model.njnt)
        if model.jnt_type[index] in _ONE_COORDINATE
    ]
    if name not in valid:
        what = f"a hinge or slide of the model for joint {joint.name}"
        raise ConfigError(expected(who, what, repr(name), valid))
    return int(model.joint(name).id)


def _check_range(
    model: mujoco.MjModel, joint: Joint, ids: list[int], signs: tuple[float, ...], who: str
) -> None:
    """The gate admits the manifest's range, so the model must reach all of it."""
    limited = [bool(model.jnt_limited[index]) for index in ids]
    if joint.type == "continuous" and any(limited):
        who = f"{who}: joint {joint.name}"
        got = f"{model.jnt_range[ids[0]].tolist()} in the model"
        raise ConfigError(expected(who, "a joint without range, for it is continuous", got))
    if not joint.has_bounds or not all(limited):
        return
    ends = np.array([s * model.jnt_range[i] for s, i in zip(signs, ids, strict=True)])
    lower, upper = float(ends.min(axis=1).sum()), float(ends.max(axis=1).sum())
    if lower > joint.lower + _RANGE_SLACK or upper < joint.upper - _RANGE_SLACK:
        raise ConfigError(
            expected(
                f"{who}: joint {joint.name}: range",
                f"at least [{joint.lower:g}, {joint.upper:g}] {joint.unit} (robot.yaml)",
                f"[{lower:g}, {upper:g}] in the model",
            )
        )


def _servo(model: mujoco.MjModel, joint: Joint, index: int, who: str) -> int:
    """The one actuator that drives a joint to the position it is told."""
    found = [
        actuator
        for actuator in range(model.nu)
        if model.actuator_trntype[actuator] == mujoco.mjtTrn.mjTRN_JOINT
        and model.actuator_trnid[actuator, 0] == index
    ]
    if len(found) != 1 or not _is_position_servo(model, found[0]):
        got = ", ".join(model.actuator(actuator).name or "unnamed" for actuator in found)
        raise ConfigError(
            expected(
                f"{who}: joint {joint.name}",
                f"one <position> actuator on {model.joint(index).name!r}",
                got or "none",
            )
            + f': <position joint={model.joint(index).name!r} kp=... dampratio="1"/>'
        )
    _check_controls(model, joint, found[0], who)
    return found[0]


def _check_controls(model: mujoco.MjModel, joint: Joint, servo: int, who: str) -> None:
    """MuJoCo cuts what a servo is told to its ``ctrlrange``, and nobody notices."""
    if not model.actuator_ctrllimited[servo] or joint.role == "gripper":
        return
    low, high = (float(end) for end in model.actuator_ctrlrange[servo])
    wanted = "none, for the joint is continuous"
    if joint.has_bounds:
        if low <= joint.lower + _RANGE_SLACK and high >= joint.upper - _RANGE_SLACK:
            return
        wanted = f"at least [{joint.lower:g}, {joint.upper:g}] {joint.unit} (robot.yaml)"
    who = f"{who}: joint {joint.name}: ctrlrange of its actuator"
    raise ConfigError(expected(who, wanted, f"[{low:g}, {high:g}]"))


def _is_position_servo(model: mujoco.MjModel, actuator: int) -> bool:
    gain, bias = model.actuator_gainprm[actuator], model.actuator_biasprm[actuator]
    affine = model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_AFFINE
    stateless = model.actuator_dyntype[actuator] == mujoco.mjtDyn.mjDYN_NONE
    unit_gear = model.actuator_gear[actuator, 0] == 1.0
    return bool(affine and stateless and unit_gear and gain[0] > 0 and bias[1] == -gain[0])
