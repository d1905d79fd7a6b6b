"""MujocoBackend: any MJCF model with position servos behind the HAL contract."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np
import numpy.typing as npt

from fairlead.errors import HardwareError
from fairlead.hal.backend import (
    BackendDescription,
    FramePose,
    Measurement,
    PartCommand,
    TaskReading,
    describe_part,
)
from fairlead.hal.interpolation import interpolator_of
from fairlead.hal.mujoco_frames import ContactWatch, MujocoFrames, base_body
from fairlead.hal.mujoco_joints import find_sources
from fairlead.hal.setpoints import Setpoints
from fairlead.hal.tool_motion import FrameKinematics, ToolMotion
from fairlead.messages import FloatArray
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_mujoco.model_file import GOAL_KEY, HOME_KEY, GoalPose, key_qpos, load_model
from fairlead_hal_mujoco.options import MujocoOptions

NO_ROTATION = np.array([0.0, 0.0, 0.0, 1.0])


class MujocoBackend:
    """Implements `fairlead.hal.backend.Backend` and `fairlead.hal.backend.TraceSource`.

    ``odom`` is the simulator's world and stands still in ``map``; its base frame is the
    manifest's ``simulator.base_body``, or the world where it names none.

    Args:
        robot: its manifest; the model must have its joints.
        profile: safety profile whose limits are told as command ranges.

    Raises:
        ConfigError: for a model that does not fit the manifest.
    """

    def __init__(
        self, robot: RobotManifest, profile: str = "sim", options: MujocoOptions | None = None
    ) -> None:
        options = options or MujocoOptions()
        self._robot, self._options = robot, options
        path = robot_dir(robot.id) / (options.model or f"{robot.id}.xml")
        self._model, self._steps = load_model(path, robot.tick_period_ns)
        self._data = mujoco.MjData(self._model)
        self._sources = find_sources(self._model, robot, "hal_mujoco")
        commanded = self._sources[: robot.n_dof]
        kinematics = FrameKinematics(self._model, self._data, robot, commanded, "hal_mujoco")
        tools = ToolMotion(robot, profile, kinematics)
        self._setpoints = Setpoints(robot, tools, who="hal_mujoco", profile=profile)
        self._interpolator = interpolator_of(robot, profile)
        self._base = base_body(self._model, robot, "hal_mujoco")
        self._parts = tuple(describe_part(robot, part, profile) for part in robot.parts)
        self._contacts = ContactWatch(lambda body: body != "world")
        self._goal: GoalPose | None = None
        goal = key_qpos(self._model, GOAL_KEY)
        if goal is not None:
            wanted = self._measure(goal)[: robot.n_dof]
            self._goal = GoalPose.of(robot, profile, options, wanted)
        self.reset(options.seed)

    def describe(self) -> BackendDescription:
        """What the model says of the joints, and the declared ranges of each part."""
        return BackendDescription(
            joints=self._robot.joint_names,
            passive_joints=self._robot.passive_joint_names,
            parts=self._parts,
            simulator_order=(),
            cameras=(),
            has_task=self._goal is not None,
            interpolation=self._robot.interpolation,
        )

    def frames(self) -> MujocoFrames:
        """Where the model has the robot's frames."""
        return MujocoFrames(self._model, self._data, self._robot, "hal_mujoco")

    def read(self) -> Measurement:
        """Joints as they are after the newest physics step; a gripper is the sum of its fingers."""
        data, sources = self._data, self._sources
        return Measurement(
            positions=self._measure(data.qpos),
            velocities=np.array([s.sum(data.qvel, s.dofs) for s in sources]),
            efforts=np.array([s.sum(data.qfrc_actuator, s.dofs) / len(s.dofs) for s in sources]),
        )

    def transforms(self) -> Sequence[FramePose]:
        """``odom`` to the base frame: the arm stands still."""
        # Positions of bodies are one physics step older than the joints': bring them up to date.
        mujoco.mj_kinematics(self._model, self._data)
        position, quaternion_wxyz = self._data.xpos[self._base], self._data.xquat[self._base]
        return [
            FramePose(
                "odom", self._robot.base_frame, position.copy(), quaternion_wxyz[[1, 2, 3, 0]]
            )
        ]

    def static_transforms(self) -> Sequence[FramePose]:
        """``map -> odom``: the world of the model."""
        return [FramePose("map", "odom", np.zeros(3), NO_ROTATION)]

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """As `Backend.apply`; at each physics step the servos get a new position of the way.

        Raises:
            HardwareError: if the simulation diverges.
        """
        measured = self._measure(self._data.qpos)[: self._robot.n_dof]
        way = self._interpolator.advance(self._setpoints.advance(commands, measured))
        for step in range(1, self._steps + 1):
            self._write(way(step / self._steps))
            mujoco.mj_step(self._model, self._data)
            self._contacts.note(self._model, self._data)
        if not (np.isfinite(self._data.qpos).all() and np.isfinite(self._data.qvel).all()):
            raise HardwareError(
                f"hal_mujoco: the simulation diverged at {self._data.time:.3f} s: servos too stiff "
                "for its timestep; give their joints armature or a lower kp, or it a shorter one"
            )

    def task(self) -> TaskReading | None:
        """How far the joints are from the model's key ``goal``; None without one."""
        if self._goal is None:
            return None
        found, n_dof = self.read(), self._robot.n_dof
        positions, velocities = found.positions[:n_dof], found.velocities[:n_dof]
        return TaskReading(
            success=self._goal.reached(positions, velocities),
            metrics={"distance_in_tolerances": self._goal.distance(positions)},
        )

    def reset(self, seed: int) -> None:
        """At ``home`` of robot.yaml, else key ``home``, else the model's own pose.

        Turning joints are off by a little.
        """
        mujoco.mj_resetData(self._model, self._data)
        self._contacts.restart()
        home = key_qpos(self._model, HOME_KEY)
        if home is not None:
            self._data.qpos[:] = home
        if self._robot.home is not None:
            self._place(self._robot.home.positions)
        spread = np.random.default_rng(seed).uniform(-1.0, 1.0, self._robot.n_dof)
        spread *= self._options.start_spread_rad
        for joint, source, offset in zip(
            self._robot.joints, self._sources[: self._robot.n_dof], spread, strict=True
        ):
            if joint.unit == "rad":
                start = float(self._data.qpos[source.qpos[0]] + offset)
                inside = np.clip(start, joint.lower, joint.upper) if joint.has_bounds else start
                self._data.qpos[source.qpos[0]] = inside
        positions = self._measure(self._data.qpos)[: self._robot.n_dof]
        self._setpoints.restart(positions)
        self._interpolator.restart(positions)
        self._write(positions)
        mujoco.mj_forward(self._model, self._data)

    def snapshot(self) -> bytes:
        """Nothing to render from: this HAL has no cameras."""
        return b""

    def close(self) -> None:
        """Nothing to release."""

    def contacts(self) -> Sequence[str]:
        """Bodies that touch each other or the world, or did since it was last asked."""
        return self._contacts.since_asked(self._model, self._data)

    def packed(self) -> npt.NDArray[np.float32]:
        """The model's ``ctrl`` as float32: what its actuators were told last."""
        return np.asarray(self._data.ctrl, dtype=np.float32).copy()

    def generalized_state(self) -> tuple[FloatArray, FloatArray]:
        """MuJoCo's ``qpos`` and ``qvel`` now, in the model's order."""
        return self._data.qpos.copy(), self._data.qvel.copy()

    def _place(self, positions: Mapping[str, float]) -> None:
        for joint, source in zip(self._robot.joints, self._sources, strict=False):
            if joint.name in positions:
                self._data.qpos[list(source.qpos)] = source.shares(positions[joint.name])
        passive = self._robot.passive_joints
        for joint, source in zip(passive, self._sources[self._robot.n_dof :], strict=True):
            self._data.qpos[list(source.qpos)] = positions[joint.name]

    def _measure(self, qpos: FloatArray) -> FloatArray:
        return np.array([source.sum(qpos, source.qpos) for source in self._sources])

    def _write(self, positions: FloatArray) -> None:
        for source, value in zip(self._sources, positions, strict=False):
            self._data.ctrl[list(source.servos)] = source.shares(float(value))
