"""Joint motion that brings a tool to a pose: damped least squares on the model's Jacobian."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import PartCommand
from fairlead.hal.model_kinematics import FrameKinematics, Pose
from fairlead.hal.mujoco_frames import Frame
from fairlead.hal.tool_goals import motion_between, tool_goal
from fairlead.messages import FloatArray
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part

DAMPING = 0.05
"""Bounds the joint motion near a singular pose: at most the error / (2 DAMPING), in rad per m
or rad. Elsewhere it only costs iterations."""
ITERATIONS = 30
CLOSE_ENOUGH = 1e-7
"""Remaining error [m, rad] at which the search ends."""


class ToolMotion:
    """The tools of a robot's parts with cartesian modes.

    Raises:
        ConfigError: for a tool frame or a frame of a mode that the model does not have, and
            for a part without joints.
    """

    def __init__(self, robot: RobotManifest, profile: str, kinematics: FrameKinematics) -> None:
        self._kinematics = kinematics
        self._period_s = robot.tick_period_ns * 1e-9
        self._joints, self._tools = dict[str, list[int]](), dict[str, Frame]()
        self._frames: dict[str, Frame] = {}
        for part in robot.parts:
            modes = [mode for mode in part.control_modes if mode.is_tool_mode]
            if not modes:
                continue
            self._joints[part.name] = [robot.joint_names.index(name) for name in part.joints]
            self._tools[part.name] = kinematics.find(_tool_frame(robot, part, kinematics.who))
            limits = robot.profile(profile).parts[part.name]
            for mode in modes:
                for name in getattr(limits, mode.yaml_name).frames:
                    self._frames[name] = kinematics.find(name)

    def steps(self, part: str, command: PartCommand, positions: FloatArray) -> FloatArray:
        """Joint motion of one period, however far that is; the caller bounds it.

        Args:
            part: one with the command's mode.
            positions: setpoints of all commanded joints now, shape ``[n_dof]``.

        Returns:
            Change per joint of the part [rad or m]; what is out of reach remains undone.
        """
        tool, joints = self._tools[part], self._joints[part]
        self._kinematics.place(positions)
        now, frame = (
            self._kinematics.pose(tool),
            self._kinematics.pose(self._frames[command.frame_id]),
        )
        goal = tool_goal(command, now, frame, self._period_s)
        return self._search(tool, joints, positions, goal)

    def _search(
        self, tool: Frame, joints: Sequence[int], positions: FloatArray, goal: Pose
    ) -> FloatArray:
        found, own = positions.copy(), list(joints)
        for _ in range(ITERATIONS):
            self._kinematics.place(found)
            error = motion_between(self._kinematics.pose(tool), goal)
            if np.max(np.abs(error)) < CLOSE_ENOUGH:
                break
            jacobian = self._kinematics.jacobian(tool, own)
            damped = jacobian @ jacobian.T + DAMPING**2 * np.eye(6)
            found[own] += jacobian.T @ np.linalg.solve(damped, error)
        return np.asarray(found[own] - positions[own])


def _tool_frame(robot: RobotManifest, part: Part, who: str) -> str:
    if part.end_effector is None or not part.joints:
        what = "joints and an end effector"
        raise ConfigError(
            expected(
                f"{who}: part {part.name}", what, f"{len(part.joints)} and {part.end_effector}"
            )
        )
    return robot.end_effector(part.end_effector).tool_frame
