"""The draft of a robot's folder, step by step, each checked by what reads its files."""

from __future__ import annotations

import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import mujoco
import numpy as np

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir, robot_ids, user_robots_dir
from fairlead.robot.description import DescriptionTree
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.gate_geometry import is_swept
from fairlead.robot.home_check import smallest_singular_values
from fairlead.robot.link_poses import link_poses, random_positions
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.robot.safety_profile import profile_limits
from fairlead.robot.tool_reach import Reach
from fairlead_hal_mujoco import model_problems
from fairlead_tools.draft.derived_urdf import derived_urdf
from fairlead_tools.draft.file_text import robot_text
from fairlead_tools.draft.fitted_shape import fitted_shape, inside
from fairlead_tools.draft.joints import draft_joints, same_joints
from fairlead_tools.draft.model_frames import with_frames
from fairlead_tools.draft.parts import draft_parts, with_openings
from fairlead_tools.draft.robot_document import DraftRobot
from fairlead_tools.draft.source_model import WHO, SourceModel, load_source
from fairlead_tools.draft.urdf_file import MESHES, copied_urdf, read_urdf
from fairlead_tools.shape import SAMPLES
from fairlead_tools.shape.geometry import drawn_links, geometry_source
from fairlead_tools.shape.robot_shape import RobotShape

_PERIOD_MS = 50.0
_MOST_M, _MOST_RAD = 0.05, 0.25
"""Of a tool's motion in a period: 1 m/s, 5 rad/s."""
_LEAST_SINGULAR, _MOST_SINGULAR = 0.03, 0.1
"""Limits of its Jacobian's smallest singular value [m]."""


@dataclass(frozen=True)
class Asked:
    """What a person asked for, and the command that they gave."""

    id: str
    mjcf: Path | None
    urdf: Path | None

    @property
    def command(self) -> str:
        """As it was typed."""
        words = [f"fairlead robot new {self.id}"]
        words += [f"--urdf {self.urdf}"] if self.urdf else []
        words += [f"--mjcf {self.mjcf}"] if self.mjcf else []
        return " ".join(words)


@dataclass(frozen=True)
class Drafted:
    """What was made. missing: why hal_mujoco cannot move it yet, each with the fix."""

    folder: Path
    robot: RobotManifest
    missing: Sequence[str]

    @property
    def hal(self) -> str:
        """The HAL that moves it as it is."""
        return "hal_kinematic" if self.missing else "hal_mujoco"


def new_robot(asked: Asked, say: Callable[[str], None]) -> Drafted:
    """Write the robot's folder among the user's own robots; nothing is left of one that fails.

    Raises:
        ConfigError: the id is taken, a file does not fit; what of the draft the compiler refuses.
    """
    if asked.mjcf is None and asked.urdf is None:
        raise ConfigError(f"{WHO}: expected --mjcf, --urdf or both, got neither")
    folder = user_robots_dir() / asked.id
    if asked.id in robot_ids() or folder.exists():
        where = folder if folder.exists() else robot_dir(asked.id)
        raise ConfigError(
            f"{WHO}: there is a robot {asked.id!r} already, in {where}; choose another id"
        )
    source = None
    if asked.mjcf is not None:
        say(f"reading {asked.mjcf} and its meshes")
        source = load_source(asked.mjcf)
    done = False
    try:
        folder.mkdir(parents=True)
        drafted = _filled(asked, folder, source, say)
        done = True
    except OSError as error:
        where = error.filename or folder
        raise ConfigError(f"{WHO}: cannot write {where}: {error.strerror}") from None
    except ConfigError as error:
        raise ConfigError(_of_given_files(str(error), asked, folder)) from None
    finally:
        if not done:
            shutil.rmtree(folder, ignore_errors=True)
    return drafted


def _of_given_files(said: str, asked: Asked, folder: Path) -> str:
    """An error that names what a person has: the copies that it is of are about to go."""
    for copy, given in (
        (f"{folder}/{asked.id}.urdf", str(asked.urdf or asked.mjcf)),
        (f"{folder}/{asked.id}.xml", str(asked.mjcf)),
        (f"{folder}/{MESHES}/", ""),
        (f"{folder}/", "the draft's "),
    ):
        said = said.replace(copy, given)
    return said


def _filled(
    asked: Asked, folder: Path, source: SourceModel | None, say: Callable[[str], None]
) -> Drafted:
    say("joints, parts and frames")
    draft = _joints_and_parts(asked, folder, source)
    manifest = _written(asked, folder, draft)
    if source is not None:
        draft = with_frames(draft, manifest, source, derived=asked.urdf is None)
        source.write(folder / f"{asked.id}.xml")
        manifest = _written(asked, folder, draft)
    shape = RobotShape(manifest, geometry_source(manifest, None), say)
    draft = _with_bare_links(draft, shape)
    shape = replace(shape, robot=_written(asked, folder, draft))
    fitted = fitted_shape(draft, shape)
    (folder / manifest.capsules).write_text(fitted.text(asked.id), encoding="utf-8")
    draft = replace(
        draft, home=fitted.home, home_source=fitted.home_source or draft.home_source,
        open={**draft.open, **fitted.open},
        reach=_reach(shape.robot, shape.tree, draft, source),
        tool_steps=_tool_steps(shape.robot, shape.tree, draft),
        singularity_limits=_singularity_limits(shape.robot, fitted.home),
    )  # fmt: skip
    manifest = _written(asked, folder, draft)
    say("the gate's file")
    (folder / "gate.sim.json").write_text(compile_gate_config(manifest, "sim"), encoding="utf-8")
    return Drafted(folder, manifest, _missing(manifest, folder, source))


