"""RobosuiteBackend: any registered robosuite environment and robot behind the HAL contract.

Frames: ``map`` is the simulator's world. ``odom`` is the frame in which the base joints
are measured, the body that carries them; where it stands in the map is fixed during an
episode. ``base_link`` is the body the base joints move.
"""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import (
    BackendDescription,
    FramePose,
    Measurement,
    PartCommand,
    TaskReading,
)
from fairlead.messages import FloatArray, HalCamera
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_hal_sim.arm_hold import ArmHold
from fairlead_hal_sim.base_frame import BaseMotion
from fairlead_hal_sim.environment import make_environment, seed_environment
from fairlead_hal_sim.introspection import describe_parts, find_action_map
from fairlead_hal_sim.joints import JointReader, find_joints
from fairlead_hal_sim.kinematics import BodyPoses
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.packing import MODE_HOLD, ActionVector, pack
from fairlead_hal_sim.snapshot import take_snapshot

if TYPE_CHECKING:
    from fairlead.hal.mujoco_frames import ContactWatch, MujocoFrames


_LOG = logging.getLogger("hal.robosuite")

WORLD_BODY = 0
ROBOT_BODIES = ("robot0_", "gripper0_", "mobilebase0_")


class RobosuiteBackend:
    """One simulated robot. Implements `fairlead.hal.backend.Backend`.

    Attributes:
        env: the robosuite environment.
        last_packed: copy of the vector of the newest `apply`, taken before ``env.step``
            (the simulator turns the base's numbers in the array it is given); None
            before the first one of an episode.
    """

    last_packed: ActionVector | None
    _has_begun: bool

    def __init__(
        self,
        options: SimulatorOptions,
        period_ns: int = 50_000_000,
        robot: RobotManifest | None = None,
    ) -> None:
        self.env = make_environment(options, 1e9 / period_ns, offscreen=False)
        self._contacts = _watched(self.env)
        self._joints = find_joints(self.env, robot)
        self._reader = JointReader((*self._joints.commanded, *self._joints.passive))
        self._joint_speed_guard = options.joint_speed_guard
        self._tracked_bodies = _tracked_bodies(self.env, options, robot)
        # On a machine's first run a controller's first step is compiled, for seconds: before the
        # first tick, not within a row. The reset leaves nothing of it.
        self.env.step(np.zeros(self.env.action_dim, dtype=np.float32))
        self.reset(options.seed)
        self._action_map = find_action_map(self.env, self._joints)
        self._cameras = _cameras(self.env, options)
        self._poses = BodyPoses(self.env.sim)
        self._find_frames()

    def describe(self) -> BackendDescription:
        """What robosuite's composite controller and model say of the robot."""
        composite = self.env.robots[0].composite_controller
        return BackendDescription(
            joints=self._joints.names,
            passive_joints=tuple(source.name for source in self._joints.passive),
            parts=describe_parts(self._action_map, self._joints, self._dead_band()),
            simulator_order=tuple(composite._action_split_indexes),
            cameras=self._cameras,
            has_task=True,
        )

    def frames(self, robot: RobotManifest) -> MujocoFrames:
        """Where the simulator's model has the frames of a robot."""
        from fairlead.hal.mujoco_frames import MujocoFrames  # mujoco: after the choice of graphics

        sim = self.env.sim
        return MujocoFrames(sim.model._model, sim.data._data, robot, "hal_sim")

    def read(self) -> Measurement:
        """Joints from ``qpos``, ``qvel`` and ``qfrc_actuator`` as they are after the newest step.

        A gripper's opening is the sum over its fingers, its effort their mean.
        """
        return self._reader.read(self.env.sim.data)

    def transforms(self) -> Sequence[FramePose]:
        """``odom -> base_link``, and the bodies that the task tracks, in ``odom``."""
        self._poses.update()
        return [self._poses.frame(self._odom, child) for child in self._tracked]

    def static_transforms(self) -> Sequence[FramePose]:
        """``map -> odom``: where the base stood when the episode began."""
        self._poses.update()
        return [self._poses.frame(("map", WORLD_BODY), self._odom)]

    def apply(self, commands: Mapping[str, PartCommand]) -> None:
        """One ``env.step`` with the vector of `pack`.

        Before an episode's first command nothing moves, and the controllers hold by themselves,
        as they do in a training loop.
        """
        vector = self.pack(commands)
        self.last_packed = vector.copy()
        held = [slot.simulator_part for slot in self._action_map.parts if slot.name not in commands]
        self._has_begun = self._has_begun or bool(commands)
        for part, hold in self._holds.items():
            hold.is_held = self._has_begun and part in held
        self.env.step(vector)
        for hold in self._holds.values():  # a bare `env.step` is the simulator's own
            hold.is_held = False

    def pack(self, commands: Mapping[str, PartCommand]) -> ActionVector:
        """The vector `apply` would send now.

        In the first tick of an episode the composite switch is held at -1.0: after a
        reset the arm's stored goal is in the world frame but read as in the base's, and
        +1 would throw the arm up.
        """
        previous = self.last_packed
        zeros = np.zeros(self._action_map.width, dtype=np.float32)
        vector = pack(
            commands,
            self._action_map,
            zeros if previous is None else previous,
            self._base_motion() if _has_twist(commands) else None,
        )
        if previous is None and "composite" in commands:
            index = self._action_map.slot("composite").first
            if vector[index] > 0:
                _LOG.warning("composite_mode %g held at -1 in the first tick", vector[index])
                vector[index] = MODE_HOLD
        return vector

    def task(self) -> TaskReading | None:
        """The environment's own success check, and its metrics where it has some."""
        metrics: dict[str, float] = getattr(self.env, "task_metrics", dict)()
        return TaskReading(success=bool(self.env._check_success()), metrics=metrics)

    def reset(self, seed: int) -> None:
        """Build the scene of ``seed``; the same seed gives the same scene to the bit."""
        seed_environment(self.env, seed)
        self.env.reset()
        self._contacts.restart()
        controllers = self.env.robots[0].composite_controller.part_controllers
        self._holds = {
            arm.side: ArmHold(controllers[arm.side], self._joint_speed_guard)
            for arm in self._joints.arms
        }
        self.last_packed, self._has_begun = None, False
        self._reset_yaw = self._base_yaw()

    def snapshot(self) -> bytes:
        """The simulator state that `restore_snapshot` takes; b"" without cameras."""
        return take_snapshot(self.env.sim) if self._cameras else b""

    def contacts(self) -> Sequence[str]:
        """What of arm, hand and base touches something, or did since it was last asked."""
        return self._contacts.since_asked(self.env.sim.model._model, self.env.sim.data._data)

    def close(self) -> None:
        """Free the simulator."""
        self.env.close()

    def _find_frames(self) -> None:
        robot_model, poses = self.env.robots[0].robot_model, self._poses
        mobile = bool(self._joints.base)
        root = robot_model.base.root_body if mobile else robot_model.root_body
        base = poses.body_id(root)
        self._odom = ("odom", poses.parent(base) if mobile else WORLD_BODY)
        named = {**getattr(self.env, "tracked_bodies", dict)(), **self._tracked_bodies}
        self._tracked = [("base_link", base)]
        self._tracked += [(frame, poses.body_id(body)) for frame, body in named.items()]

    def _base_yaw(self) -> float:
        """Angle of the yaw joint [rad]; 0.0 for a robot that cannot turn."""
        if len(self._joints.base) != 3:
            return 0.0
        return float(self.env.sim.data.qpos[self._joints.commanded[2].qpos[0]])

    def _base_motion(self) -> BaseMotion | None:
        if len(self._joints.base) != 3:
            return None
        model, yaw = self.env.sim.model, self._base_yaw()
        joint = self._joints.commanded[2].simulator_joints[0]
        pivot = model.jnt_pos[model.joint_name2id(joint)]
        return BaseMotion(
            yaw=yaw,
            turned=yaw - self._reset_yaw,
            pivot=(float(pivot[0]), float(pivot[1])),
            dead_band=self._dead_band(),
        )

    def _dead_band(self) -> FloatArray:
        """Rate each base joint loses to dry friction: friction over servo gain."""
        if not self._joints.base:
            return np.zeros(0)
        model = self.env.sim.model._model
        actuators = self.env.robots[0]._ref_actuators_indexes_dict["base"]
        dofs = [source.dofs[0] for source in self._joints.commanded[: len(actuators)]]
        return np.asarray(model.dof_frictionloss[dofs] / model.actuator_gainprm[actuators, 0])


