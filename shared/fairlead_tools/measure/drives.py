"""The drives: who is told what, tick by tick."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from fairlead.errors import ConfigError
from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_tools.measure.driven_robot import DrivenRobot, Moment, Tick
from fairlead_tools.measure.rows import MEASURED_MODES, FullScaleRows

SEED = 7
EPISODE_TICKS = 80
STRETCH_TICKS = 12
KEEP_TICKS = (1, 2, 5, 15)
"""How long a random wish lasts: flicker, and long enough to reach full speed."""


def modes_of(driven: DrivenRobot) -> list[tuple[str, ControlMode]]:
    """Every part and mode that moves something with a tracking model."""
    return [
        (part.name, mode)
        for part in driven.robot.parts
        for mode in driven.modes[part.name]
        if mode in MEASURED_MODES
    ]


def axes(driven: DrivenRobot, part: str, mode: ControlMode, share: float = 1.0) -> Iterator[Tick]:
    """Each axis alone from rest: full scale, or a share of it, to and fro, then told to stand."""
    rows = FullScaleRows(driven.robot, part, mode, profile=driven.profile)
    for axis in range(rows.axes):
        now = driven.reset(axis)
        rows.go_on_after(None)
        for sign in (1.0, -1.0, 0.0, -1.0, 1.0, 0.0):
            wish = np.zeros(rows.axes)
            wish[axis] = sign * share
            for _ in range(STRETCH_TICKS):
                tick = driven.step("axes", now, {part: rows.row(wish, now)})
                yield tick
                now = tick.after


def alone(driven: DrivenRobot, part: str, mode: ControlMode, ticks: int) -> Iterator[Tick]:
    """One part at full scale in random directions, the others hold."""
    yield from _random("alone", driven, _rows(driven, part, mode), ticks)


def _rows(driven: DrivenRobot, part: str, mode: ControlMode) -> dict[str, FullScaleRows]:
    return {part: FullScaleRows(driven.robot, part, mode, profile=driven.profile)}


def together(driven: DrivenRobot, ticks: int, shift: int = 0, seed: int = SEED) -> Iterator[Tick]:
    """All parts at full scale in random directions, each in one of its modes at a time."""
    rows = {
        part: FullScaleRows(driven.robot, part, modes[shift % len(modes)], profile=driven.profile)
        for part, modes in driven.modes.items()
        if modes
    }
    yield from _random("together", driven, rows, ticks, seed)


def _random(
    kind: str,
    driven: DrivenRobot,
    rows: dict[str, FullScaleRows],
    ticks: int,
    seed: int = SEED,
) -> Iterator[Tick]:
    rng = np.random.default_rng(seed)
    now = driven.reset(seed)
    wishes: dict[str, FloatArray] = {}
    keep = 1
    for count in range(ticks):
        if count % EPISODE_TICKS == 0:
            now = driven.reset(seed + count // EPISODE_TICKS)
            keep = KEEP_TICKS[(seed + count // EPISODE_TICKS) % len(KEEP_TICKS)]
            for one in rows.values():
                one.go_on_after(None)
        if count % keep == 0:
            wishes = {part: wish_of(rng, one.axes) for part, one in rows.items()}
        tick = _step(kind, driven, rows, wishes, now)
        yield tick
        now = tick.after


def wish_of(rng: np.random.Generator, axes: int) -> FloatArray:
    """A corner of full scale, or any direction to its edge."""
    if rng.random() < 0.5:
        return np.asarray(np.where(rng.random(axes) < 0.5, -1.0, 1.0))
    wish = rng.uniform(-1.0, 1.0, axes)
    return np.asarray(wish / np.abs(wish).max())


def _step(
    kind: str,
    driven: DrivenRobot,
    rows: dict[str, FullScaleRows],
    wishes: dict[str, FloatArray],
    now: Moment,
) -> Tick:
    """A twist beyond what the base's joints can do is refused by the HAL: half of it, then."""
    for share in (1.0, 0.6, 0.3):
        commands: dict[str, PartCommand] = {
            part: one.row(wishes[part] * share, now) for part, one in rows.items()
        }
        try:
            return driven.step(kind, now, commands)
        except ConfigError:
            for one in rows.values():
                if one.mode is ControlMode.BODY_TWIST:
                    one.go_on_after(None)
    return driven.step(kind, now, {})
