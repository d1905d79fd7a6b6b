"""The collision geometry of a compiled MuJoCo model, as convex pieces of its bodies."""

from __future__ import annotations

from collections.abc import Iterator

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead_tools.shape.convex_part import ConvexPart, IntArray, box, capsule, cylinder, hull

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
