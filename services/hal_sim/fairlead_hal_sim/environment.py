"""Making a robosuite environment so that a seed alone decides every bit of an episode."""

from __future__ import annotations

import importlib
import inspect
from pathlib import Path
from typing import Any

import numpy as np

import fairlead_hal_sim.task  # noqa: F401  # registers MobilePickPlace
from fairlead.errors import ConfigError, expected
from fairlead_hal_sim.options import SimulatorOptions
from fairlead_hal_sim.quiet_robosuite import robosuite


def make_environment(options: SimulatorOptions, control_hz: float, *, offscreen: bool) -> Any:
    """A robosuite environment by registered names; ``offscreen`` is for rendering only.

    Raises:
        ConfigError: for an unknown environment, robot, controller, part or option, with the valid
            names, for a module that cannot be imported, and for whatever else the environment
            refuses, in its own words.
    """
    for module in options.imports:
        _import(module)
    _check_name("environment", options.env, robosuite.environments.REGISTERED_ENVS)
    _check_name("robot", options.robot, robosuite.robots.ROBOT_CLASS_MAPPING)
    config = _controller_config(options)
    own: dict[str, Any] = {
        "robots": options.robot,
        "controller_configs": config,
        "seed": options.seed,
        "control_freq": control_hz,
        "has_renderer": False,
        "has_offscreen_renderer": offscreen,
        "use_camera_obs": False,
        "renderer": "mujoco",
        "ignore_done": True,  # episodes end by goal, not by the environment's horizon
        "hard_reset": False,  # True would draw a second scene at the first reset
        "initialization_noise": None,  # "default" would draw joint noise at every reset
    }
    _check_options(options, own)
    try:
        return robosuite.make(options.env, **own, **options.env_options)
    except (AssertionError, AttributeError, KeyError, TypeError, ValueError) as error:
        raise ConfigError(
            f"hal_sim: environment {options.env} with robot {options.robot} and env_options "
            f"{options.env_options} cannot be made: {type(error).__name__}: {error}"
        ) from None


def seed_environment(env: Any, seed: int) -> None:
    """Put ``env.rng`` where a fresh generator of ``seed`` starts.

    In place, because placement samplers keep a reference to the generator.
    """
    env.rng.bit_generator.state = np.random.default_rng(seed).bit_generator.state


def leave_out_observations(env: Any) -> None:
    """Take from ``env.step`` the observations that it computes beside the motion.

    A HAL publishes what it reads of the simulator's state; the motion is the same to the bit.
    """
    for name in env.observation_names:
        env.modify_observable(name, "enabled", False)


def _controller_config(options: SimulatorOptions) -> dict[str, Any]:
    name = options.controller
    if name is not None and not name.endswith(".json"):
        known = robosuite.controllers.composite.composite_controller
        _check_name("controller", name, known.REGISTERED_COMPOSITE_CONTROLLERS_DICT)
    elif name is not None and not Path(name).exists():
        raise ConfigError(expected("hal_sim", "an existing controller file", repr(name)))
    config: dict[str, Any] = robosuite.load_composite_controller_config(
        controller=name, robot=options.robot
    )
    if options.part_order is not None:
        _check_order(options, config)
        specific = config.setdefault("composite_controller_specific_configs", {})
        specific["body_part_ordering"] = list(options.part_order)
    return config


def _check_order(options: SimulatorOptions, config: dict[str, Any]) -> None:
    """Every part of the robot exactly once; an arm's gripper is a part of its own."""
    parts: dict[str, dict[str, Any]] = config["body_parts"]
    grippers = [f"{name}_gripper" for name, part in parts.items() if part.get("gripper")]
    known, told = sorted([*parts, *grippers]), list(options.part_order or ())
    if sorted(told) != known:
        who = f"hal_sim: part_order of robot {options.robot}"
        raise ConfigError(expected(who, f"each of {', '.join(known)} once", told))


def _check_options(options: SimulatorOptions, own: dict[str, Any]) -> None:
    made = robosuite.environments.REGISTERED_ENVS[options.env]
    known = {
        name
        for kind in made.__mro__
        for name, parameter in inspect.signature(kind.__init__).parameters.items()
        if parameter.kind not in (parameter.VAR_KEYWORD, parameter.VAR_POSITIONAL)
    }
    valid = sorted(known - own.keys() - {"self", "args", "kwargs"})
    for key in options.env_options:
        if key not in valid:
            who = f"hal_sim: env_options of environment {options.env}"
            why = f"{key!r}, which hal_sim sets" if key in own else repr(key)
            raise ConfigError(expected(who, "an option", why, valid))


def _import(module: str) -> None:
    try:
        importlib.import_module(module)
    except ImportError as error:
        raise ConfigError(
            expected("hal_sim", "a module that registers environments", f"{module!r}: {error}")
        ) from None


def _check_name(what: str, name: str, registered: Any) -> None:
    if name not in registered:
        raise ConfigError(
            expected("hal_sim", f"a registered {what}", repr(name), sorted(registered))
        )


def gripper_names() -> list[str]:
    """Grippers that robosuite's arms can wear."""
    return sorted(filter(None, robosuite.models.grippers.GRIPPER_MAPPING))
