"""The MJCF file that a person has: which of it is the robot, and a copy with its meshes."""

from __future__ import annotations

import re
import shutil
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import mujoco
import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray

WHO = "robot new"
_ASSETS = "assets"
_TOOL = re.compile(r"tcp|tool|eef|end_?effector|ee_|grip|pinch|attachment|flange", re.I)
_TURN_RAD = 6.3  # where no hinge's range in degrees is beyond it, they were meant in rad
_LEVEL = 0.999999  # cosine of half a plane's tilt
_ONE_DOF = (mujoco.mjtJoint.mjJNT_HINGE, mujoco.mjtJoint.mjJNT_SLIDE)


@dataclass(frozen=True)
class SourceModel:
    """A compiled model and the part of it that is the robot: what hangs on ``base``.

    spec: the same as MuJoCo's editable form; bodies and joints without a name have got one.
    joints: numbers of the robot's joints, parents first.
    """

    path: Path
    spec: mujoco.MjSpec
    model: mujoco.MjModel
    base: int
    joints: tuple[int, ...]

    @cached_property
    def bodies(self) -> tuple[int, ...]:
        """The robot's bodies, the base first, parents before their children."""
        tops = {int(self.model.body_rootid[self.model.jnt_bodyid[j]]) for j in self.joints}
        own = (b for b in range(1, self.model.nbody) if int(self.model.body_rootid[b]) in tops)
        return tuple(dict.fromkeys([self.base, *own]))

    def joint_of(self, body: int) -> int | None:
        """The joint that moves a body on its parent, None where it is fixed."""
        return int(self.model.body_jntadr[body]) if self.model.body_jntnum[body] else None

    def actuators(self, joint: int) -> list[int]:
        """Numbers of the actuators that act on a joint by itself."""
        kind = mujoco.mjtTrn.mjTRN_JOINT
        model = self.model
        return [
            one
            for one in range(model.nu)
            if model.actuator_trntype[one] == kind and model.actuator_trnid[one, 0] == joint
        ]

    def tool_sites(self) -> dict[str, int]:
        """Sites of the robot that are called like a tool, by name and number."""
        model = self.model
        return {
            str(model.site(site).name): site
            for site in range(model.nsite)
            if int(model.site_bodyid[site]) in self.bodies and _TOOL.search(model.site(site).name)
        }

    def position(self, qpos: FloatArray, joints: tuple[str, ...]) -> float:
        """Where a joint stands: two of the model's are an opening, their difference."""
        first, *others = (
            float(qpos[self.model.jnt_qposadr[self.model.joint(name).id]]) for name in joints
        )
        return first - sum(others)

    def floor_m(self) -> float | None:
        """Height of the highest level plane of the world [m]."""
        model, plane = self.model, mujoco.mjtGeom.mjGEOM_PLANE
        level = [
            float(model.geom_pos[geom, 2])
            for geom in range(model.ngeom)
            if model.geom_type[geom] == plane and abs(model.geom_quat[geom, 0]) > _LEVEL
        ]
        return max(level, default=None)

    def rest(self) -> FloatArray:
        """The model's positions at its key ``home``, else its first key, else its own."""
        key = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_KEY, "home")
        if key < 0 and self.model.nkey:
            key = 0
        return np.array(self.model.qpos0 if key < 0 else self.model.key_qpos[key])

    def write(self, path: Path) -> None:
        """Write a copy, its meshes and textures in a folder beside it.

        Raises:
            ConfigError: a file is missing, or the copy is not the same model.
        """
        _copy_assets(self.spec, path.parent / _ASSETS)
        self.spec.meshdir = self.spec.texturedir = _ASSETS
        self.spec.modelfiledir = str(path.parent)
        try:
            path.write_text(self.spec.to_xml(), encoding="utf-8")
            copy = mujoco.MjModel.from_xml_path(str(path))
        except (ValueError, mujoco.FatalError) as error:
            raise ConfigError(f"{WHO}: a copy of {self.path}: {_one_line(error)}") from None
        ours, theirs = self.model, copy
        for what in ("body_pos", "body_quat", "jnt_axis", "jnt_range", "geom_size", "dof_damping",
                     "actuator_gainprm", "actuator_forcerange"):  # fmt: skip
            if not np.allclose(getattr(ours, what), getattr(theirs, what), atol=1e-6):
                raise ConfigError(f"{WHO}: {self.path}: MuJoCo writes another {what} than it read")


