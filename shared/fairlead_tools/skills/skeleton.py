"""The files of a new skill: they work as written and are meant to be changed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby

from fairlead.errors import ConfigError, expected
from fairlead.keys import check_name
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part

ARM_MODES = ("cartesian_delta", "joint_velocity")

MANIFEST = """\
# {name}: change it freely, then: fairlead skill install {name}
id: {name}
version: 0.1.0
licence: Apache-2.0
model_family: own
policy:
  backend: python # a class of one's own, run in a process of its own
  options:
    file: policy.py
    class: Policy
    options: {{strength: 0.9}} # handed to Policy.from_options
embodiments: [{robot}]
prompt: wave

# What the policy sees: these joints, in this order.
state_contract:
  dim: {state_dim}
  joints:
{state}

# What its numbers mean: output in [-1, 1], times scale, is SI. Ranges include both ends.
action_contract:
  dim: {dim}
  slots:
    - range: [0, {last}]
{slot}

rate_hz: {rate:g}
horizon: 8
execute_steps: 8
age_max_ticks: 10
inference_timeout_s: 5.0
"""

POLICY = '''\
"""A policy of one's own: it waves the arm once, for 40 control periods, then holds still."""

import numpy as np

ROWS = 8  # rows per call: the manifest's horizon
DIM = {dim}  # numbers per row: the manifest's action_contract
AXIS = {axis}  # the number that waves: {axis_name}


class Policy:
    """Built once, before the robot is claimed; `infer` is asked for rows again and again."""

    def __init__(self, strength):
        self.strength = strength
        self.row = 0

    @classmethod
    def from_options(cls, skill, options):
        """Load weights here. `options` come from rskill.yaml."""
        return cls(float(options["strength"]))

    def reset(self):
        """A new goal begins."""
        self.row = 0

    def infer(self, observation):
        """Rows for the next control periods: float32 [ROWS, DIM], each number in [-1, 1].

        observation.state is the state_contract's vector, observation.prompt the instruction,
        observation.images the pictures the manifest asks for.
        """
        actions = np.zeros((ROWS, DIM), dtype=np.float32)
        for k in range(ROWS):
            if self.row + k < 40:
                actions[k, AXIS] = self.strength * np.sin(2 * np.pi * (self.row + k) / 40)
        self.row += ROWS
        return actions
'''

CARTESIAN_SLOT = """\
      control_mode: cartesian_delta
      ee: {ee}
      frame: {frame}
      scale: [{shift}, {shift}, {shift}, {turn}, {turn}, {turn}] # m and rad in one period"""

VELOCITY_SLOT = """\
      control_mode: joint_velocity
      joint_names: [{arm}]
      scale: 0.5 # rad/s"""


def skill_skeleton(name: str, robot: RobotManifest) -> dict[str, str]:
    """File name -> text of a working skill that waves the arm.

    Raises:
        ConfigError: for a name that cannot be a key, and for a robot without an arm that takes
            deltas or velocities.
    """
    check_name("skill id", name)
    arm = _arm_part(robot)
    seen = [*arm.joints, *_gripper_joints(robot)]
    cartesian = "cartesian_delta" in arm.modes
    joints = ", ".join(arm.joints)
    slot = _cartesian_slot(arm, robot) if cartesian else VELOCITY_SLOT.format(arm=joints)
    dim, axis = (6, 2) if cartesian else (len(arm.joints), len(arm.joints) - 2)
    manifest = MANIFEST.format(
        name=name,
        robot=robot.id,
        state_dim=len(seen),
        state=_state_fields(seen, robot),
        dim=dim,
        last=dim - 1,
        slot=slot,
        rate=1e9 / robot.tick_period_ns,
    )
    axis_name = "up and down" if cartesian else arm.joints[axis]
    return {
        "rskill.yaml": manifest,
        "policy.py": POLICY.format(dim=dim, axis=axis, axis_name=axis_name),
    }


def _arm_part(robot: RobotManifest) -> Part:
    for part in robot.parts:
        roles = {robot.joint(joint).role for joint in part.joints}
        if roles == {"arm"} and set(ARM_MODES) & set(part.modes):
            return part
    who, what = f"skill new: robot {robot.id}", f"an arm that takes {' or '.join(ARM_MODES)}"
    got = "; ".join(f"{part.name} takes {', '.join(part.modes)}" for part in robot.parts)
    raise ConfigError(expected(who, what, got))


def _gripper_joints(robot: RobotManifest) -> list[str]:
    """Fingers that are measured, else what opens the grippers."""
    fingers = [joint.name for joint in robot.passive_joints if joint.role == "gripper"]
    return fingers or [joint.name for joint in robot.joints if joint.role == "gripper"]


def _state_fields(joints: Sequence[str], robot: RobotManifest) -> str:
    """Lines of the manifest: neighbours that are measured in the same unit are one field."""
    lines = []
    for unit, names in groupby(joints, lambda name: _unit(robot.joint(name).type)):
        lines.append(f"    - {{names: [{', '.join(names)}], quantity: position, unit: {unit}}}")
    return "\n".join(lines)


def _unit(joint_type: str) -> str:
    return "m" if joint_type == "prismatic" else "rad"


def _cartesian_slot(arm: Part, robot: RobotManifest) -> str:
    """At full scale on every axis at once the robot's limits, which are of norms, still hold."""
    limits = [profile.parts[arm.name].cartesian_delta for profile in robot.safety.values()]
    shift = min(delta.linear_limit_m for delta in limits if delta) / math.sqrt(3.0)
    turn = min(delta.angular_limit_rad for delta in limits if delta) / math.sqrt(3.0)
    frame, scales = robot.base_frame, {"shift": _floor(shift), "turn": _floor(turn)}
    return CARTESIAN_SLOT.format(ee=arm.end_effector, frame=frame, **scales)


def _floor(value: float) -> float:
    """Rounded down to two digits: a number to read and to change."""
    unit = 10.0 ** (math.floor(math.log10(value)) - 1)
    return float(f"{math.floor(value / unit) * unit:.2g}")
