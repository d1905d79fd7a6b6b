"""HAL core against a gate through a channel that loses, delays, duplicates and reorders."""

from __future__ import annotations

import pytest

from tests.explorer.channel import FAIR, Weather
from tests.explorer.model_gate import ModelGate
from tests.explorer.rules import check_history, moves, trajectory
from tests.explorer.world import World

WEATHERS = {
    "loss_1": Weather(loss=0.01),
    "loss_30": Weather(loss=0.30),
    "duplicates": Weather(duplicate=0.5, delay_ms=30.0),
    "reordered": Weather(delay_ms=120.0),
    "storm": Weather(loss=0.2, duplicate=0.3, delay_ms=300.0),
}
LOCKSTEP_TICKS = 60


def lockstep_run(weather: Weather, seed: int, gate_seed: int) -> World:
    world = World(ModelGate(gate_seed), "lockstep", seed)
    world.bring_up()
    world.rain(weather)
    world.run_ticks(LOCKSTEP_TICKS)
    return world


@pytest.mark.parametrize("name", WEATHERS)
def test_lockstep_through_a_bad_channel_ends_in_the_identical_trajectory(name: str) -> None:
    lossless = trajectory(lockstep_run(FAIR, seed=1, gate_seed=0).history)
    assert any(held for _, held, _ in lossless[2:]), "the run should contain a refusal"
    for seed in range(20):
        world = lockstep_run(WEATHERS[name], seed=seed + 1, gate_seed=seed)
        check_history(world)
        assert trajectory(world.history)[:LOCKSTEP_TICKS] == lossless[:LOCKSTEP_TICKS]


@pytest.mark.parametrize("name", WEATHERS)
def test_realtime_runs_only_judged_rows_and_moves_again_when_the_channel_recovers(
    name: str,
) -> None:
    for seed in range(20):
        world = World(ModelGate(seed), "realtime", seed)
        world.bring_up()
        world.run_ticks(30)
        assert moves(world.history[-20:]) >= 15, "fair weather should move"
        world.rain(WEATHERS[name])
        world.run_ticks(100)
        world.bring_up()
        world.run_ticks(40)
        check_history(world)
        assert moves(world.history[-20:]) >= 15, f"seed {seed} did not recover"