def _copy_assets(spec: mujoco.MjSpec, folder: Path) -> None:
    home = Path(spec.modelfiledir)
    for kind, items in (
        (spec.meshdir, [*spec.meshes, *spec.skins]),
        (spec.texturedir, [*spec.textures, *spec.hfields]),
    ):
        for item in items:
            if not item.file:
                continue
            found = home / kind / item.file
            if not found.is_file():
                raise ConfigError(f"{WHO}: {spec.modelname}: no file {found}")
            folder.mkdir(exist_ok=True)
            name = item.file.replace("/", "_").replace("..", "")
            shutil.copyfile(found, folder / name)
            item.file = name


def load_source(path: Path) -> SourceModel:
    """Read a person's MJCF file.

    Raises:
        ConfigError: it is no model, or not one of a robot that stands on a fixed base.
    """
    if not path.is_file():
        raise ConfigError(f"{WHO}: --mjcf: expected an MJCF file, got none at {path}")
    try:
        tag = ET.parse(path).getroot().tag  # noqa: S314 - the person's own file
    except (OSError, ET.ParseError, LookupError, ValueError) as error:
        raise ConfigError(f"{WHO}: --mjcf: {path}: cannot be read as XML: {error}") from None
    if tag != "mujoco":
        hint = ": give it as --urdf" if tag == "robot" else ""
        raise ConfigError(expected(f"{WHO}: --mjcf: {path}", "<mujoco>", f"<{tag}>{hint}"))
    try:
        spec = mujoco.MjSpec.from_file(str(path))
        _name_all(spec)
        _check_ranges(path, spec)
        model = spec.compile()
    except (ValueError, mujoco.FatalError) as error:
        raise ConfigError(f"{WHO}: {path}: {_one_line(error)}") from None
    return _with_robot(path, spec, model)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())


def _name_all(spec: mujoco.MjSpec) -> None:
    for kind, items in (("body", spec.bodies), ("joint", spec.joints)):
        taken = {one.name for one in items}
        for number, one in enumerate(items):
            if not one.name:
                one.name = next(n for i in range(len(taken) + 1)
                                if (n := f"{kind}_{number + i}") not in taken)  # fmt: skip
                taken.add(one.name)


def _check_ranges(path: Path, spec: mujoco.MjSpec) -> None:
    """MuJoCo takes a range that ends below its start for none at all."""
    for joint in spec.joints:
        low, high = (float(end) for end in joint.range)
        if not low <= high:
            who = f"{WHO}: {path}: joint {joint.name}: range"
            raise ConfigError(expected(who, "its lower end first", f"{low:g} {high:g}"))
    turning = [one for one in spec.joints if one.type == mujoco.mjtJoint.mjJNT_HINGE]
    limited = [one.range for one in turning if one.range[0] < one.range[1]]
    most = max((float(np.abs(one).max()) for one in limited), default=0.0)
    if spec.compiler.degree and len(limited) > 1 and most <= _TURN_RAD:
        what = 'degrees, for <compiler> has no angle="radian"'
        got = f"none beyond {most:g}: are these radians?"
        raise ConfigError(expected(f"{WHO}: {path}: ranges of the hinges", what, got))


def _with_robot(path: Path, spec: mujoco.MjSpec, model: mujoco.MjModel) -> SourceModel:
    driven = {int(model.actuator_trnid[a, 0]) for a in range(model.nu)
              if model.actuator_trntype[a] == mujoco.mjtTrn.mjTRN_JOINT}  # fmt: skip
    movable = {j for j in range(model.njnt) if model.jnt_type[j] in _ONE_DOF}
    roots = {int(model.body_rootid[model.jnt_bodyid[j]]) for j in (driven & movable) or movable}
    if not roots:
        raise ConfigError(f"{WHO}: {path}: expected a robot with hinge or slide joints, got none")
    joints = [j for j in range(model.njnt) if int(model.body_rootid[model.jnt_bodyid[j]]) in roots]
    for joint in joints:
        body = model.body(int(model.jnt_bodyid[joint]))
        name = f"{WHO}: {path}: joint {model.joint(joint).name!r} of body {body.name!r}"
        if joint not in movable:
            kind = mujoco.mjtJoint(model.jnt_type[joint]).name.removeprefix("mjJNT_").lower()
            what = "a hinge or a slide: a robot stands on a fixed base"
            raise ConfigError(expected(name, what, f"one of type {kind}"))
        if body.jntnum[0] != 1:
            raise ConfigError(
                expected(name, "one joint a body", f"{body.jntnum[0]}; nest a body for each")
            )
    [top, *more] = roots
    base = 0 if more or model.body_jntnum[top] else top
    return SourceModel(path, spec, model, base, tuple(joints))
