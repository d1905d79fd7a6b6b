"""MobilePickPlace: carry a can from a counter into an open cabinet out of the arm's reach."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import numpy as np
import numpy.typing as npt
from robosuite.environments.manipulation.manipulation_env import ManipulationEnv
from robosuite.models.arenas import Arena
from robosuite.models.objects import MujocoXMLObject
from robosuite.models.tasks import ManipulationTask

from fairlead_hal_sim.task.scene import (
    CABINET_DEPTH_M,
    CABINET_INTERIOR_HEIGHT_M,
    CABINET_WIDTH_M,
    CAN_HEIGHT_M,
    COUNTER_HEIGHT_M,
    SHELF_HEIGHT_M,
    PlanarPose,
    Scene,
    sample_scene,
)

ASSETS = Path(__file__).parent / "assets"


class KitchenArena(Arena):  # type: ignore[misc]  # robosuite ships no types
    """Floor and two walls; counter and cabinet are mocap bodies placed at every reset."""

    def __init__(self) -> None:
        super().__init__(str(ASSETS / "kitchen.xml"))


class Can(MujocoXMLObject):  # type: ignore[misc]  # robosuite ships no types
    """A 60 mm drinks can on a free joint; its frame is its centre, z along its axis."""

    def __init__(self, name: str) -> None:
        super().__init__(
            str(ASSETS / "can.xml"),
            name=name,
            joints=[{"type": "free", "damping": "0.0005"}],
            obj_type="all",
            duplicate_collision_geoms=False,
        )


POSE_OF_CAMERA = {
    "robot0_agentview_left": ("-0.5 0.35 1.05", "0.55623853 0.29935253 -0.37678665 -0.6775092"),
    "robot0_agentview_right": ("-0.5 -0.35 1.05", "0.6775092 0.37678665 -0.29935253 -0.55623853"),
}
"""Camera -> position [m] and quaternion (wxyz) in the body that carries the arm."""

FOVY_DEG = "60"


def mount_robocasa_cameras(robot_model: Any) -> None:
    """Add the two cameras over the robot's shoulders that RoboCasa's checkpoints were trained with.

    RoboCasa hangs them on the body that carries the arm, 0.5 m behind it, 0.35 m to each side
    and 1.05 m above, looking forwards, 32.5 degrees down and 12.1 degrees inwards. They move with
    the base and have no mass, so physics does not see them. The third camera of those
    checkpoints, ``robot0_eye_in_hand``, is robosuite's own. Poses and field of view are those
    of ``robocasa/utils/camera_utils.py``, without the noise some of its data sets add.

    One without an Omron base does not get them.
    """
    name = f"{robot_model.base.naming_prefix}support"
    carrier = robot_model.worldbody.find(f".//body[@name='{name}']")
    if carrier is None:
        return
    for camera, (position, quat_wxyz) in POSE_OF_CAMERA.items():
        pose = {"mode": "fixed", "pos": position, "quat": quat_wxyz, "fovy": FOVY_DEG}
        ET.SubElement(carrier, "camera", {"name": camera, **pose})


Vector = npt.NDArray[np.float64]

REST_LINEAR_M_S = 0.01
REST_ANGULAR_RAD_S = 0.1
CLEAR_M = 0.10
"""Distance from grip site to can's centre beyond which the can counts as released."""


