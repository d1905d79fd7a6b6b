"""Making a robosuite environment so that a seed alone decides every bit of an episode."""

from __future__ import annotations

import importlib
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
        ConfigError: for an unknown environment, robot or controller, with the valid names,
            and for a module that cannot be imported.
    """
    for module in options.imports:
        _import(module)
    _check_name("environment", options.env, robosuite.environments.REGISTERED_ENVS)
    _check_name("robot", options.robot, robosuite.robots.ROBOT_CLASS_MAPPING)
    return robosuite.make(
        options.env,
        robots=options.robot,
        controller_configs=_controller_config(options),
        seed=options.seed,
        control_freq=control_hz,
        has_renderer=False,
        has_offscreen_renderer=offscreen,
        use_camera_obs=False,
        renderer="mujoco",
        ignore_done=True,  # episodes end by goal, not by the environment's horizon
        hard_reset=False,  # True would draw a second scene at the first reset
        initialization_noise=None,  # "default" would draw joint noise at every reset
        **options.env_options,
    )


def seed_environment(env: Any, seed: int) -> None:
    """Put ``env.rng`` where a fresh generator of ``seed`` starts.

    In place, because placement samplers keep a reference to the generator.
    """
    env.rng.bit_generator.state = np.random.default_rng(seed).bit_generator.state


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
        specific = config.setdefault("composite_controller_specific_configs", {})
        specific["body_part_ordering"] = list(options.part_order)
    return config


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
