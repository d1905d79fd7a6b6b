"""Which body of a model is which link of a description, and where in it: found by moving both."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.errors import ConfigError
from fairlead.hal.mujoco_frames import follow, joint_ties
from fairlead.robot.description import DescriptionTree
from fairlead.robot.link_poses import FloatArray, Poses, link_poses, random_positions
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.draft.derived_urdf import Pose
from fairlead_tools.draft.source_model import WHO, SourceModel

_SAMPLES = 20
_SAME_M = _SAME_RAD = 1e-4


@dataclass(frozen=True)
class Offset:
    """Where a link lies in a body, and by how much that changes as the joints move [m, rad]."""

    link: str
    body: int
    place: Pose
    spread_m: float
    spread_rad: float

    @property
    def distance_m(self) -> float:
        """From the body's origin to the link's."""
        return float(np.linalg.norm(self.place.translation))

    @property
    def angle_rad(self) -> float:
        """From the body's axes to the link's."""
        return _angle(self.place.rotation)

    @property
    def is_none(self) -> bool:
        """Whether the body's frame is the link's."""
        return self.distance_m < _SAME_M and self.angle_rad < _SAME_RAD

    @property
    def is_fixed(self) -> bool:
        """Whether both move alike."""
        return self.spread_m < _SAME_M and self.spread_rad < _SAME_RAD


def matched_frames(
    robot: RobotManifest, tree: DescriptionTree, source: SourceModel,
    bodies: Mapping[str, int], alike: Mapping[str, int], same: Mapping[str, int],
) -> tuple[int, list[Offset]]:  # fmt: skip
    """The body that is the root link, and where each link lies in its body.

    Args:
        bodies: the body that has to carry each link, by number.
        alike: bodies that are called as links; they may lie elsewhere, and are left out then.
        same: number of the model's joint for each of the description.

    Raises:
        ConfigError: naming each link that moves otherwise than its body, by how much.
    """
    positions = random_positions(robot, tree, _SAMPLES)
    described, placed = link_poses(tree, positions), _body_poses(source, positions, same)
    named = mujoco.mj_name2id(source.model, mujoco.mjtObj.mjOBJ_BODY, tree.root)
    bases = dict.fromkeys(one for one in (named, 0, source.base) if one >= 0)
    tried = {
        base: [_offset(link, body, placed, base, described[link]) for link, body in bodies.items()]
        for base in bases
    }
    for base, offsets in tried.items():
        if all(one.is_fixed for one in offsets):
            others = [
                _offset(link, body, placed, base, described[link]) for link, body in alike.items()
            ]
            return base, offsets + [one for one in others if one.is_fixed and one.is_none]
    best = min(tried.values(), key=lambda offsets: sum(one.spread_m for one in offsets))
    wrong = "\n".join(
        f"  link {one.link}: {one.spread_m * 1e3:.4g} mm and {one.spread_rad:.4g} rad off body "
        f"{source.model.body(one.body).name}"
        for one in best
        if not one.is_fixed
    )
    raise ConfigError(
        f"{WHO}: the URDF and {source.path} are not the same robot: over "
        f"{_SAMPLES} random poses\n{wrong}\ncorrect one of them, or leave out --urdf: it is then "
        "made of the MJCF"
    )


def _body_poses(
    source: SourceModel, positions: Mapping[str, FloatArray], same: Mapping[str, int]
) -> list[list[Pose]]:
    """Of each sample the pose of every body in the world."""
    model, found = source.model, []
    data, ties = mujoco.MjData(model), joint_ties(model, same.values())
    for sample in range(_SAMPLES):
        data.qpos[:] = source.rest()
        for name, values in positions.items():
            data.qpos[model.jnt_qposadr[same[name]]] = values[sample]
        follow(model, data.qpos, ties)
        mujoco.mj_kinematics(model, data)
        found.append([
            Pose(data.xmat[body].reshape(3, 3).copy(), data.xpos[body].copy())
            for body in range(model.nbody)
        ])  # fmt: skip
    return found


def _offset(link: str, body: int, placed: list[list[Pose]], base: int, described: Poses) -> Offset:
    places = list(_places(body, placed, base, described))
    first = places[0]
    return Offset(
        link, body, first,
        max(float(np.linalg.norm(one.translation - first.translation)) for one in places),
        max(_angle(first.rotation.T @ one.rotation) for one in places),
    )  # fmt: skip


def _places(body: int, placed: list[list[Pose]], base: int, described: Poses) -> Iterator[Pose]:
    for sample, bodies in enumerate(placed):
        at = min(sample, len(described.translation) - 1)
        link = Pose(described.rotation[at], described.translation[at])
        yield bodies[body].inverse().then(bodies[base].then(link))


def _angle(rotation: FloatArray) -> float:
    share = float(np.linalg.norm(rotation - np.eye(3))) / np.sqrt(8.0)
    return 2.0 * float(np.arcsin(min(1.0, share)))
