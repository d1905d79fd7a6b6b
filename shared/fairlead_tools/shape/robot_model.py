"""A compiled model of a robot beside its description: an MJCF file, or a robot of robosuite."""

from __future__ import annotations

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
    return RobotModel(robot, str(path), rest, model, data, who)


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
