"""The files of a new skill: they work as written and are meant to be changed."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby

from fairlead.errors import ConfigError, expected
from fairlead.keys import check_name
from fairlead.robot.home_check import singular_homes
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part
from fairlead_tools.skills.wave import (
    STRENGTH,
    floor,
    wave_height,
    wave_side,
    wave_speed,
    waving_joint,
)

ARM_MODES = ("cartesian_delta", "joint_velocity", "joint_position")

MANIFEST = """\
# {name}: yours to change; once: fairlead skill install --link {name}
id: {name}
version: 0.1.0
licence: Apache-2.0
model_family: own
policy:
  backend: python # a class of one's own, run in a process of its own
  options:
    file: policy.py
    class: Policy
    options: {{{option}}} # handed to Policy.from_options
embodiments: [{robot}]
prompt: wave

# What the policy sees: these joints, in this order.
state_contract:
  dim: {state_dim}
  joints:
{state}

# What its numbers mean: {meaning}. Ranges include both ends.
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
decided_by: policy
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
        self.reset()

    @classmethod
    def from_options(cls, skill, options):
        """Load weights here. `options` come from rskill.yaml."""
        return cls(float(options["strength"]))

    def reset(self):
        """A new goal begins."""
        self.begun = None

    def infer(self, observation):
        """Rows for the next control periods: float32 [ROWS, DIM], each number in [-1, 1].

        observation.state is the state_contract's vector, observation.prompt the instruction,
        observation.images the pictures the manifest asks for. Row 0 is for the tick of the
        observation; the next call may come before all rows acted. The wave begins anew after a
        hold.
        """
        if self.begun is None or any(part.hold for part in observation.executed.values()):
            self.begun = observation.tick
        row = observation.tick - self.begun
        actions = np.zeros((ROWS, DIM), dtype=np.float32)
        for k in range(ROWS):
            if row + k < 40:
                actions[k, AXIS] = self.strength * np.sin(2 * np.pi * (row + k) / 40)
        return actions
'''

REACH = '''\
"""A policy of one's own: it waves a joint once, for 40 control periods, then holds still."""

import numpy as np

ROWS = 8  # rows per call: the manifest's horizon
JOINTS = {dim}  # the arm's joints: the first numbers of the state, and all of the action
WAVES = {axis}  # the joint that waves: {axis_name}


class Policy:
    """Built once, before the robot is claimed; `infer` is asked for rows again and again."""

    def __init__(self, wave_{unit}):
        self.wave_{unit} = wave_{unit}
        self.reset()

    @classmethod
    def from_options(cls, skill, options):
        """Load weights here. `options` come from rskill.yaml."""
        return cls(float(options["wave_{unit}"]))

    def reset(self):
        """A new goal begins."""
        self.start = None

    def infer(self, observation):
        """Rows for the next control periods: float32 [ROWS, JOINTS], {meaning}.

        Targets begin where the robot is: at first, and again after the arm held. Row 0 is for the
        tick of the observation; the next call may come before all rows acted.
        """
        held = any(part.hold for part in observation.executed.values())
        if self.start is None or held:
            self.start, self.begun = np.array(observation.state[:JOINTS]), observation.tick
        row = observation.tick - self.begun
        actions = np.tile(self.start, (ROWS, 1)).astype(np.float32)
        for k in range(ROWS):
            done = min(row + k + 1, 40) / 40
            actions[k, WAVES] += self.wave_{unit} * 0.5 * (1 - np.cos(2 * np.pi * done))
        return actions
