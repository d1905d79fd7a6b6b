"""From a tool's motion to joints: poses and Jacobians of a model, damped least squares on them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import PartCommand
from fairlead.hal.mujoco_frames import Frame, MujocoFrames, find_frame
from fairlead.hal.mujoco_joints import Source, find_sources
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.part import Part


@dataclass(frozen=True)
class Pose:
    """T_world_frame: position [m], rotation as a quaternion wxyz, the simulator's order."""

    position: FloatArray
    quaternion_wxyz: FloatArray


class FrameKinematics:
    """The model's geometry on a copy of its state: nothing here moves a simulation.

    Frames go by the names of ``simulator.frames`` in robot.yaml.

    Args:
        data: the simulation, for the coordinates that no joint of the robot commands.
        sources: of the commanded joints, in wire order.
        who: the HAL, as errors call it.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        data: mujoco.MjData,
        robot: RobotManifest,
        sources: Sequence[Source],
        who: str,
    ) -> None:
        self._model, self._live, self._copy = model, data, mujoco.MjData(model)
        self._robot, self._sources, self.who = robot, tuple(sources), who

    def find(self, name: str) -> Frame:
        """The frame of that name.

        Raises:
            ConfigError: if robot.yaml does not say where it is, or the model has no such thing.
        """
        return find_frame(self._model, self._robot, name, self.who)

    def place(self, positions: FloatArray) -> None:
        """Put the copy where the commanded joints are at ``positions``, shape ``[n_dof]``."""
        self._copy.qpos[:] = self._live.qpos
        for source, position in zip(self._sources, positions, strict=True):
            self._copy.qpos[list(source.qpos)] = source.shares(float(position))
        mujoco.mj_kinematics(self._model, self._copy)
        mujoco.mj_comPos(self._model, self._copy)

    def frames(self) -> MujocoFrames:
        """All frames of the robot, for positions that it is told."""
        return MujocoFrames(self._model, self._live, self._robot, self.who)

    def pose(self, frame: Frame) -> Pose:
        """T_world_frame at the last `place`."""
        data, quaternion_wxyz = self._copy, np.zeros(4)
        if frame.is_site:
            mujoco.mju_mat2Quat(quaternion_wxyz, data.site_xmat[frame.index])
            return Pose(data.site_xpos[frame.index].copy(), quaternion_wxyz)
        return Pose(data.xpos[frame.index].copy(), data.xquat[frame.index].copy())

    def jacobian(self, frame: Frame, joints: Sequence[int]) -> FloatArray:
        """Twist of the frame's origin per joint speed at the last `place`.

        Args:
            joints: indices into the commanded joints.

        Returns:
            Shape ``[6, len(joints)]``: linear, then angular, along the world's axes.
        """
        whole = np.zeros((6, self._model.nv))
        find = mujoco.mj_jacSite if frame.is_site else mujoco.mj_jacBody
        find(self._model, self._copy, whole[:3], whole[3:], frame.index)
        columns = [
            whole[:, list(source.dofs)] @ source.shares(1.0)
            for source in (self._sources[joint] for joint in joints)
        ]
        return np.stack(columns, axis=1)


def robot_kinematics(robot: RobotManifest, who: str) -> FrameKinematics:
    """By the robot's own model, ``robots/<id>/<id>.xml``, for a HAL without a simulation.

    Raises:
        ConfigError: there is none, or it does not fit the manifest.
    """
    path = robot_dir(robot.id) / f"{robot.id}.xml"
    if not path.is_file():
        raise ConfigError(f"{who}: expected an MJCF file for cartesian modes, got none at {path}")
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise ConfigError(f"{who}: {path}: {' '.join(str(error).split())}") from None
    sources = find_sources(model, robot, who)[: robot.n_dof]
    return FrameKinematics(model, mujoco.MjData(model), robot, sources, who)


def tool_goal(command: PartCommand, tool: Pose, frame: Pose, period_s: float) -> Pose:
    """The tool's pose at the end of a period.

    cartesian_pose: the values are T_frame_tool. cartesian_delta: xyz and a rotation vector r
    along the frame's axes, applied at the tool's origin: R' = exp(r) R. cartesian_twist: the
    same, per second.

    Args:
        tool: where the tool is (or was told to be) now.
        frame: the command's frame_id.
        period_s: control period [s].
    """
    values = command.values
    if command.mode is ControlMode.CARTESIAN_POSE:
        position = frame.position + rotated(values[:3], frame)
        return Pose(position, product(frame.quaternion_wxyz, values[[6, 3, 4, 5]]))
    share = period_s if command.mode is ControlMode.CARTESIAN_TWIST else 1.0
    shift, turn = rotated(values[:3] * share, frame), rotated(values[3:] * share, frame)
    return Pose(tool.position + shift, product(rotation(turn), tool.quaternion_wxyz))


def motion_between(start: Pose, goal: Pose) -> FloatArray:
    """Shift [m] and rotation vector [rad] from one pose to another, world axes, shape [6]."""
    inverse, turn = np.zeros(4), np.zeros(3)
    mujoco.mju_negQuat(inverse, start.quaternion_wxyz)
    mujoco.mju_quat2Vel(turn, product(goal.quaternion_wxyz, inverse), 1.0)
    return np.concatenate([goal.position - start.position, turn])


def rotated(vector: FloatArray, frame: Pose) -> FloatArray:
    """A vector along the frame's axes, along the world's."""
    found = np.zeros(3)
    mujoco.mju_rotVecQuat(found, vector, frame.quaternion_wxyz)
    return found


def rotation(vector: FloatArray) -> FloatArray:
    """exp(vector) as a quaternion wxyz; ``vector`` in rad."""
    found, angle = np.zeros(4), float(np.linalg.norm(vector))
    axis = vector / angle if angle > 0.0 else np.array([0.0, 0.0, 1.0])
    mujoco.mju_axisAngle2Quat(found, axis, angle)
    return found


def product(first: FloatArray, second: FloatArray) -> FloatArray:
    """Quaternion product, wxyz."""
    found = np.zeros(4)
    mujoco.mju_mulQuat(found, first, second)
    return found


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
