"""A robot's links as convex parts: from which file, of which link, of a MuJoCo model."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.robot.description import DescriptionTree, Link, description_tree
from fairlead.robot.gate_geometry import is_swept
from fairlead.robot.link_poses import Poses, link_poses, motion, placement
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.shape.convex_part import ConvexPart, IntArray, box, capsule, cylinder, hull
from fairlead_tools.shape.robot_model import RobotModel, robot_model, urdf_model

Geometry = dict[str, list[ConvexPart]]

_TURN_STEP_RAD = 0.1  # of a finger that turns


def with_swept_fingers(
    robot: RobotManifest, tree: DescriptionTree, own: Mapping[str, Iterable[ConvexPart]]
) -> Geometry:
    """Pieces of each link that has any, those of fingers given to what carries them.

    No command says where a finger is that is measured and not commanded (a gripper's), so it
    counts as being everywhere it can be.
    """
    geometry = {name: list(own.get(name, ())) for name in tree.frames}
    for link in reversed(tree.links):
        if is_swept(robot, tree, link):
            carried = geometry.pop(link.name)
            geometry[link.parent] += [part for one in carried for part in _swept(robot, link, one)]
    return {name: pieces for name, pieces in geometry.items() if pieces}


def _swept(robot: RobotManifest, link: Link, piece: ConvexPart) -> list[ConvexPart]:
    """What covers a piece at every position of its joint, in the parent's frame."""
    if link.joint is None and link.mimic is None:
        return [ConvexPart(_at(link, np.zeros(1), piece.points)[0], piece.radius)]
    low, high = _range(robot, link)
    if "prismatic" in (link.kind, link.mimic.kind if link.mimic else ""):
        ends = _at(link, np.array([low, high]), piece.points)
        return [ConvexPart(np.concatenate(list(ends)), piece.radius)]
    steps = max(2, int(np.ceil((high - low) / _TURN_STEP_RAD)) + 1)
    turns = np.linspace(low, high, steps)
    # Between two positions a point bulges out of the chord by less than its sagitta.
    bulge = float(np.linalg.norm(piece.points, axis=1).max()) * (
        1 - np.cos((turns[1] - turns[0]) / 2)
    )
    placed = _at(link, turns, piece.points)
    return [ConvexPart(np.concatenate(pair), piece.radius + bulge) for pair in pairwise(placed)]


def _range(robot: RobotManifest, link: Link) -> tuple[float, float]:
    """Between which positions a finger's joint can be, measured or by what it mimics."""
    if link.mimic is None:
        joint = robot.joint(link.joint or "")
        return joint.lower, joint.upper
    source = robot.joint(link.mimic.joint)
    ends = [link.mimic.multiplier * end + link.mimic.offset for end in (source.lower, source.upper)]
    return min(ends), max(ends)


def _at(link: Link, positions: FloatArray, points: FloatArray) -> list[FloatArray]:
    rotation, translation = placement(link)
    count = len(positions)
    still = Poses(
        np.broadcast_to(rotation, (count, 3, 3)), np.broadcast_to(translation, (count, 3))
    )
    poses = still.then(*motion(link, positions))
    return [
        points @ turn.T + shift
        for turn, shift in zip(poses.rotation, poses.translation, strict=True)
    ]


_KINDS = ("box", "capsule", "cylinder", "ellipsoid", "mesh", "sphere")


def solid_geoms(model: mujoco.MjModel, body: int) -> Iterator[int]:
    """The geoms of a body that can collide, by number."""
    first = int(model.body_geomadr[body])
    for geom in range(first, first + int(model.body_geomnum[body])):
        if model.geom_contype[geom] | model.geom_conaffinity[geom]:
            yield geom


def geom_pose(model: mujoco.MjModel, geom: int) -> tuple[FloatArray, FloatArray]:
    """Pose of a geom in its body's frame: ``[3, 3]`` and ``[3]``."""
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.geom_quat[geom])
    return rotation.reshape(3, 3), np.array(model.geom_pos[geom])


def body_pieces(model: mujoco.MjModel, body: int) -> Iterator[ConvexPart]:
    """Each geom of a body that can collide, in the body's frame; a mesh stands for its hull.

    Raises:
        ConfigError: a geom without an end (a plane, a height field), or a shape by formula.
    """
    for geom in solid_geoms(model, body):
        yield _piece(model, geom).placed(*geom_pose(model, geom))


def _piece(model: mujoco.MjModel, geom: int) -> ConvexPart:
    kind = mujoco.mjtGeom(model.geom_type[geom]).name.removeprefix("mjGEOM_").lower()
    size = np.array(model.geom_size[geom])
    match kind:
        case "box" | "ellipsoid":
            return box(size)
        case "capsule":
            return capsule(size[0], size[1])
        case "cylinder":
            return cylinder(size[0], size[1])
        case "sphere":
            return capsule(size[0], 0.0)
        case "mesh":
            mesh = int(model.geom_dataid[geom])
            return _hull(model, mesh)
    who = f"robot capsules: geom {model.geom(geom).name!r} of body {_body(model, geom)!r}"
    raise ConfigError(expected(who, "a solid", kind, _KINDS))


def _vertices(model: mujoco.MjModel, mesh: int) -> FloatArray:
    first = int(model.mesh_vertadr[mesh])
    return np.array(model.mesh_vert[first : first + int(model.mesh_vertnum[mesh])], dtype=float)


def _hull(model: mujoco.MjModel, mesh: int) -> ConvexPart:
    """The hull that the simulator collides; all vertices where it made none."""
    graph = int(model.mesh_graphadr[mesh])
    if graph < 0:
        return ConvexPart(_vertices(model, mesh))
    # Counts of vertices and faces, two numbers a vertex, its edges, and then the faces.
    vertices, faces = (int(count) for count in model.mesh_graph[graph : graph + 2])
    first = graph + 2 + 3 * (vertices + faces)
    corners: IntArray = np.array(model.mesh_graph[first : first + 3 * faces], dtype=np.int64)
    return hull(_vertices(model, mesh), corners.reshape(-1, 3))


def _body(model: mujoco.MjModel, geom: int) -> str:
    return str(model.body(int(model.geom_bodyid[geom])).name)


Carrier = tuple[str, FloatArray, FloatArray]
"""A link, and the pose of a body in its frame: rotation and translation [m]."""
_WHO = "robot capsules"


def drawn_links(robot: RobotManifest, source: GeometrySource) -> dict[str, str]:
    """Links that have geometry of any kind; and what that is where no capsule is fitted to it."""
    bodies = source.carriers.items()
    drawn = {link for body, (link, *_) in bodies if source.model.body_geomnum[body]}
    links = ET.parse(robot.description_path()).getroot().findall("link")  # noqa: S314 - its own
    has = {kind: {one.get("name", "") for one in links if one.find(kind) is not None}
           for kind in ("visual", "collision")}  # fmt: skip
    only = dict.fromkeys(drawn | has["visual"], "only visual geometry")
    return only | dict.fromkeys(has["collision"], "collision geometry only in its URDF")


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
        return model_geometry(found)
    compiled = urdf_model(robot)
    frames = description_tree(robot).frames
    named = {body: str(compiled.body(body).name) for body in range(compiled.nbody)}
    links = {body: name for body, name in named.items() if name in frames}
    still = (np.eye(3), np.zeros(3))
    carriers = {body: (link, *still) for body, link in links.items()}
    agreement = f"{robot.description}: geometry and frames are of one file"
    return GeometrySource(robot.description, compiled, carriers, {}, agreement)


def model_geometry(found: RobotModel) -> GeometrySource:
    """The geometry of a model, as `geometry_source`."""
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
