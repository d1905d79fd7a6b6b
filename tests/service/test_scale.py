"""``python -m bench.scale``: robots on one router move side by side, and a missed aim is said."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from bench.scale.__main__ import misses, ratios, table
from bench.scale.dora import WIRES
from bench.scale.fleet import fairlead
from bench.scale.measured import PERIOD_NS, Found, Tick, Window, found
from bench.scale.processes import Spending
from bench.tick_watch import Spent

MS = 1_000_000
SECOND_NS = 1_000_000_000


@pytest.mark.processes
@pytest.mark.timeout(120)
def test_robots_on_one_router_move_and_each_is_in_the_window(tmp_path: Path) -> None:
    window = fairlead(0, 2, 1.0, tmp_path / "scale")
    assert len(window.ticks) == 2
    assert all(any(tick.moves for tick in ticks) for ticks in window.ticks)
    assert window.cpu_ms > window.router_ms > 0


def window(robots: int, running_ms: float, late_ms: int = 0) -> Window:
    """A second of robots that tick on time but for one tick."""
    stamps = [SECOND_NS + number * PERIOD_NS for number in range(50)]
    stamps[25] += late_ms * MS
    ticks = [Tick(stamp, stamp - 19 * MS, moves=number > 1) for number, stamp in enumerate(stamps)]
    groups = {"robots": Spent(running_ms, 0, 80 * robots), "router": Spent(running_ms / 4, 0, 50)}
    spent = Spending(SECOND_NS, 2 * SECOND_NS, groups, busy=0.5)
    return Window(spent, [ticks] * robots)


def test_a_robot_s_processor_time_is_of_a_tick_and_has_its_share_of_the_router() -> None:
    one = found("fairlead", [window(2, running_ms=400)])
    assert (one.cpu_ms, one.router_ms, one.memory_mb) == (5.0, 1.0, (80, 50))
    assert (one.lost, one.held, one.lease_ms[0]) == (0.0, 0.04, 1.0)
    late = found("fairlead", [window(1, running_ms=100, late_ms=7)])
    assert (one.error_ms, late.error_ms) == ((0, 0), (0, 7))


def test_a_missed_aim_is_of_the_most_robots_and_the_fewest() -> None:
    few: Found = found("fairlead", [window(1, running_ms=100, late_ms=1)])
    many = replace(few, robots=32, cpu_ms=few.cpu_ms * 1.2, error_ms=(0.0, 5.0))
    other = replace(few, way="dora-rs", cpu_ms=0.1)
    every = [few, other, many]
    assert [round(ratio, 6) for ratio in ratios(many, every)] == [1.2, 5.0]
    assert misses(every) == [
        "processor time of 32 robots, fairlead: 1.20 of the fewest, aim 1.15",
        "p99 of a tick of 32 robots, fairlead: 5.00 of the fewest, aim 4.0",
    ]
    lines = table(every, {(32, "dora-rs"): "did not start"}).splitlines()
    assert lines[-3:] == [
        "| 32: fairlead | 3.00, 1.20 | 5.00, 5.0 | 19.00 |",
        "",
        "Not carried: 32: dora-rs (did not start).",
    ]
    assert {line.count("|") for line in lines[:-2]} == {5}


@pytest.mark.parametrize("idle", [{"held": 1.0}, {"lost": 0.06}, {"held": 0.05}], ids=str)
def test_robots_that_stand_still_are_not_carried_however_little_they_cost(
    idle: dict[str, float],
) -> None:
    few: Found = found("fairlead", [window(1, running_ms=100)])
    few = replace(few, error_ms=(0.0, 1.0))
    many = replace(few, robots=32, cpu_ms=few.cpu_ms * 0.24)
    many = replace(many, held=idle.get("held", 0.0), lost=idle.get("lost", 0.0))
    carried = idle == {"held": 0.05}
    assert ["32 robots, fairlead: not carried: " in text for text in misses([few, many])] == (
        [] if carried else [True]
    )
    assert table([few, many], {}).count("Not carried: 32: fairlead (") == (0 if carried else 1)
    other = replace(many, way="dora-rs")
    assert misses([few, other]) == []


def test_each_input_of_a_node_is_another_s_output_or_a_timer() -> None:
    outputs = {f"{node}/{output}" for node, (_, outputs) in WIRES.items() for output in outputs}
    inputs = {source for inputs, _ in WIRES.values() for source in inputs.values()}
    assert {source for source in inputs if not source.startswith("dora/timer/")} == outputs
