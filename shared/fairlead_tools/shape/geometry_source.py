"""Where the geometry of a robot's links comes from: a model of it, or its URDF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.errors import ConfigError
from fairlead.messages import FloatArray
from fairlead.robot.description_tree import description_tree
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.shape.link_geometry import Geometry
from fairlead_tools.shape.model_geometry import body_pieces, geom_pose, solid_geoms
from fairlead_tools.shape.robot_model import RobotModel, robot_model
from fairlead_tools.shape.urdf_model import urdf_model

Carrier = tuple[str, FloatArray, FloatArray]
"""A link, and the pose of a body in its frame: rotation and translation [m]."""
_WHO = "robot capsules"


@dataclass(frozen=True)
class GeometrySource:
    """A compiled model whose bodies are the robot's links.

    name: as a person would write it. rest: joint positions of the robot at rest, as far as
    the model says them [rad or m]. agreement: how well its frames are the description's.
    """

    name: str
    model: mujoco.MjModel
    carriers: Mapping[int, Carrier]
    rest: Mapping[str, float]
    agreement: str

    def geometry(self) -> Geometry:
        """Pieces of each link, in its frame."""
        found: Geometry = {}
        for body, (link, rotation, translation) in self.carriers.items():
            pieces = [one.placed(rotation, translation) for one in body_pieces(self.model, body)]
            found.setdefault(link, []).extend(pieces)
        return found

    def geoms(self, link: str) -> Iterator[tuple[str, int, FloatArray, FloatArray]]:
        """Each geom of a link that can collide: link, number, and its pose in the link's frame."""
        for body, (name, rotation, translation) in self.carriers.items():
            if name == link:
                for geom in solid_geoms(self.model, body):
                    turned, shift = geom_pose(self.model, geom)
                    yield link, geom, rotation @ turned, rotation @ shift + translation


def geometry_source(robot: RobotManifest, model: str | None) -> GeometrySource:
    """The geometry of the model that `robot_model` finds, else of the robot's URDF.

    Raises:
        ConfigError: no geometry there, bodies that are no links of the robot, or links elsewhere
            than the robot's description has them.
    """
    found = robot_model(robot, model, _WHO)
    if found is not None:
        return _of_model(found)
    compiled = urdf_model(robot)
    links = {body: str(compiled.body(body).name) for body in range(1, compiled.nbody)}
    still = (np.eye(3), np.zeros(3))
    carriers = {body: (link, *still) for body, link in links.items()}
    agreement = f"{robot.description}: geometry and frames are of one file"
    return GeometrySource(robot.description, compiled, carriers, {}, agreement)


def _of_model(found: RobotModel) -> GeometrySource:
    agreement = found.check()
    links = _links(found)
    carriers = {
        body: carrier
        for body in range(1, found.model.nbody)
        if (carrier := _carrier(found.model, body, links, found.name)) is not None
    }
    measured = zip(found.robot.measured_joint_names, found.frames.positions(), strict=True)
    return GeometrySource(
        found.name, found.model, carriers, {n: float(p) for n, p in measured}, agreement
    )


def _links(found: RobotModel) -> dict[int, Carrier]:
    """The link of each body that carries a frame of the robot, and where it is in that link.

    A body may be called otherwise, or lie otherwise, than its link: where robot.yaml names a site
    for the link, capsules are told in the site's frame. Where it names both for one body, the
    body's own frame is the link's.
    """
    robot, data = found.robot, found.data
    mujoco.mj_kinematics(found.model, data)
    tree = description_tree(robot)
    rest = dict(zip(robot.measured_joint_names, found.frames.positions(), strict=True))
    moving = {link.joint: np.array([rest[link.joint]]) for link in tree.links if link.joint}
    poses = link_poses(tree, moving)
    base = found.frames.base
    root, origin = data.xmat[base].reshape(3, 3), data.xpos[base]
    links: dict[int, Carrier] = {}
    by_body_first = sorted(found.frames.frames.items(), key=lambda item: item[1].is_site)
    for link, frame in by_body_first:
        body, T_root_link = frame.body(found.model), poses[link]
        turned = T_root_link.rotation[0].T
        place = root.T @ (data.xpos[body] - origin) - T_root_link.translation[0]
        rotation = turned @ root.T @ data.xmat[body].reshape(3, 3)
        links.setdefault(body, (link, rotation, turned @ place))
    return links


def _carrier(
    model: mujoco.MjModel, body: int, links: Mapping[int, Carrier], name: str
) -> Carrier | None:
    """The link a body belongs to and its pose in that link's frame, None if it is no part of it."""
    rotation, translation, moved = np.eye(3), np.zeros(3), False
    start = body
    while body and body not in links:
        own = np.zeros(9)
        mujoco.mju_quat2Mat(own, model.body_quat[body])
        rotation = own.reshape(3, 3) @ rotation
        translation = own.reshape(3, 3) @ translation + model.body_pos[body]
        moved = moved or int(model.body_jntnum[body]) > 0
        body = int(model.body_parentid[body])
    if body and moved:
        who, called = f"{_WHO}: {name}: body {model.body(start).name!r}", links[body][0]
        raise ConfigError(f"{who} moves on link {called!r} and has no frame in robot.yaml")
    if not body:
        return None
    link, turned, shift = links[body]
    return link, turned @ rotation, turned @ translation + shift
