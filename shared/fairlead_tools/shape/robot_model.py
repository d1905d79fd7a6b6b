"""A compiled model of a robot beside its description: an MJCF file, or a robot of robosuite."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.frame_check import check_frames
from fairlead.hal.mujoco_frames import MujocoFrames
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest

ROBOSUITE = "robosuite:"
_HOME = "home"


@dataclass(frozen=True)
class RobotModel:
    """The model, and the robot at rest in it.

    name: as a person would write it. rest: what the pose at rest is called.
    """

    robot: RobotManifest
    name: str
    rest: str
    model: mujoco.MjModel
    data: mujoco.MjData
    who: str

    @cached_property
    def frames(self) -> MujocoFrames:
        """Where it has the robot's frames."""
        return MujocoFrames(self.model, self.data, self.robot, f"{self.who}: {self.name}")

    def check(self) -> str:
        """Compare its frames with the description's; what was found, in words.

        Raises:
            ConfigError: naming each frame that is off.
        """
        who, here = f"{self.who}: {self.name}", self.frames.positions()
        return f"{self.name}: {check_frames(self.robot, self.frames, here, who, stands=self.rest)}"


def robot_model(robot: RobotManifest, asked: str | None, who: str) -> RobotModel | None:
    """The model a person names, else the one robot.yaml does, else ``<robot>.xml`` beside it.

    Args:
        asked: an MJCF file, ``robosuite:ROBOT``, or ``robosuite:ROBOT+GRIPPER``.
        who: what complains.

    Returns:
        None where nobody names one and there is no such file.

    Raises:
        ConfigError: there is no such model, or it cannot be loaded.
    """
    declared = None if robot.simulator is None else robot.simulator.model
    folder = robot_dir(robot.id)
    name = asked or declared
    if name is not None and name.startswith(ROBOSUITE):
        return _of_robosuite(robot, name, who)
    path = Path(asked) if asked else folder / (declared or f"{robot.id}.xml")
    if name is None and not path.is_file():
        return None
    return _of_file(robot, path, who)


def _of_file(robot: RobotManifest, path: Path, who: str) -> RobotModel:
    if not path.is_file():
        raise ConfigError(f"{who}: expected an MJCF file, got none at {path}")
    try:
        model = mujoco.MjModel.from_xml_path(str(path))
    except ValueError as error:
        raise ConfigError(f"{who}: {path}: {' '.join(str(error).split())}") from None
    data = mujoco.MjData(model)
    key = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_KEY, _HOME)
    if key >= 0:
        data.qpos[:] = model.key_qpos[key]
    rest = f"key {_HOME}" if key >= 0 else "the model's own pose"
    if robot.home is not None:
        _place(model, data, robot, robot.home.positions)
        rest = "home"
    return RobotModel(robot, str(path), rest, model, data, who)


def _place(
    model: mujoco.MjModel, data: mujoco.MjData, robot: RobotManifest, home: Mapping[str, float]
) -> None:
    """Joints that the model calls by one name; a name it does not have is found later."""
    for joint, position in home.items():
        names = robot.simulator_joints(joint)
        number = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, names[0])
        if len(names) == 1 and number >= 0:
            data.qpos[model.jnt_qposadr[number]] = position


def _of_robosuite(robot: RobotManifest, name: str, who: str) -> RobotModel:
    try:
        from fairlead_hal_sim import SimulatorOptions, gripper_names, make_environment
    except ImportError as error:
        raise ConfigError(f"{who}: {name}: cannot load robosuite: {error}") from None

    arm, _, gripper = name.removeprefix(ROBOSUITE).partition("+")
    known = gripper_names()
    if gripper and gripper not in known:
        raise ConfigError(
            expected(f"{who}: {name}", "a gripper of robosuite", repr(gripper), known)
        )
    worn = {"gripper_types": gripper} if gripper else {}
    options = SimulatorOptions(robot=arm, env_options=worn)
    environment = make_environment(options, 1e3 / robot.control_period_ms, offscreen=False)
    environment.reset()
    model, data = environment.sim.model._model, mujoco.MjData(environment.sim.model._model)
    data.qpos[:] = np.array(environment.sim.data.qpos)
    return RobotModel(robot, name, "robosuite's reset", model, data, who)


