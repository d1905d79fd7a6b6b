"""Where the geometry of a robot's links comes from: its URDF, an MJCF file, or robosuite."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.shape.link_geometry import Geometry
from fairlead.shape.model_geometry import body_pieces, geom_pose, solid_geoms
from fairlead.shape.urdf_model import urdf_model

ROBOSUITE = "robosuite:"
_HOME = "home"


@dataclass(frozen=True)
class GeometrySource:
    """A compiled model whose bodies are the robot's links.

    name: as a person would write it. rest: joint positions of the robot at rest, as far as
    the model says them [rad or m].
    """

    name: str
    model: mujoco.MjModel
    carriers: Mapping[int, tuple[str, FloatArray, FloatArray]]
    rest: Mapping[str, float]

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
    """The source a person names, else the robot's MJCF file, else its URDF.

    Args:
        model: an MJCF file, or ``robosuite:NAME`` for one of robosuite's robots.

    Raises:
        ConfigError: no geometry there, or bodies that are no links of the robot.
    """
    own = robot_dir(robot.id) / f"{robot.id}.xml"
    if model is not None and model.startswith(ROBOSUITE):
        return _of_robosuite(robot, model)
    if model is not None or own.is_file():
        path = Path(model) if model is not None else own
        compiled = _compiled(path)
        key = mujoco.mj_name2id(compiled, mujoco.mjtObj.mjOBJ_KEY, _HOME)
        rest = compiled.key_qpos[key] if key >= 0 else compiled.qpos0
        return _of_model(robot, str(path), compiled, rest)
    compiled = urdf_model(robot)
    links = {body: str(compiled.body(body).name) for body in range(1, compiled.nbody)}
    still = (np.eye(3), np.zeros(3))
    return GeometrySource(
        robot.description, compiled, {body: (link, *still) for body, link in links.items()}, {}
    )


def _compiled(path: Path) -> mujoco.MjModel:
    if not path.is_file():
        raise ConfigError(f"robot capsules: expected an MJCF file, got none at {path}")
    try:
        return mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise ConfigError(f"robot capsules: {path}: {' '.join(str(error).split())}") from None


def _of_robosuite(robot: RobotManifest, name: str) -> GeometrySource:
    try:
        from fairlead_hal_sim.environment import make_environment
        from fairlead_hal_sim.options import SimulatorOptions
    except ImportError as error:
        raise ConfigError(f"robot capsules: {name}: cannot load robosuite: {error}") from None

    options = SimulatorOptions(robot=name.removeprefix(ROBOSUITE))
    environment = make_environment(options, 1e3 / robot.control_period_ms, offscreen=False)
    environment.reset()
    model, rest = environment.sim.model._model, np.array(environment.sim.data.qpos)
    return _of_model(robot, name, model, rest)


def _of_model(
    robot: RobotManifest, name: str, model: mujoco.MjModel, rest: FloatArray
) -> GeometrySource:
    if robot.simulator is None:
        raise ConfigError(f"robot capsules: {name}: robot.yaml says of no body which link it is")
    links = {}
    for link, reference in robot.simulator.frames.items():
        kind, _, called = reference.partition(":")
        body = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_BODY, called)
        if kind == "body" and body < 0:
            raise ConfigError(expected(f"robot capsules: {name}", "a body", repr(called)))
        if kind == "body":
            links[body] = link
    positions = {}
    for joint, sources in robot.simulator.joints.items():
        if len(sources) == 1:
            address = int(model.jnt_qposadr[model.joint(sources[0]).id])
            positions[joint] = float(rest[address])
    carriers = {
        body: carrier
        for body in range(1, model.nbody)
        if (carrier := _carrier(model, body, links, name)) is not None
    }
    return GeometrySource(name, model, carriers, positions)


def _carrier(
    model: mujoco.MjModel, body: int, links: Mapping[int, str], name: str
) -> tuple[str, FloatArray, FloatArray] | None:
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
        who, called = f"robot capsules: {name}: body {model.body(start).name!r}", links[body]
        raise ConfigError(f"{who} moves on link {called!r} and has no frame in robot.yaml")
    return (links[body], rotation, translation) if body else None
