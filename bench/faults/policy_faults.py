"""Policy servers that are slow, hang, drop the connection, answer late, or answer garbage."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from itertools import pairwise

from bench.equipment.live_robot import MOVING_TICKS, wait_for
from bench.equipment.motion_log import MotionLine
from bench.equipment.turning import BASE
from bench.faults.live_stage import TICK_S
from bench.faults.motion_rules import every_row_was_judged_for_its_tick
from bench.faults.policy_server import (
    ANSWER_TIMEOUT_S,
    DROP,
    GARBAGE,
    GOOD,
    HANG,
    LATE,
    LATE_ANSWER,
    SLOW,
    SLOWER,
    SPEED,
)  # fmt: skip
from bench.faults.policy_stage import PolicyStage
from bench.faults.row import MachineLateError, Row, Shot
from fairlead.messages import Hold

FULL_SPEED = 1.5
"""What a policy's 1 means [rad/s]."""
HOLDS_WANTED = 4
BEFORE_NS = 150_000_000
"""Back from the fault to a tick in which a row acted for certain."""
TOLERANCE = 1.01
TICK_MS = TICK_S * 1e3
SAYS = {
    HANG: f"within {ANSWER_TIMEOUT_S:g} s",
    LATE: f"within {ANSWER_TIMEOUT_S:g} s",
    DROP: "closed the connection",
    GARBAGE: "answered no message",
}
"""In the typed error's text."""
AT_ONCE = {DROP, GARBAGE}
"""The error comes while rows are left; they end with the claim."""


def slow(robot: PolicyStage) -> Shot:
    """Holds between chunks, says so, and goes on with the next answer."""
    goal = robot.start_moving()
    injected_ns = robot.server.behave(SLOW)
    wait_for(
        lambda: goal.done() or len(_row_ends(robot.motion.since(injected_ns))) >= HOLDS_WANTED,
        "rows run out again and again",
    )
    lines = robot.motion.since(injected_ns)
    assert not goal.done(), goal.result()
    robot.server.behave(GOOD)
    robot.client.disarm()
    progress = goal.result(timeout=60.0)
    assert progress.starved > 0, progress
    held = {Hold(line.holds[BASE]) for line in lines} - {Hold.NONE}
    if held != {Hold.NO_ROW}:
        raise MachineLateError(f"held for {held}")
    _no_jump(robot, lines)
    return _shot(robot, lines, injected_ns, f"{progress.starved} ticks starved")


def fails(behaviour: str, robot: PolicyStage) -> Shot:
    """The goal ends with a typed error; the next one runs, and no late answer is ever used."""
    goal = robot.start_moving()
    injected_ns = robot.server.when(behaviour, robot.server.behave(behaviour))
    progress = goal.result(timeout=60.0)
    result = progress.result
    assert result is not None and result.kind == "policy_error", result
    assert SAYS[behaviour] in result.detail, result
    assert progress.starved > 0 or behaviour in AT_ONCE, progress
    robot.motion_ended(injected_ns)
    lines = robot.motion.since(injected_ns - BEFORE_NS)
    shot = _shot(robot, lines, injected_ns, f"{progress.starved} ticks starved")
    _no_jump(robot, lines)
    if behaviour == LATE:
        robot.server.when(LATE_ANSWER, injected_ns)
    robot.server.behave(GOOD)
    again = robot.start_moving()
    moving = robot.motion.read()[-MOVING_TICKS:]
    robot.finish(again)
    _no_jump(robot, moving)
    assert not _verdicts(moving) & _verdicts(lines), "rows from before the fault acted"
    return shot


def _row_ends(lines: Sequence[MotionLine]) -> list[tuple[MotionLine, MotionLine]]:
    """Each last tick with a row, and the tick after it."""
    return [(a, b) for a, b in pairwise(lines) if a.moves and not b.moves]


def _shot(robot: PolicyStage, lines: Sequence[MotionLine], injected_ns: int, note: str) -> Shot:
    """How long after the period of its last row the robot held, at most."""
    every_row_was_judged_for_its_tick(robot)
    found = [(a, b) for a, b in _row_ends(lines) if b.stamp_ns > injected_ns]
    assert found, "no row acted before or after the fault, so none ended"
    assert all(after.tick == last.tick + 1 for last, after in found), found
    late_ms = max((after.stamp_ns - last.stamp_ns) / 1e6 - TICK_MS for last, after in found)
    held_ns = found[0][1].stamp_ns
    return Shot(
        max(0.0, late_ms),
        injected_ns,
        found[-1][1].stamp_ns,
        robot.tick_ms(injected_ns),
        note,
        also=(held_ns - injected_ns) / 1e6,
    )


def _no_jump(robot: PolicyStage, lines: Sequence[MotionLine]) -> None:
    """No tick turned the base further than a row says, and no row of a late answer was released."""
    most = SPEED * FULL_SPEED * TICK_S * TOLERANCE
    turned = robot.base.largest_turn(lines)
    assert 0.0 < turned <= most, f"turned {turned} rad in a tick, rows say {most}"
    back = [rows for rows in robot.base.rows.values() if (rows < 0.0).any()]
    assert not back, f"a late answer was released: {back[0]}"


def _verdicts(lines: Sequence[MotionLine]) -> set[int]:
    return {verdict for line in lines for verdict in line.verdicts}


MEASURES = "last row to hold"
ALSO = "fault to hold"
ROWS = (
    Row(
        6, f"policy server {SLOWER} times as slow",
        "hold between chunks (`starved`)", TICK_MS, "policy", slow,
        MEASURES, also=ALSO,
    ),
    *(
        Row(
            6, f"policy server {what}",
            "hold; the error says why; no late answer acts; the next goal moves",
            TICK_MS, "policy", partial(fails, behaviour), MEASURES, also=ALSO,
        )
        for behaviour, what in (
            (HANG, "hangs"), (DROP, "drops the connection"), (LATE, "answers late"),
            (GARBAGE, "answers garbage"),
        )
    ),
)  # fmt: skip