_MESHES = (".obj", ".stl")
_SHAPES = ("box", "cylinder", "sphere", "mesh")


def urdf_model(robot: RobotManifest) -> mujoco.MjModel:
    """Compile them.

    Raises:
        ConfigError: no such element at all, a shape or a file that cannot be read.
    """
    path = robot.description_path()
    try:
        links = ET.parse(path).getroot().findall("link")  # noqa: S314 - the robot's own file
    except (OSError, ET.ParseError) as error:
        raise ConfigError(f"{path}: cannot be read as XML: {error}") from None
    if not any(link.find("collision") is not None for link in links):
        raise ConfigError(
            f"{path}: no link has a <collision>; name its MuJoCo model: --mjcf FILE of robot new, "
            "--model FILE (or robosuite:NAME) of robot capsules"
        )
    spec = mujoco.MjSpec()
    for link in links:  # MuJoCo has a body called world already
        name = link.get("name", "")
        body = spec.worldbody if name == "world" else spec.worldbody.add_body(name=name)
        for collision in link.findall("collision"):
            _add(spec, body, collision, path)
    try:
        return spec.compile()
    except ValueError as error:
        raise ConfigError(f"{path}: {' '.join(str(error).split())}") from None


def _add(spec: mujoco.MjSpec, body: mujoco.MjsBody, collision: ET.Element, path: Path) -> None:
    who = f"{path}: collision of link {body.name!r}"
    shape = collision.find("geometry/*")
    if shape is None or shape.tag not in _SHAPES:
        tag = "none" if shape is None else shape.tag
        raise ConfigError(expected(who, "a shape", tag, _SHAPES))
    geom = body.add_geom()
    origin = collision.find("origin")
    if origin is not None:
        geom.pos = _numbers(origin, "xyz", 3, who, "0 0 0")
        roll, pitch, yaw = _numbers(origin, "rpy", 3, who, "0 0 0")
        mujoco.mju_euler2Quat(geom.quat, [roll, pitch, yaw], "XYZ")
    match shape.tag:
        case "box":
            geom.type = mujoco.mjtGeom.mjGEOM_BOX
            geom.size = [length / 2 for length in _numbers(shape, "size", 3, who)]
        case "cylinder":
            geom.type = mujoco.mjtGeom.mjGEOM_CYLINDER
            (radius,), (length,) = (_numbers(shape, key, 1, who) for key in ("radius", "length"))
            geom.size = [radius, length / 2, 0]
        case "sphere":
            geom.type = mujoco.mjtGeom.mjGEOM_SPHERE
            geom.size = [*_numbers(shape, "radius", 1, who), 0, 0]
        case _:
            geom.type = mujoco.mjtGeom.mjGEOM_MESH
            geom.meshname = _mesh(spec, shape, path.parent, who)


def _mesh(spec: mujoco.MjSpec, shape: ET.Element, folder: Path, who: str) -> str:
    file = folder / shape.get("filename", "").removeprefix("package://")
    if file.suffix.lower() not in _MESHES:
        got = f"{file}; convert it to one of these, and name that in the URDF"
        raise ConfigError(expected(who, f"a mesh ({', '.join(_MESHES)})", got))
    if not file.is_file():
        raise ConfigError(f"{who}: no mesh file {file}")
    name = f"mesh {len(spec.meshes)}"
    spec.add_mesh(
        name=name, file=str(file.resolve()), scale=_numbers(shape, "scale", 3, who, "1 1 1")
    )
    return name


def _numbers(element: ET.Element, key: str, count: int, who: str, default: str = "") -> list[float]:
    text = element.get(key, default)
    try:
        values = [float(word) for word in text.split()]
    except ValueError:
        values = []
    if len(values) != count or not np.all(np.isfinite(values)):
        raise ConfigError(expected(f"{who}: {key}", f"{count} numbers", repr(text)))
    return values