'''

CARTESIAN_SLOT = """\
      control_mode: cartesian_delta
      ee: {ee}
      frame: {frame}
      scale: [{shift}, {shift}, {shift}, {turn}, {turn}, {turn}] # m and rad in one row"""

SHIFT_SLOT = """\
      control_mode: cartesian_delta
      ee: {ee}
      frame: {frame}
      axes: [0, 1, 2] # x y z; the tool turns as {joints} joints need it to
      scale: {shift} # m in one row"""

VELOCITY_SLOT = """\
      control_mode: joint_velocity
      joint_names: [{arm}]
      scale: {scale} # {units}"""

POSITION_SLOT = """\
      control_mode: joint_position
      joint_names: [{arm}]"""

SIX = 6


def skill_skeleton(name: str, robot: RobotManifest, mode: str = "") -> dict[str, str]:
    """File name -> text of a working skill that waves the arm.

    Args:
        mode: one of `ARM_MODES` that the arm takes; "" for the first that it does, and where home
            is singular for one of its joints.

    Raises:
        ConfigError: for a name that cannot be a key, and for a robot without an arm that takes
            such a mode.
    """
    check_name("skill id", name)
    arm = _arm_part(robot, mode)
    mode = mode or _first_mode(arm, robot)
    seen = [*arm.joints, *_gripper_joints(robot)]
    slot, dim, axis, axis_name = _slot(mode, arm, robot)
    meaning, option = "output in [-1, 1], times scale, is SI", f"strength: {STRENGTH}"
    unit = ""
    if mode == "joint_position":
        unit, meaning = robot.joint(axis_name).unit, f"joint targets in {_units(arm, robot)}"
        option = f"wave_{unit}: {wave_height(robot, arm, axis_name)}"
    elif mode == "joint_velocity":
        option = f"strength: {STRENGTH * wave_side(robot, axis_name)}"
    manifest = MANIFEST.format(
        name=name,
        robot=robot.id,
        option=option,
        meaning=meaning,
        state_dim=len(seen),
        state=_state_fields(seen, robot),
        dim=dim,
        last=dim - 1,
        slot=slot,
        rate=1e9 / robot.tick_period_ns,
    )
    policy = REACH if unit else POLICY
    return {
        "rskill.yaml": manifest,
        "policy.py": policy.format(
            dim=dim, axis=axis, axis_name=axis_name, unit=unit, meaning=meaning
        ),
    }


def _first_mode(arm: Part, robot: RobotManifest) -> str:
    modes = [one for one in ARM_MODES if one in arm.modes]
    return modes[-1 if arm.name in singular_homes(robot) else 0]


def _slot(mode: str, arm: Part, robot: RobotManifest) -> tuple[str, int, int, str]:
    """Its text, its width, which of its numbers waves, and what that is called."""
    if mode == "cartesian_delta":
        dim = SIX if len(arm.joints) >= SIX else 3
        return _cartesian_slot(arm, robot, dim), dim, 2, "up and down"
    joints, dim = ", ".join(arm.joints), len(arm.joints)
    waves = waving_joint(robot, arm)
    axis = arm.joints.index(waves)
    if mode == "joint_position":
        return POSITION_SLOT.format(arm=joints), dim, axis, waves
    each = [wave_speed(robot, arm, name) for name in arm.joints]
    scale = each if len(set(each)) > 1 else each[0]
    text = VELOCITY_SLOT.format(arm=joints, scale=scale, units=_units(arm, robot, "/s"))
    return text, dim, axis, waves


def _units(arm: Part, robot: RobotManifest, per: str = "") -> str:
    """Of numbers per joint: ``rad``, ``m``, or which of them are in m."""
    sliding = [name for name in arm.joints if robot.joint(name).unit == "m"]
    if len(sliding) in (0, len(arm.joints)):
        return f"{'m' if sliding else 'rad'}{per}"
    return f"rad{per}, of {', '.join(sliding)} in m{per}"


def _arm_part(robot: RobotManifest, mode: str) -> Part:
    wanted = (mode,) if mode else ARM_MODES
    for part in robot.parts:
        roles = {robot.joint(joint).role for joint in part.joints}
        if roles == {"arm"} and set(wanted) & set(part.modes) & set(ARM_MODES):
            return part
    who, what = f"skill new: robot {robot.id}", f"an arm that takes {' or '.join(wanted)}"
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


def _cartesian_slot(arm: Part, robot: RobotManifest, dim: int) -> str:
    """At full scale on every axis at once the robot's limits, which are of norms, still hold."""
    limits = [profile.parts[arm.name].cartesian_delta for profile in robot.safety.values()]
    shift = min(delta.linear_limit_m for delta in limits if delta) / math.sqrt(3.0)
    turn = min(delta.angular_limit_rad for delta in limits if delta) / math.sqrt(3.0)
    text = CARTESIAN_SLOT if dim == SIX else SHIFT_SLOT
    return text.format(
        ee=arm.end_effector,
        frame=robot.base_frame,
        shift=floor(shift),
        turn=floor(turn),
        joints=len(arm.joints),
    )
