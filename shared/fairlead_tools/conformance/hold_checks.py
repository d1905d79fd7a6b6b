"""Every way in which motion has to end, and that what is held stays where it is."""

from __future__ import annotations

import time
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fairlead.hal.lease_follower import LEASE_LIFE_NS
from fairlead.messages import Hold, StopLevel
from fairlead_tools.conformance.guard_checks import HOST, ROWS
from fairlead_tools.conformance.heard_states import Heard
from fairlead_tools.conformance.row import Check, Row
from fairlead_tools.conformance.stage import TRIES, Stage, hold_name
from fairlead_tools.conformance.stand_in_gate import SAID_S

MOVING = 6
"""Rows that act before motion is to end."""
LONG_ROWS = 40
REPEAT_S = 0.25
SLACK_MS = 5.0
LEAST_REPEATS = 2
LEAST_DRIFT_TICKS = 30
CREEP_S = 1.0
"""For so long a servo that counts as still may creep to its setpoint."""
LIFE_MS = LEASE_LIFE_NS / 1e6
LAW = "hold by the part's law when apply() gets no command for it (docs/hal.md: holding)"
ROWS_END = Check(
    "holds when rows end",
    "a hold, and standstill",
    "robot.yaml: stop_ramp_ms, standstill_per_s",
    LAW,
)
LEASES_END = Check(
    "holds when leases stop",
    "a hold, and standstill",
    "docs/design.md: lease; robot.yaml: stop_ramp_ms",
    LAW,
)
STOP = Check(
    "holds on a stop",
    "a hold, and standstill",
    "docs/design.md: stop; robot.yaml: stop_ramp_ms",
    LAW,
)
STOP_TOLD = Check(
    "a stop is repeated", "every 50 ms until a lease lists it; status says holding",
    "docs/time-and-pacing.md: lost messages", HOST,
)  # fmt: skip
STOP_STAYS = Check(
    "a stop stays", "until the gate that listed it lists it no longer, and is then forgotten",
    "docs/time-and-pacing.md: lost messages", HOST,
)  # fmt: skip
DRIFT = Check(
    "a hold does not drift", "every joint where it stood",
    "robot.yaml: dead_band_per_tick, encoder_step, standstill_per_s",
    "keep one setpoint; never anchor a hold to the measured position again",
)  # fmt: skip


def rows_end(stage: Stage) -> Row:
    """Leases go on, rows do not."""
    check = replace(ROWS_END, expected=f"held in the next tick, still within {_ramp(stage)}")
    run = stage.execute(stage.moving_rows(MOVING))
    if not run.acted_all:
        return check.row([f"never moved: {run.story}"], "")
    return check.row(*_comes_to_rest(stage, run.sent.end, "in the tick after the last row"))


def _ramp(stage: Stage) -> str:
    return f"{stage.profile.protocol.stop_ramp_ms} ms"


def _comes_to_rest(stage: Stage, held: int, when: str) -> tuple[list[str], str]:
    """Whether everything holds from a tick on, and stands still in time."""
    stage.reaches(held + 2)
    told = stage.states.acted(held)
    names = stage.robot.part_names
    acting = [] if told is None else [n for n, a in zip(names, told, strict=True) if a.hold == 0]
    problems = [f"{', '.join(acting)} still acts {when}"] if acting else []
    still = stage.first_still(held + 1, stage.stop_ticks)
    if still is None:
        now = stage.states.newest
        before = stage.states.last_until(now.tick - 1)
        past_s = stage.period_s * (now.tick - before.tick)
        speeds = np.maximum(
            np.abs(now.velocities), np.abs(now.positions - before.positions) / past_s
        )
        shares = np.where(np.isin(range(len(speeds)), stage.watched), speeds / stage.standstill, 0)
        worst = int(np.argmax(shares))
        name = stage.robot.measured_joint_names[worst]
        problems.append(
            f"{name} still moves at {speeds[worst]:.3g}/s after {_ramp(stage)} "
            f"(still: {stage.standstill[worst]:g})"
        )
        return problems, ""
    told_holds = {hold_name(one.hold) for one in told or ()}
    took_ms = (still - held) * stage.period_s * 1e3
    return problems, f"{', '.join(sorted(told_holds))}; still after {took_ms:.0f} ms"


def leases_end(stage: Stage) -> Row:
    """Rows go on, leases do not. What the machine is late meanwhile is allowed for."""
    bound_ms = LIFE_MS + stage.period_s * 1e3
    expected = f"held within {bound_ms:g} ms of the last, still within {_ramp(stage)} then"
    if stage.lockstep:
        expected = "no tick is stepped without a lease of its own"
    check = replace(LEASES_END, expected=expected)
    for _ in range(TRIES):
        sent = stage.begin(LONG_ROWS, MOVING)
        if isinstance(sent, str):
            return check.row([sent], "")
        if stage.lockstep:
            return _world_waits(stage, check)
        last_ns = stage.gate.silence()
        begun = stage.states.newest_tick
        stage.reaches(begun + 4 + int(bound_ms / (stage.period_s * 1e3)))
        found = _held_in_time(stage, begun, last_ns, bound_ms, Hold.LEASE_STALE)
        stage.gate.speak()
        stage.gate.drop_claims()
        if not found.otherwise:
            break
    return check.row(found.problems, found.got)


@dataclass(frozen=True)
class Held:
    """How motion ended. otherwise: for another reason: where that is a busy machine's, once."""

    problems: list[str]
    got: str
    otherwise: bool = False


