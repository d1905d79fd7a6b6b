"""A HAL whose process was stopped and goes on: nothing that has expired acts any more."""

from __future__ import annotations

import os
import signal

import numpy as np

from fairlead_tools.conformance.row import Check, Row
from fairlead_tools.conformance.stage import Stage
from fairlead_tools.conformance.stand_in_gate import SAID_S

ROWS = 50
MOVING = 5
PAUSE_S = 0.5
AFTER_TICKS = 6
RESUME = Check(
    "resume after SIGSTOP", "no row of before the pause acts; states go on, new ones",
    "docs/time-and-pacing.md; shared/fairlead/hal/core.py",
    "let the host decide; read() measures anew each time; on hardware the robot's own watchdog",
)  # fmt: skip


def resume(stage: Stage, pid: int | None, why_not: str) -> Row:
    """Stop the process in motion, go on sending leases, let it go on."""
    if stage.lockstep:
        return RESUME.not_checked("in lockstep nothing expires: the world waits")
    if pid is None:
        return RESUME.not_checked(why_not)
    gate, states = stage.gate, stage.states
    sent = stage.begin(ROWS, MOVING)
    if isinstance(sent, str):
        return RESUME.row([sent], "")
    try:
        os.kill(pid, signal.SIGSTOP)
    except OSError as error:
        return RESUME.not_checked(f"process {pid} cannot be stopped: {error.strerror}")
    try:
        gate.pause(SAID_S)  # what was under way is there
        last = states.newest_tick
        gate.pause(PAUSE_S)
        waited = states.newest_tick == last
    finally:
        os.kill(pid, signal.SIGCONT)
    if not waited:
        gate.drop_claims()
        return RESUME.not_checked(
            f"ticks went on while process {pid} was stopped: it is not the HAL"
        )
    gate.wait_tick(last + AFTER_TICKS)
    # The tick of `last` may have been decided before the pause, or it was held afterwards.
    acted = [
        tick
        for tick in range(last + 1, states.newest_tick)
        if any(one.hold == 0 for one in states.acted(tick) or ())
    ]
    problems = [f"rows act in tick {acted[0]}, after the pause"] if acted else []
    problems += _goes_on(stage, last)
    gate.drop_claims()
    stage.settle()
    return RESUME.row(problems, f"held from tick {last + 1} on, after {PAUSE_S + SAID_S:g} s")


def _goes_on(stage: Stage, last: int) -> list[str]:
    """Old states that are told again as new ones."""
    heard = stage.states.between(last + 1, last + AFTER_TICKS + 1)
    before = stage.states.between(last - MOVING - 1, last + 1)
    for state in heard:
        for old in before[:-1]:
            moved = np.any(old.positions != before[-1].positions)
            if moved and np.array_equal(state.positions, old.positions):
                return [f"state {state.tick} is state {old.tick} again"]
    return []
