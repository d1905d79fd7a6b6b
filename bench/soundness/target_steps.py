"""How fast joints become when their targets go to and fro, by the size of the targets' steps.

    .venv/bin/python -m bench.soundness.target_steps panda arm 0.109 0.087 0.065 0.055

Drives one part of a simulated robot by joint targets, without gate and processes: random corners
and directions of full scale that last 1 to 12 rows, reversed or new, with held ticks between; a
first row after a hold is further from what is measured by the joint's tolerance, as G021 admits.
An episode ends where the robot touches something. Prints for each step [rad per period] the most
that any joint was faster than its velocity limit, in how many ticks, and how far it lagged behind.
"""

from __future__ import annotations

import argparse
from dataclasses import dataclass

import numpy as np

from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_tools.measure.driven_robot import DrivenRobot
from fairlead_tools.measure.drives import wish_of
from fairlead_tools.measure.rows import FullScaleRows

EPISODE_TICKS = 80
HOLDS = (0.0, 0.1, 0.3, 0.5)
"""Share of the ticks that are held, by episode."""
LONGEST = 12
TURNS_BACK = 0.4


@dataclass
class Fastest:
    """ticks: driven in free space. over: those with a joint above its limit.

    excess: the most that any was [rad/s]. lag: of a joint behind its target [rad].
    """

    ticks: int = 0
    over: int = 0
    excess: float = -np.inf
    lag: float = 0.0


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.soundness.target_steps",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("robot", choices=("panda", "dual_panda"))
    parser.add_argument("part")
    parser.add_argument("steps", type=float, nargs="+")
    parser.add_argument("--ticks", type=int, default=24_000)
    arguments = parser.parse_args()
    driven = DrivenRobot(arguments.robot)
    for step in arguments.steps:
        found = fastest(driven, arguments.part, step, arguments.ticks)
        print(
            f"{step:g} rad: {found.over} of {found.ticks} ticks above a limit, "
            f"fastest {found.excess:+.2f} rad/s of it; lag {found.lag:.2f} rad",
            flush=True,
        )


def fastest(driven: DrivenRobot, part: str, step: float, ticks: int) -> Fastest:
    """So many ticks of targets that go on by up to ``step`` [rad]."""
    rng, found = np.random.default_rng(0), Fastest()
    for seed in range(ticks // EPISODE_TICKS):
        _episode(
            driven,
            FullScaleRows(driven.robot, part, ControlMode.JOINT_POSITION).with_steps(step),
            seed,
            rng,
            found,
        )
    return found


def _episode(
    driven: DrivenRobot, rows: FullScaleRows, seed: int, rng: np.random.Generator, found: Fastest
) -> None:
    own = driven.indices(rows.part)
    limits = np.array([driven.robot.joints[joint].velocity_limit for joint in own])
    now, lasts = driven.reset(seed), int(rng.integers(1, LONGEST + 1))
    held, wish = float(rng.choice(HOLDS)), wish_of(rng, rows.axes)
    for tick in range(EPISODE_TICKS):
        if tick % lasts == 0:
            wish = -wish if rng.random() < TURNS_BACK else wish_of(rng, rows.axes)
        is_held = rng.random() < held
        commands = {} if is_held else {rows.part: rows.row(wish, now)}
        if is_held:
            rows.go_on_after(None)
        done = driven.step("targets", now, commands)
        if not done.is_free:
            return
        now = done.after
        beyond: FloatArray = np.abs(now.velocities[own]) - limits
        found.ticks, found.over = found.ticks + 1, found.over + bool(beyond.max() > 0.0)
        found.excess = max(found.excess, float(beyond.max()))
        for command in commands.values():
            lag = np.abs(command.values[own] - now.positions[own]).max()
            found.lag = max(found.lag, float(lag))


if __name__ == "__main__":
    main()