def _held_in_time(stage: Stage, begun: int, since_ns: int, bound_ms: float, why: Hold) -> Held:
    """Problems, and what to say without: the first held tick from ``begun`` on, and rest."""
    states = stage.states
    held = next((tick for tick in range(begun, states.newest_tick) if _holds(stage, tick)), 0)
    if not held:
        return Held([f"rows still act {states.newest_tick - begun} ticks on"], "")
    took_ms = (states.by_tick[held].came_ns - since_ns) / 1e6
    late_ms = max(1e3 * stage.control.since(since_ns).most_s, _longest_ms(stage, begun, held + 1))
    told = {one.hold for one in states.acted(held) or ()}
    problems, got = _comes_to_rest(stage, held, f"{held - begun} ticks on")
    if took_ms > bound_ms + late_ms + SLACK_MS:
        problems.append(f"held after {took_ms:.0f} ms")
    if why not in told:
        problems.append(f"{', '.join(sorted(map(hold_name, told)))}, not {hold_name(why)}")
    return Held(problems, f"held after {took_ms:.0f} ms; {got}", why not in told)


def _longest_ms(stage: Stage, first: int, stop: int) -> float:
    """By how much the longest of these ticks was longer than a period."""
    came = [one.came_ns for one in stage.states.between(first, stop)]
    return float(max(np.diff(came), default=0)) / 1e6 - stage.period_s * 1e3


def _holds(stage: Stage, tick: int) -> bool:
    told = stage.states.acted(tick)
    return told is not None and all(one.hold for one in told)


def _world_waits(stage: Stage, check: Check) -> Row:
    stage.gate.silence()
    stage.gate.pause(REPEAT_S)
    before = stage.states.newest_tick
    stage.gate.pause(REPEAT_S)
    after = stage.states.newest_tick
    stage.gate.speak()
    stage.gate.drop_claims()
    problem = [f"went from tick {before} to {after}"] if after > before else []
    return check.row(problem, f"waits at tick {before}")


def stops(stage: Stage) -> Iterator[Row]:
    """A stop in motion, and all that may not end it."""
    bound_ms = 2.0 * stage.period_s * 1e3
    expected = f"held within {bound_ms:g} ms, still within {_ramp(stage)} then"
    check = replace(STOP, expected=expected)
    for _ in range(TRIES):
        if stage.gate.heard_stops:
            stage.gate.clear_stops()
        sent = stage.begin(LONG_ROWS, MOVING)
        if isinstance(sent, str):
            yield check.row([sent], "")
            return
        begun, since_ns = stage.states.newest_tick, time.monotonic_ns()
        stop = stage.gate.raise_stop("fairlead hal check: does it hold?")
        stage.reaches(begun + 5)
        found = _held_in_time(stage, begun, since_ns, bound_ms, Hold.STOPPED)
        if not found.otherwise:
            break
    yield check.row(found.problems, found.got)
    yield _told(stage, stop.stop_id)
    yield STOP_STAYS.row(list(_ended_too_soon(stage, stop)), "held until then, moves again")


def _told(stage: Stage, stop_id: int) -> Row:
    gate = stage.gate
    before = len(gate.stop_times_ns.get(stop_id, ()))
    gate.pause(REPEAT_S)
    count = len(gate.stop_times_ns.get(stop_id, ())) - before
    state = gate.hal_state()
    got = f"{count} times within {1e3 * REPEAT_S:g} ms"
    problems = [] if count >= LEAST_REPEATS else [got]
    if state != "holding":
        problems.append(f"status says {state}")
    return STOP_TOLD.row(problems, f"{got}; {state}")


def _ended_too_soon(stage: Stage, stop: StopLevel) -> Iterator[str]:
    """What let go of a stop that was held, or kept hold of one that was reset."""
    gate = stage.gate
    for what in ("the same epoch without it", "a new epoch that never listed it"):
        if _act(stage):
            yield f"rows act again under {what}"
        gate.arm()
    gate.clear_stops()
    if not stage.execute(stage.moving_rows(ROWS)).acted_all:
        yield "still held though the gate lists it no longer"
    gate.send_stop(stop)
    gate.pause(SAID_S)
    if not stage.execute(stage.moving_rows(ROWS)).acted_all:
        yield "a late copy of it, after its reset, stops again"
    gate.clear_stops()


def _act(stage: Stage) -> bool:
    """Whether good rows act."""
    gate, states = stage.gate, stage.states
    gate.take_claim(waits=True)
    sent = gate.release(stage.moving_rows(ROWS)(stage.moment(states.newest_tick)))
    stage.reaches(sent.end + 1)
    found = any(
        one.hold == 0 for tick in range(sent.first, sent.end) for one in states.acted(tick) or ()
    )
    gate.drop_claims()
    return found


def drift(stage: Stage, seconds: float) -> tuple[Row, list[Heard]]:
    """Nothing commanded for a while, and the states of that time."""
    gate, states = stage.gate, stage.states
    ticks = max(LEAST_DRIFT_TICKS, int(seconds / stage.period_s))
    check = replace(DRIFT, expected=f"every joint where it stood, for {ticks * stage.period_s:g} s")
    gate.take_claim()
    stage.settle()
    gate.wait_tick(states.newest_tick + min(stage.stop_ticks, int(CREEP_S / stage.period_s)))
    start = states.newest_tick
    gate.wait_tick(start + ticks)
    gate.drop_claims()
    heard = states.between(start, start + ticks + 1)
    problems = stage.strayed(heard[0], heard)
    away = np.max([np.abs(one.positions - heard[0].positions) for one in heard], axis=0)
    worst = int(np.argmax(away / np.maximum(stage.drift_bound(), 1e-12)))
    joint = stage.robot.joint(stage.robot.measured_joint_names[worst])
    bound = stage.drift_bound()[worst]
    got = f"most {joint.name}: {away[worst]:.3g} {joint.unit} (at most {bound:.3g})"
    return check.row(problems, got), heard
