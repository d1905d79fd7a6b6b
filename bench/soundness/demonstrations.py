"""Good demonstrations: what the scripted experts tell each robot, chunk by chunk."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol

import numpy as np

from bench.equipment.expert_episode import commands, true_state
from fairlead.hal.backend import PartCommand
from fairlead.modes import ControlMode
from fairlead.policy import Observation
from fairlead.skill.manifest import load_skill
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_skill_runner.policies.joint_reach import JointReachPolicy
from fairlead_skill_runner.policies.oracle.policy import OraclePolicy
from fairlead_tools.measure.driven_robot import DrivenRobot, Moment

ROBOTS = ("panda_mobile", "panda", "dual_panda")
"""Those that have one."""
Rows = list[Mapping[str, PartCommand]]


class Demonstration(Protocol):
    """One episode. most_ticks: when to give up, or to end where there is no task."""

    most_ticks: int

    def chunk(self, now: Moment, tick: int) -> Rows:
        """The next eight rows, from the one for ``tick`` on."""

    def is_over(self) -> bool:
        """Whether the task is done."""


def demonstration(driven: DrivenRobot) -> Demonstration:
    """A new one for this robot, which has just been reset."""
    if isinstance(driven.backend, RobosuiteBackend):
        return CounterToCabinet(driven.backend)
    return JointReach() if driven.robot.id == "panda" else Lift(driven)


class CounterToCabinet:
    """The mobile robot's expert."""

    most_ticks = 450

    def __init__(self, backend: RobosuiteBackend) -> None:
        self._backend, self._policy = backend, OraclePolicy()

    def chunk(self, now: Moment, tick: int) -> Rows:
        """As the skill's: see `Demonstration`."""
        seen = Observation(tick, true_state(self._backend), "")
        return [commands(row) for row in self._policy.infer(seen)]

    def is_over(self) -> bool:
        """By the task's own check."""
        task = self._backend.task()
        return task is not None and task.success


class JointReach:
    """The fixed arm's expert."""

    most_ticks = 60

    def __init__(self) -> None:
        skill = load_skill("panda-joint-reach")
        self._policy = JointReachPolicy.from_options(skill, skill.policy.options)

    def chunk(self, now: Moment, tick: int) -> Rows:
        """As the skill's: see `Demonstration`."""
        state = np.concatenate([now.positions[:7], now.positions[8:10]])
        rows = self._policy.infer(Observation(tick, state, ""))
        assert isinstance(rows, np.ndarray), "of this layout it never says that it is there"
        arm, gripper = ControlMode.JOINT_POSITION, ControlMode.GRIPPER_POSITION
        return [
            {
                "arm": PartCommand(arm, "", np.append(row[:7], 0.0), tuple(range(7))),
                "gripper": PartCommand(gripper, "", row[7:] * 0.04 + 0.04, ()),
            }
            for row in rows[:8].astype(np.float64)
        ]

    def is_over(self) -> bool:
        """It goes on for its ticks."""
        return False


class Lift:
    """Both arms rise, the left gripper closes, the right hand bends."""

    most_ticks = 40

    def __init__(self, driven: DrivenRobot) -> None:
        skill = load_skill("dual-panda-lift")
        row = np.array(skill.policy.options["row"], dtype=np.float32).astype(np.float64)
        scale = np.array([0.1, 0.1, 0.1, 0.5, 0.5, 0.5])
        hand, own = np.zeros(driven.robot.n_dof), driven.indices("right_hand")
        hand[own] = row[13:]
        twist, binary = ControlMode.CARTESIAN_TWIST, ControlMode.GRIPPER_BINARY
        self._row = {
            "left_arm": PartCommand(twist, "base_link", row[:6] * scale, ()),
            "left_gripper": PartCommand(binary, "", np.ones(1), ()),
            "right_arm": PartCommand(twist, "base_link", row[7:13] * scale, ()),
            "right_hand": PartCommand(ControlMode.DEX_HAND_JOINT, "", hand, tuple(own)),
        }

    def chunk(self, now: Moment, tick: int) -> Rows:
        """The same row again and again."""
        return [self._row] * 8

    def is_over(self) -> bool:
        """It goes on for its ticks."""
        return False
