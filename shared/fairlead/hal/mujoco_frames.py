"""Where a MuJoCo model has the frames of a robot: for simulated HALs, and for the robot's shape.

Frames and joints go by ``simulator`` in robot.yaml; a robot without that block calls both as
the model does, and its base frame is the model's world.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.hal.backend import FramePose
from fairlead.messages import FloatArray
from fairlead.robot.description import description_tree
from fairlead.robot.manifest import RobotManifest

WORLD_BODY = 0


@dataclass(frozen=True)
class Frame:
    """A body or a site of the model, by number."""

    is_site: bool
    index: int

    def body(self, model: mujoco.MjModel) -> int:
        """The body that carries it."""
        return int(model.site_bodyid[self.index]) if self.is_site else self.index


def find_frame(model: mujoco.MjModel, robot: RobotManifest, name: str, who: str) -> Frame:
    """The frame that the description calls ``name``.

    Raises:
        ConfigError: if robot.yaml does not say where it is, or the model has no such thing.
    """
    if robot.simulator is None:
        reference = f"site:{name}" if _number(model, "site", name) >= 0 else f"body:{name}"
    elif name in robot.simulator.frames:
        reference = robot.simulator.frames[name]
    else:
        what = "a frame of simulator.frames in robot.yaml"
        raise ConfigError(expected(who, what, repr(name), robot.simulator.frames))
    kind, _, called = reference.partition(":")
    index = _number(model, kind, called)
    if index < 0:
        raise ConfigError(expected(who, f"a {kind} of the model for frame {name}", repr(called)))
    return Frame(kind == "site", index)


def base_body(model: mujoco.MjModel, robot: RobotManifest, who: str) -> int:
    """Number of the body that is the robot's base frame.

    Raises:
        ConfigError: naming the model's bodies, if it has none of that name.
    """
    if robot.simulator is None:
        return WORLD_BODY
    names = [model.body(index).name for index in range(model.nbody)]
    name = robot.simulator.base_body
    if name not in names:
        raise ConfigError(expected(who, "a body of the model", repr(name), names))
    return names.index(name)


class MujocoFrames:
    """The model's geometry on a copy of its state: nothing here moves the simulation.

    Implements `fairlead.hal.backend.FrameModel`.

    Attributes:
        base: number of the body that is the robot's base frame.
        frames: body or site of each frame of the description that the model has.

    Args:
        data: the simulation, for where the robot stands and what no joint of the robot moves.
        who: what complains.

    Raises:
        ConfigError: a link that a joint moves, or a tool's frame, that robot.yaml has no name of
            the model for; a name that the model does not have.
    """

    def __init__(
        self, model: mujoco.MjModel, data: mujoco.MjData, robot: RobotManifest, who: str
    ) -> None:
        self._model, self._live, self._copy = model, data, mujoco.MjData(model)
        self._robot = robot
        self.base = base_body(model, robot, who)
        wanted = _wanted(robot)
        known = wanted if robot.simulator is None else list(robot.simulator.frames)
        missing = [name for name in wanted if name not in known]
        if missing:
            raise ConfigError(
                f"{who}: simulator.frames in robot.yaml: missing {', '.join(missing)}; each link "
                "that a joint moves and each tool's frame is compared with a body or a site"
            )
        self.frames = {name: find_frame(model, robot, name, who) for name in known}
        self._addresses = {
            joint.name: [_address(model, name, joint.name, who) for name in names]
            for joint in (*robot.joints, *robot.passive_joints)
            if (names := robot.simulator_joints(joint.name))
        }
        places = [one[0] for one in self._addresses.values() if len(one) == 1]
        told = set(np.flatnonzero(np.isin(model.jnt_qposadr, places)).tolist())
        self._ties = joint_ties(model, told)
        told.update(one.follower for one in self._ties)
        coupled = description_tree(robot).coupled
        self._compared = [
            name for name in known if name not in coupled or self._moved_by(name) <= told
        ]

    def _moved_by(self, name: str) -> set[int]:
        """Numbers of the joints between the base and a frame."""
        model, found, body = self._model, set[int](), self.frames[name].body(self._model)
        while body not in (self.base, WORLD_BODY):
            first = int(model.body_jntadr[body])
            found.update(range(first, first + int(model.body_jntnum[body])))
            body = int(model.body_parentid[body])
        return found

    def positions(self) -> FloatArray:
        """The measured joints where the simulation stands, in wire order [rad or m]."""
        qpos = self._live.qpos
        return np.array(
            [
                float(qpos[first] - sum(qpos[other] for other in others))
                for first, *others in self._addresses.values()
            ]
        )

    def frame_poses(self, positions: FloatArray | None) -> Sequence[FramePose]:
        """As `FrameModel.frame_poses`; what a linkage drives follows as the model ties it.

        What a linkage drives by other means than ties of joints is left out.
        """
        self._copy.qpos[:] = self._live.qpos
        if positions is not None:
            for addresses, position in zip(self._addresses.values(), positions, strict=True):
                if len(addresses) == 1:  # a gripper's opening is told by its fingers
                    self._copy.qpos[addresses] = position
        follow(self._model, self._copy.qpos, self._ties)
        mujoco.mj_kinematics(self._model, self._copy)
        return [self._pose(name, self.frames[name]) for name in self._compared]

    def _pose(self, name: str, frame: Frame) -> FramePose:
        data, base, rotation_wxyz = self._copy, self.base, np.zeros(4)
        position = data.site_xpos[frame.index] if frame.is_site else data.xpos[frame.index]
        matrix = data.site_xmat[frame.index] if frame.is_site else data.xmat[frame.index]
        root = data.xmat[base].reshape(3, 3)
        mujoco.mju_mat2Quat(rotation_wxyz, (root.T @ matrix.reshape(3, 3)).ravel())
        return FramePose(
            self._robot.base_frame,
            name,
            root.T @ (position - data.xpos[base]),
            rotation_wxyz[[1, 2, 3, 0]],
        )


class ContactWatch:
    """What of a robot touched what since it was last asked: an impact is over within a tick.

    Until the first time it notes nothing: ticks of a deployment pay nothing for it.

    Args:
        is_own: whether a body of that name is the robot's.
    """

    def __init__(self, is_own: Callable[[str], bool]) -> None:
        self._is_own, self._seen, self._is_asked = is_own, set[str](), False

    def note(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """To be called at each physics step."""
        if self._is_asked and data.ncon:
            self._seen.update(_touching(model, data, self._is_own))

    def restart(self) -> None:
        """What touched before is of another episode."""
        self._seen.clear()

    def since_asked(self, model: mujoco.MjModel, data: mujoco.MjData) -> list[str]:
        """Pairs of bodies, each once, sorted; the first time those that touch now."""
        found = self._seen.union(_touching(model, data, self._is_own))
        self._seen, self._is_asked = set(), True
        return sorted(found)


def _touching(
    model: mujoco.MjModel, data: mujoco.MjData, is_own: Callable[[str], bool]
) -> list[str]:
    found: dict[str, None] = {}
    for index in range(data.ncon):
        contact = data.contact[index]
        bodies = model.geom_bodyid[[contact.geom1, contact.geom2]]
        names = [model.body(body).name for body in bodies]
        if contact.dist < 0.0 and any(map(is_own, names)):
            found[" and ".join(name or "an unnamed body" for name in names)] = None
    return list(found)


def _wanted(robot: RobotManifest) -> list[str]:
    """Frames that must not go uncompared: what joints move, and what tools are."""
    moved = [link.name for link in description_tree(robot).links if link.joint is not None]
    return list(dict.fromkeys([*moved, *(tool.tool_frame for tool in robot.end_effectors)]))


def _number(model: mujoco.MjModel, kind: str, name: str) -> int:
    sort = mujoco.mjtObj.mjOBJ_SITE if kind == "site" else mujoco.mjtObj.mjOBJ_BODY
    return int(mujoco.mj_name2id(model, sort, name))


def _address(model: mujoco.MjModel, name: str, joint: str, who: str) -> int:
    index = mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_JOINT, name)
    if index < 0:
        valid = [model.joint(number).name for number in range(model.njnt)]
        raise ConfigError(
            expected(who, f"a joint of the model for joint {joint}", repr(name), valid)
        )
    return int(model.jnt_qposadr[index])


@dataclass(frozen=True)
class Tie:
    """Number of the joint that follows another, and the polynomial by which it does."""

    follower: int
    leader: int
    polynomial: FloatArray


def joint_ties(model: mujoco.MjModel, told: Collection[int]) -> list[Tie]:
    """What follows the joints that are told, by number, leaders before what follows them."""
    every = [
        Tie(int(model.eq_obj1id[one]), int(model.eq_obj2id[one]), model.eq_data[one, :5])
        for one in range(model.neq)
        if model.eq_type[one] == mujoco.mjtEq.mjEQ_JOINT and model.eq_active0[one]
    ]
    found, known = list[Tie](), set(told)
    while new := [one for one in every if one.leader in known and one.follower not in known]:
        found += new
        known.update(one.follower for one in new)
    return found


def follow(model: mujoco.MjModel, qpos: FloatArray, ties: Sequence[Tie]) -> None:
    """Move what is tied to where its leaders stand."""
    for tie in ties:
        follower, leader = model.jnt_qposadr[[tie.follower, tie.leader]]
        moved = qpos[leader] - model.qpos0[leader]
        qpos[follower] = model.qpos0[follower] + np.polyval(tie.polynomial[::-1], moved)