def _has_twist(commands: Mapping[str, PartCommand]) -> bool:
    return any(command.mode is ControlMode.BODY_TWIST for command in commands.values())


def _watched(env: Any) -> ContactWatch:
    """One that is called at each physics step of the environment."""
    from fairlead.hal.mujoco_frames import ContactWatch  # mujoco: after the choice of graphics

    watch = ContactWatch(lambda body: body.startswith(ROBOT_BODIES))
    go_on = env._pre_action

    def noted(*args: Any, **kwargs: Any) -> None:
        watch.note(env.sim.model._model, env.sim.data._data)
        go_on(*args, **kwargs)

    env._pre_action = noted
    return watch


def _tracked_bodies(
    env: Any, options: SimulatorOptions, robot: RobotManifest | None
) -> dict[str, str]:
    known, who = list(env.sim.model.body_names), "hal_sim: tracked_bodies"
    for frame, body in options.tracked_bodies.items():
        if body not in known:
            raise ConfigError(expected(f"{who}: {frame}", "a body of the model", repr(body), known))
        if robot is not None and frame not in robot.tracked_frames:
            what = "a frame of tracked_frames in robot.yaml"
            raise ConfigError(expected(who, what, repr(frame), robot.tracked_frames or ("none",)))
    return options.tracked_bodies


def _cameras(env: Any, options: SimulatorOptions) -> tuple[HalCamera, ...]:
    known = list(env.sim.model.camera_names)
    for camera in options.cameras:
        if camera.name not in known:
            raise ConfigError(
                expected("hal_sim", "a camera of this environment", repr(camera.name), known)
            )
    return tuple(
        HalCamera(name=c.name, width=c.width, height=c.height, period_ticks=c.period_ticks)
        for c in options.cameras
    )


class RobosuiteTrace:
    """Implements `fairlead.hal.backend.TraceSource`."""

    def __init__(self, backend: RobosuiteBackend) -> None:
        self._backend = backend

    def packed(self) -> npt.NDArray[np.float32]:
        """The float32 vector of the newest ``env.step``; empty before an episode's first."""
        packed = self._backend.last_packed
        return np.zeros(0, dtype=np.float32) if packed is None else packed.copy()

    def generalized_state(self) -> tuple[FloatArray, FloatArray]:
        """MuJoCo's ``qpos`` and ``qvel`` now, in the model's order."""
        data = self._backend.env.sim.data
        return np.array(data.qpos, dtype=np.float64), np.array(data.qvel, dtype=np.float64)
