"""Every attack by its name, and which robots it is for."""

from __future__ import annotations

import zlib

import numpy as np

from bench.soundness.arena import Arena
from bench.soundness.attack import Attack
from bench.soundness.base_cycles import BaseCycles
from bench.soundness.hunt import Hunter
from bench.soundness.wandering import FullScale, Switch, Wandering
from fairlead.errors import ConfigError, expected
from fairlead.robot.manifest import RobotManifest

WANDERING = ("random", "corner", "creep")
EVERY_ROBOT = (*WANDERING, "full-scale", "hunt")
SWITCHES: dict[str, Switch] = {"switch-up": "up", "switch-down": "down", "flicker": "flicker"}
ON_A_BASE = ("base-cycles", *SWITCHES)
TWO_ARMS = ("chase",)


def attacks_on(robot: RobotManifest) -> tuple[str, ...]:
    """The names of those that this robot has the parts and modes for."""
    found: tuple[str, ...] = EVERY_ROBOT
    if "composite" in robot.part_names:
        found += ON_A_BASE
    if sum(len(part.joints) >= 6 and part.end_effector is not None for part in robot.parts) > 1:
        found += TWO_ARMS
    return found


def make_attack(robot: RobotManifest, name: str, seed: int, arena: Arena) -> Attack:
    """One episode of it; name and seed decide every row that it asks for.

    Raises:
        ConfigError: naming the attacks on this robot.
    """
    if name not in attacks_on(robot):
        raise ConfigError(
            expected("soundness", f"an attack on {robot.id}", name, attacks_on(robot))
        )
    rng = np.random.default_rng([zlib.crc32(name.encode()), seed])
    if name in WANDERING:
        return Wandering(robot, rng, name)
    if name == "full-scale":
        return FullScale(robot, rng, "down")
    if name == "hunt":
        return Hunter(robot, rng, arena)
    if name == "base-cycles":
        return BaseCycles(robot, rng)
    if name == "chase":
        return _chase(robot, rng, arena)
    return FullScale(robot, rng, SWITCHES[name])


def _chase(robot: RobotManifest, rng: np.random.Generator, arena: Arena) -> Attack:
    """A claim for each arm and what is named like it."""
    sides = sorted({name.split("_")[0] for name in robot.part_names})
    claims = {side: tuple(n for n in robot.part_names if n.startswith(side)) for side in sides}
    return Hunter(robot, rng, arena, "self-collision", claims, int(rng.integers(1, 3)))
