"""The ``<collision>`` elements of a URDF file as a MuJoCo model: one body a link, all at rest."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from pathlib import Path

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.robot.manifest import RobotManifest

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
            f"{path}: no link has a <collision>; name a model with --model (an MJCF file, or "
            "robosuite:NAME)"
        )
    spec = mujoco.MjSpec()
    for link in links:
        body = spec.worldbody.add_body(name=link.get("name", ""))
        for collision in link.findall("collision"):
            _add(spec, body, collision, path)
    try:
        return spec.compile()
    except ValueError as error:
        raise ConfigError(f"{path}: {' '.join(str(error).split())}") from None


def _add(spec: mujoco.MjSpec, body: mujoco.MjsBody, collision: ET.Element, path: Path) -> None:
    who = f"{path}: collision of link {body.name!r}"
    shape = next(iter(collision.find("geometry") or ()), None)
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
        raise ConfigError(expected(who, f"a mesh ({', '.join(_MESHES)})", str(file)))
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