def _joints_and_parts(asked: Asked, folder: Path, source: SourceModel | None) -> DraftRobot:
    urdf_file = folder / f"{asked.id}.urdf"
    if asked.urdf is not None:
        text = copied_urdf(asked.urdf, folder, with_meshes=source is None)
    else:
        assert source is not None, "one of the two files is given"
        text = derived_urdf(source, asked.id, source.tool_sites())
    urdf_file.write_text(text, encoding="utf-8")
    root, cited = read_urdf(urdf_file), (asked.urdf or asked.mjcf or urdf_file).name
    same = {} if source is None else same_joints(root, source)
    joints = with_openings(draft_joints(root, cited, source, same))
    parts = draft_parts(root, joints)
    if not parts:
        raise ConfigError(f"{WHO}: {cited}: expected joints that can be commanded, got none")
    children = {one.get("link") for one in root.findall("joint/child")}
    base = next(n for one in root.findall("link") if (n := one.get("name", "")) not in children)
    period_ms = _PERIOD_MS
    if source is not None:
        step_ms = source.model.opt.timestep * 1e3
        period_ms = round(max(1, round(_PERIOD_MS / step_ms)) * step_ms, 6)
    home = {
        one.name: inside(0.0 if source is None or not one.model_joints
                          else source.position(source.rest(), one.model_joints),
                          one.lower, one.upper)
        for one in joints if one.lower is not None and one.upper is not None
    }  # fmt: skip
    said = "0, or the end nearest to it" if source is None else "the model's own pose"
    return DraftRobot(asked.id, period_ms, base, joints, parts, home, said)


def _written(asked: Asked, folder: Path, draft: DraftRobot) -> RobotManifest:
    (folder / "robot.yaml").write_text(robot_text(draft, asked.command), encoding="utf-8")
    return load_robot(asked.id)


def _with_bare_links(draft: DraftRobot, shape: RobotShape) -> DraftRobot:
    """Declare the links without a shape; one that has some geometry is for a person to look at."""
    swept = {link.name for link in shape.tree.links if is_swept(shape.robot, shape.tree, link)}
    bare = [one for one in shape.tree.frames if one not in shape.geometry and one not in swept]
    drawn = drawn_links(shape.robot, shape.source)
    why = {one: drawn.get(one, "a frame") for one in bare}
    open_ = {
        f"no_collision_geometry.{one}": f"it has {drawn[one]}, so no capsule: give it collision "
        f"geometry in {shape.source.name}, or say why it needs none"
        for one in bare if one in drawn
    }  # fmt: skip
    return replace(draft, bare=why, open={**draft.open, **open_})


def _tool_steps(
    robot: RobotManifest, tree: DescriptionTree, draft: DraftRobot
) -> dict[str, tuple[float, float]]:
    """A quarter of what all joints at full speed do in half of all postures [m, rad]."""
    safety, period_s, found = robot.profile("sim"), draft.period_ms * 1e-3, {}
    for part in draft.parts:
        if part.moves_tool:
            speeds = {j.name: profile_limits(robot.joint(j.name), safety)[0] for j in part.joints}
            can = Reach(robot, tree).tool_speed(part.tool, list(speeds), speeds)
            most = (can.linear_m_s * period_s / 4.0, can.angular_rad_s * period_s / 4.0)
            found[part.name] = (min(_MOST_M, most[0]), min(_MOST_RAD, most[1]))
    return found


def _singularity_limits(robot: RobotManifest, home: Mapping[str, float]) -> dict[str, float]:
    """Half of what home has [m]; but where it is less, dampings of controllers matter too much."""
    return {
        part: round(min(_MOST_SINGULAR, max(_LEAST_SINGULAR, value / 2.0)), 3)
        for part, value in smallest_singular_values(robot, home).items()
    }


def _reach(
    robot: RobotManifest, tree: DescriptionTree, draft: DraftRobot, source: SourceModel | None
) -> tuple[Sequence[float], Sequence[float]]:
    """Corners of the box of all places of the tools, above the floor [m]."""
    columns = random_positions(robot, tree, SAMPLES)
    poses = link_poses(tree, columns)
    places = np.concatenate([poses[part.tool].translation for part in draft.parts])
    lower, upper = np.floor(places.min(axis=0) * 100), np.ceil(places.max(axis=0) * 100)
    upper = np.maximum(upper, lower + 1)
    floor_m = None if source is None else source.floor_m()
    if source is not None and floor_m is not None:
        data = mujoco.MjData(source.model)
        mujoco.mj_kinematics(source.model, data)
        base = mujoco.mj_name2id(source.model, mujoco.mjtObj.mjOBJ_BODY, draft.base_body)
        lower[2] = max(lower[2], np.ceil((floor_m - data.xpos[base, 2]) * 100))
    return [float(v) / 100 for v in lower], [float(v) / 100 for v in upper]


def _missing(robot: RobotManifest, folder: Path, source: SourceModel | None) -> Sequence[str]:
    if source is None:
        return ["there is no MJCF: hal_mujoco needs one with a <position> actuator for each joint"]
    return model_problems(robot, folder / f"{robot.id}.xml")