class MobilePickPlace(ManipulationEnv):  # type: ignore[misc]  # robosuite ships no types
    """A robosuite environment; subclassing registers it as ``MobilePickPlace``.

    Args:
        base_pose: where the robot's base is put in the world, x, y [m] and yaw [rad]. The
            fixtures stay: elsewhere than at 0, 0, 0 the task is out of reach.

    Success: the can is inside the cabinet, at rest, and released: it touches no part of
    the robot and the gripper has gone away from it.
    The scene of an episode is drawn from ``env.rng`` at every reset and nowhere else, so
    the generator's state at reset decides the whole episode.
    """

    scene: Scene

    def __init__(
        self, robots: Any, base_pose: Sequence[float] = (0.0, 0.0, 0.0), **kwargs: Any
    ) -> None:
        self._base_x, self._base_y, self._base_yaw = base_pose
        defaults = {
            "use_camera_obs": False,
            "has_offscreen_renderer": False,
            "render_camera": "overview",
            "camera_names": "overview",
        }
        super().__init__(robots=robots, **{**defaults, **kwargs})

    def reward(self, action: object = None) -> float:
        """1.0 on success, else 0.0."""
        return float(self._check_success())

    def tracked_bodies(self) -> dict[str, str]:
        """Bodies to publish as frames, as a fiducial tracker would on a real robot.

        ``goal`` lies on the shelf, x pointing into the cabinet, z up; the can, upright on
        the shelf above it, is where the task wants it.
        """
        return {"object": self.can.root_body, "goal": "goal"}

    def task_metrics(self) -> dict[str, float]:
        """object_gripper_distance [m], base_travel [m] (path length of the base's origin)."""
        return {
            "object_gripper_distance": self._gripper_distance(),
            "base_travel": self._base_travel,
        }

    def _load_model(self) -> None:
        super()._load_model()
        robot = self.robots[0].robot_model
        robot.set_base_xpos([self._base_x, self._base_y, 0.0])
        robot.set_base_ori([0.0, 0.0, self._base_yaw])
        mount_robocasa_cameras(self.robots[0].robot_model)
        self.can = Can("can")
        self.model = ManipulationTask(
            mujoco_arena=KitchenArena(),
            mujoco_robots=[robot.robot_model for robot in self.robots],
            mujoco_objects=[self.can],
        )

    def _setup_references(self) -> None:
        super()._setup_references()
        model = self.sim.model
        self._can_body = model.body_name2id(self.can.root_body)
        self._base_body = model.body_name2id(self.robots[0].robot_model.base.root_body)
        self._can_geoms = {model.geom_name2id(name) for name in self.can.contact_geoms}
        self._robot_geoms = {
            model.geom_name2id(name)
            for part in (self.robots[0].robot_model, *self.robots[0].gripper.values())
            for name in part.contact_geoms
        }

    def _reset_internal(self) -> None:
        super()._reset_internal()
        self.scene = sample_scene(self.rng)
        self._place_robot(self.scene.robot_start)
        self._place_fixture("counter", self.scene.counter)
        self._place_fixture("cabinet", self.scene.cabinet)
        can, height = self.scene.can, COUNTER_HEIGHT_M + CAN_HEIGHT_M / 2
        pose = [can.x, can.y, height, np.cos(can.yaw / 2), 0.0, 0.0, np.sin(can.yaw / 2)]
        self.sim.data.set_joint_qpos(self.can.joints[0], np.array(pose))
        self.sim.forward()
        self._base_travel = 0.0
        self._base_last = np.array(self.sim.data.body_xpos[self._base_body][:2])

    def _place_robot(self, start: tuple[float, float]) -> None:
        """Put the base at its start and let the controllers take that as their reset pose."""
        robot = self.robots[0]
        for joint, value in zip(robot.robot_model.base_joints[:2], start, strict=False):
            self.sim.data.set_joint_qpos(joint, value)
        self.sim.forward()
        controller = robot.composite_controller
        for part in controller.part_controllers.values():
            part.update(force=True)
        controller.update_state()
        controller.reset()

    def _place_fixture(self, name: str, pose: PlanarPose) -> None:
        self.sim.data.set_mocap_pos(name, np.array([pose.x, pose.y, 0.0]))
        quat = np.array([np.cos(pose.yaw / 2), 0.0, 0.0, np.sin(pose.yaw / 2)])
        self.sim.data.set_mocap_quat(name, quat)

    def _post_action(self, action: object) -> tuple[float, bool, dict[str, Any]]:
        position = np.array(self.sim.data.body_xpos[self._base_body][:2])
        self._base_travel += float(np.linalg.norm(position - self._base_last))
        self._base_last = position
        result: tuple[float, bool, dict[str, Any]] = super()._post_action(action)
        return result

    def _check_success(self) -> bool:
        return self._inside_cabinet() and self._at_rest() and self._released()

    def _gripper_distance(self) -> float:
        robot = self.robots[0]
        grip = self.sim.data.site_xpos[robot.eef_site_id[robot.arms[0]]]
        return float(np.linalg.norm(grip - self.sim.data.body_xpos[self._can_body]))

    def _inside_cabinet(self) -> bool:
        cabinet = self.sim.model.body_name2id("cabinet")
        rotation = self.sim.data.body_xmat[cabinet].reshape(3, 3)
        offset = self.sim.data.body_xpos[self._can_body] - self.sim.data.body_xpos[cabinet]
        x, y, z = rotation.T @ offset
        above_shelf = z - SHELF_HEIGHT_M
        return bool(
            0.0 < x < CABINET_DEPTH_M
            and abs(y) < CABINET_WIDTH_M / 2
            and 0.0 < above_shelf < CABINET_INTERIOR_HEIGHT_M
        )

    def _at_rest(self) -> bool:
        velocity = self.sim.data.get_joint_qvel(self.can.joints[0])
        return bool(
            np.linalg.norm(velocity[:3]) < REST_LINEAR_M_S
            and np.linalg.norm(velocity[3:]) < REST_ANGULAR_RAD_S
        )

    def _released(self) -> bool:
        return self._gripper_distance() > CLEAR_M and not self._touched()

    def _touched(self) -> bool:
        """True while any geom of the robot touches the can."""
        for contact in self.sim.data.contact[: self.sim.data.ncon]:
            pair = {contact.geom1, contact.geom2}
            if pair & self._can_geoms and pair & self._robot_geoms:
                return True
        return False
