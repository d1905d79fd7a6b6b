"""Measured states of an armed robot, some of them impossible: who stops, when, and for what."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, Measured, Pacing, PartRows, still
from bench.equipment.core_gate import CoreGate
from tests.differential.gate_file import GateFile
from tests.differential.gates import Pair
from tests.differential.reference import open_tick
from tests.differential.state_judge import ANOTHER_HAL, StateJudge
from tests.differential.states import StateMaker, nudged

pytestmark = pytest.mark.processes

SEED = 815
RUNS = 120
LONG_RUNS = 10_000
STATES = 6
PACINGS: tuple[Pacing, ...] = ("lockstep", "realtime")
GAPS_MS = (1, 20, 50, 50, 50, 51, 99, 100, 101, 125, 150, 250, 251)
NO_MEASURE = (np.nan, np.inf, -np.inf)


def odd(file: GateFile, last: Measured, state: Measured, rng: np.random.Generator) -> Measured:
    """The state with something in it that may not be, or only just may be."""
    kind = int(rng.integers(6))
    if kind == 0:
        ticks = int(rng.choice([0, 1, 2, 3, 4, 7, 1000]))
        return replace(state, tick=max(1, last.tick + ticks))
    if kind == 1:
        return replace(state, tick=max(1, last.tick - int(rng.integers(1, 4))))
    name = str(rng.choice(["positions", "velocities", "efforts"]))
    values = getattr(state, name).copy()
    joint = int(rng.integers(len(values)))
    if kind == 2:
        values[joint] = rng.choice(NO_MEASURE)
        return replace(state, **{name: values})
    if kind == 3:
        return replace(state, **{name: values[:-1] if rng.random() < 0.5 else np.r_[values, 0.0]})
    limits = [j.jump_limit for j in (*file.joints, *file.passive)]
    positions = state.positions.copy()
    sign, limit = rng.choice([-1.0, 1.0]), limits[joint] * (state.tick - last.tick)
    edge = last.positions[joint] + sign * limit * rng.choice([1.0, 1.0, 1.4])
    positions[joint] = nudged(float(edge), rng)
    return replace(state, positions=positions)


def told(core: CoreGate) -> tuple[int, str]:
    """Code and joint of the stop, as the gate's status says in words."""
    if "two HALs publish" in core.status().cause:
        return ANOTHER_HAL
    found = re.search(r"G0(\d\d) (\S[^:]*):", core.status().cause)
    assert found is not None, core.status().cause
    return int(found[1]), found[2]


def hold_still(file: GateFile, measured: Measured, tick: int) -> Chunk | None:
    """A row that any state allows, if the robot has a part that takes one."""
    for index, part in enumerate(file.parts):
        if 5 in part.modes and not any(
            file.joints[j].is_outside(measured.positions[j]) for j in part.joints
        ):
            frame = part.modes[5]["frames"][0]
            return Chunk(tick, 1, (PartRows(index, 5, np.zeros((1, 6)), frame),))
    return None


def begun_with(last: Measured) -> tuple[Measured, None]:
    """The state that `CoreGate.start` sends: nothing has acted, nothing moves."""
    return still(last.tick, last.positions), None


def disagreement(pair: Pair, seed: int, codes: Counter[int]) -> str:
    """One armed run; in words the first state on which the two judges differ."""
    rng = np.random.default_rng(seed)
    pacing = PACINGS[seed % 2]
    maker = StateMaker(pair.file, rng)
    core, period_ns = pair.core, int(pair.core.file["period_ns"])
    timeout_ns = pair.file.protocol["state_timeout_ms"] * 1_000_000
    last = maker.draw(int(rng.integers(1, 200)))
    core.start(pacing, still(last.tick, last.positions))
    core.claim(Case(pair.robot, pacing, last, Chunk(last.tick, 1, ())))
    judge = StateJudge(pair.file, pacing, period_ns, timeout_ns, begun_with(last))
    judge.arrivals.append((last.tick, core.now_ns))
    acted = None
    if rng.random() < 0.5:
        start = open_tick(pacing, last.tick)
        chunk = hold_still(pair.file, last, start)
        if chunk is not None and pacing == "lockstep":
            answer = core.send(chunk, last.tick)
            case = Case(pair.robot, pacing, last, chunk)
            acted = core.acted(case, answer) if answer.safe else None
    for _ in range(STATES):
        state = maker.next(last)
        if rng.random() < 0.4:
            state = odd(pair.file, last, state, rng)
        gap_ns = int(rng.choice(GAPS_MS)) * 1_000_000
        if acted is not None:
            state, judge.is_moving = replace(state, tick=last.tick + 1), True
        got = core.state_reply(state, acted, gap_ns)
        expected = judge.on_state(state, acted, core.now_ns)
        acted, found = None, told(core) if got.stopped else (0, "")
        codes[expected[0]] += 1
        if found != expected:
            return (
                f"seed {seed}, {pacing}: reference {expected}, gate {found} on {state} "
                f"{gap_ns / 1e6:g} ms after {last}, moving: {judge.is_moving}"
            )
        if got.stopped:
            break
        if judge.last is not None:
            last = judge.last
    return ""


@pytest.mark.parametrize(
    "runs", [RUNS, pytest.param(LONG_RUNS, marks=[pytest.mark.soak, pytest.mark.timeout(3600)])]
)
def test_gate_and_reference_stop_at_the_same_state_for_the_same_joint(
    pair: Pair, runs: int
) -> None:
    codes: Counter[int] = Counter()
    for seed in range(SEED, SEED + runs):
        found = disagreement(pair, seed, codes)
        assert not found, found
    assert min(codes[code] for code in (0, 11, 13)) >= 5, codes
    assert codes[2] > 0
