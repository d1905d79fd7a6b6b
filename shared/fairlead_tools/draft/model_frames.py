"""Where a model has the links of a description: by its bodies, else by sites that are added."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import mujoco
import numpy as np

from fairlead.errors import ConfigError
from fairlead.hal.mujoco_frames import joint_ties
from fairlead.messages import FloatArray
from fairlead.robot.description import DescriptionTree, description_tree
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.draft.derived_urdf import pose_of
from fairlead_tools.draft.joints import joints_called
from fairlead_tools.draft.matched_frames import Offset, matched_frames
from fairlead_tools.draft.robot_document import DraftRobot
from fairlead_tools.draft.source_model import WHO, SourceModel

_SAME_M = 1e-4


def with_frames(
    draft: DraftRobot, robot: RobotManifest, source: SourceModel, *, derived: bool
) -> DraftRobot:
    """Name a body or a site of the model for each link that moves, and each tool.

    Args:
        derived: the description was made of the model: where they differ nothing is in doubt.

    Raises:
        ConfigError: the model and the description do not move alike, or have a tool elsewhere.
    """
    model, tree = source.model, description_tree(robot)
    joints = {one.name: one.model_joints[0] for one in draft.joints}
    same = {one.joint: int(model.joint(joints[one.joint]).id) for one in tree.links if one.joint}
    moved = {one.name: int(model.jnt_bodyid[same[one.joint]]) for one in tree.links if one.joint}
    tools = {part.tool: _carrier(tree, part.tool, moved, source.base) for part in draft.parts}
    led = {
        one.name: int(model.jnt_bodyid[number])
        for one in tree.links
        if one.mimic is not None and (number := _joint(source, one.mimic.name)) >= 0
    }
    tied = {
        one.follower: str(model.joint(one.follower).name)
        for one in joint_ties(model, same.values())
    }
    told = {
        one.name: int(model.jnt_bodyid[found[0]])
        for one in tree.links
        if one.mimic is not None and len(found := joints_called(one.mimic.name, tied)) == 1
    }
    alike = {
        name: body
        for name in tree.frames[1:]
        if name not in {**moved, **tools, **led, **told} and (body := _body(source, name)) >= 0
    }
    base, offsets = matched_frames(robot, tree, source, {**tools, **moved, **told}, alike, same)
    root = str(model.body(base).name)
    frames = {name: f"body:{model.body(body).name}" for name, body in led.items()}
    frames, open_ = {tree.root: f"body:{root}", **frames}, {}
    for one in offsets:
        frames[one.link] = _named(source, one)
        if not (one.is_none or derived):
            open_[f"simulator.frames.{one.link}"] = (
                f"{one.distance_m * 1e3:.2f} mm and {one.angle_rad:.4f} rad from the frame of body "
                f"{model.body(one.body).name}; both move alike: compare its place with the robot"
            )
    return replace(draft, base_body=root, frames=frames, open={**draft.open, **open_})


def _body(source: SourceModel, name: str) -> int:
    return int(mujoco.mj_name2id(source.model, mujoco.mjtObj.mjOBJ_BODY, name))


def _joint(source: SourceModel, name: str) -> int:
    return int(mujoco.mj_name2id(source.model, mujoco.mjtObj.mjOBJ_JOINT, name))


def _carrier(tree: DescriptionTree, link: str, moved: Mapping[str, int], base: int) -> int:
    parents = {one.name: one.parent for one in tree.links}
    while link not in moved and link in parents:
        link = parents[link]
    return moved.get(link, base)


def _named(source: SourceModel, one: Offset) -> str:
    """The body or site that has the link's frame; a site is added where there is none.

    Raises:
        ConfigError: the model has a site of the link's name, elsewhere.
    """
    model = source.model
    if one.is_none:
        return f"body:{model.body(one.body).name}"
    site = int(mujoco.mj_name2id(model, mujoco.mjtObj.mjOBJ_SITE, one.link))
    if site < 0:
        quaternion = np.zeros(4)
        mujoco.mju_mat2Quat(quaternion, one.place.rotation.ravel())
        source.spec.body(model.body(one.body).name).add_site(
            name=one.link, pos=one.place.translation, quat=quaternion
        )
        return f"site:{one.link}"
    there = _place(source, site, one.body)
    off_m = float(np.linalg.norm(there - one.place.translation))
    if off_m > _SAME_M:
        raise ConfigError(
            f"{WHO}: the URDF has {one.link} {off_m * 1e3:.4g} mm from the site of that name in "
            f"{source.path.name}: correct one of them"
        )
    return f"site:{one.link}"


def _place(source: SourceModel, site: int, body: int) -> FloatArray:
    """Where a site is in a body that carries it [m]."""
    model, at = source.model, int(source.model.site_bodyid[site])
    place = pose_of(model.site_quat[site], model.site_pos[site])
    while at not in (body, 0):
        place = pose_of(model.body_quat[at], model.body_pos[at]).then(place)
        at = int(model.body_parentid[at])
    return place.translation
