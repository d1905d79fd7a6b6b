"""HAL core against the gate through a channel that loses, delays, duplicates and reorders.

Each schedule is seeded: a failure names its seed and comes again.
"""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from bench.equipment.real_gate import RealGate
from fairlead.hal.claims import ClaimRows
from fairlead.hal.core import Pacing
from fairlead.hal.lease_follower import LeaseFollower
from fairlead.messages import GateStatus, StatusQuery
from tests.explorer.channel import FAIR, Weather
from tests.explorer.rules import check_history, check_stops, moves, trajectory
from tests.explorer.world import World

pytestmark = pytest.mark.processes

WEATHERS = {
    "loss_1": Weather(loss=0.01),
    "loss_30": Weather(loss=0.30),
    "duplicates": Weather(duplicate=0.5, delay_ms=30.0),
    "reordered": Weather(delay_ms=120.0),
    "storm": Weather(loss=0.2, duplicate=0.3, delay_ms=300.0),
}
LOCKSTEP_TICKS = 60
STOP_ID = 4711


class Builder:
    """Makes worlds around the real gate core, one at a time, and closes their gates."""

    def __init__(self) -> None:
        self._gate: RealGate | None = None

    def __call__(self, pacing: Pacing, seed: int) -> World:
        return World(self._new_gate(seed), pacing, seed)

    def kill_gate(self, world: World, seed: int) -> None:
        """Put a freshly started gate in the place of the one that is gone."""
        world.gate = self._new_gate(seed, restarted=True)

    def close(self) -> None:
        if self._gate is not None:
            self._gate.close()

    def _new_gate(self, seed: int, restarted: bool = False) -> RealGate:
        self.close()
        self._gate = RealGate(seed, restarted)
        return self._gate


LONG = [pytest.mark.soak, pytest.mark.timeout(3600)]
SEEDS = [
    pytest.param(range(3), id="short"),
    pytest.param(range(3, 6), id="more", marks=pytest.mark.thorough),
    pytest.param(range(6, 40), id="long", marks=LONG),
]


@pytest.fixture(params=SEEDS)
def seeds(request: pytest.FixtureRequest) -> range:
    found: range = request.param
    return found


@pytest.fixture
def build() -> Iterator[Builder]:
    builder = Builder()
    yield builder
    builder.close()


def lockstep_run(build: Builder, weather: Weather, seed: int) -> World:
    world = build("lockstep", seed)
    world.bring_up()
    world.rain(weather)
    world.run_ticks(LOCKSTEP_TICKS)
    return world


def test_lockstep_in_fair_weather_moves_in_every_tick_but_the_refused(build: Builder) -> None:
    world = lockstep_run(build, FAIR, seed=0)
    check_history(world)
    assert LOCKSTEP_TICKS - 10 < moves(world.history) < LOCKSTEP_TICKS


@pytest.mark.parametrize("name", ["fair", *WEATHERS])
@pytest.mark.parametrize("pacing", ["lockstep", "realtime"])
def test_a_claim_handed_over_again_and_again_breaks_no_rule(
    build: Builder, seeds: range, pacing: Pacing, name: str
) -> None:
    weather = ({"fair": FAIR} | WEATHERS)[name]
    for seed in seeds:
        world, dice = build(pacing, seed), random.Random(seed)
        world.bring_up()
        world.rain(weather)
        for number in range(8):
            world.run_ticks(dice.randrange(1, 12))
            status = world.ask("status", StatusQuery(), GateStatus)
            if status.claims:  # in the worst weather it may have ended
                world.hand_over(dice.choice(["", f"next_{number}"]))
        check_history(world)
        assert name != "fair" or moves(world.history) > len(world.history) / 2


@pytest.mark.parametrize("name", WEATHERS)
def test_lockstep_through_a_bad_channel_ends_in_the_identical_trajectory(
    build: Builder, seeds: range, name: str
) -> None:
    lossless = trajectory(lockstep_run(build, FAIR, seed=0).history)[:LOCKSTEP_TICKS]
    for seed in seeds:
        world = lockstep_run(build, WEATHERS[name], seed)
        check_history(world)
        assert trajectory(world.history)[:LOCKSTEP_TICKS] == lossless, f"seed {seed}"


@pytest.mark.parametrize("name", WEATHERS)
def test_realtime_runs_only_judged_rows_and_moves_again_when_the_channel_recovers(
    build: Builder, seeds: range, name: str
) -> None:
    for seed in seeds:
        world = build("realtime", seed)
        world.bring_up()
        world.run_ticks(30)
        assert moves(world.history[-20:]) >= 15, "fair weather should move"
        world.rain(WEATHERS[name])
        world.run_ticks(100)
        world.bring_up()
        world.run_ticks(40)
        check_history(world)
        assert moves(world.history[-20:]) >= 15, f"seed {seed} did not recover"


@pytest.mark.parametrize("pacing", ["realtime", "lockstep"])
@pytest.mark.parametrize(
    ("to_hal", "to_gate"), [(True, True), (False, True), (True, False)], ids=["both", "gate", "hal"]
)
def test_a_stop_ends_all_motion_until_reset_and_armed_again_whoever_got_it(
    build: Builder, seeds: range, pacing: Pacing, to_hal: bool, to_gate: bool
) -> None:
    for seed in seeds:
        world = build(pacing, seed)
        world.bring_up()
        world.run_ticks(20 + seed)
        world.rain(WEATHERS["loss_30"])
        world.stop(STOP_ID, to_hal, to_gate)
        world.run_for(1500)
        stopped_at = len(world.history)
        world.run_for(1000)
        assert moves(world.history[stopped_at:]) == 0, f"seed {seed} moved while stopped"
        assert STOP_ID in {stop.stop_id for stop in world.hal.core.held_stops}
        world.bring_up()
        world.run_ticks(30)
        check_history(world)
        check_stops(world)
        assert moves(world.history[-20:]) >= 15, f"seed {seed} did not recover"


@pytest.mark.parametrize("pacing", ["realtime", "lockstep"])
def test_messages_of_a_dead_epoch_move_nothing(build: Builder, pacing: Pacing) -> None:
    for seed in range(4):
        world = build(pacing, seed)
        world.bring_up()
        world.rain(Weather(duplicate=1.0, delay_ms=2000.0))
        world.run_for(1900)
        world.bring_up()
        world.run_for(2500 if pacing == "realtime" else 300)
        check_history(world)


@pytest.mark.parametrize("pacing", ["realtime", "lockstep"])
def test_a_gate_that_dies_and_comes_back_moves_nothing_until_armed_again(
    build: Builder, seeds: range, pacing: Pacing
) -> None:
    for seed in seeds:
        world = build(pacing, seed)
        world.bring_up()
        world.run_ticks(20)
        world.rain(WEATHERS["reordered"])
        build.kill_gate(world, seed + 100)
        world.run_for(400)
        dead_at = len(world.history)
        world.run_for(600)
        assert moves(world.history[dead_at:]) == 0, f"seed {seed}"
        world.bring_up()
        world.run_ticks(40)
        check_history(world)
        assert moves(world.history[-20:]) >= 15, f"seed {seed} did not recover"


@pytest.mark.parametrize("pacing", ["realtime", "lockstep"])
def test_any_mix_of_weather_stops_and_restarts_is_survived(
    build: Builder, seeds: range, pacing: Pacing
) -> None:
    for seed in range(2 * seeds.start, 2 * seeds.stop):
        rng = random.Random(seed)
        world = build(pacing, seed)
        world.bring_up()
        for trouble in range(3):
            world.run_ticks(20)
            world.rain(
                Weather(
                    loss=rng.choice([0.0, 0.01, 0.1, 0.3]),
                    duplicate=rng.choice([0.0, 0.3, 1.0]),
                    delay_ms=rng.choice([0.0, 20.0, 60.0, 120.0, 300.0]),
                )
            )
            world.run_ticks(rng.randint(5, 40))
            if rng.random() < 0.5:
                world.stop(STOP_ID + trouble, to_hal=rng.random() < 0.5, to_gate=True)
            if rng.random() < 0.3:
                build.kill_gate(world, 1000 * (trouble + 1) + seed)
            world.run_for(rng.choice([0, 100, 1000]))
            world.bring_up()
        world.run_ticks(40)
        check_history(world)
        check_stops(world)
        assert moves(world.history[-20:]) >= 15, f"seed {seed} did not recover"


def test_the_rules_catch_a_hal_that_ignores_what_a_chunk_continues(
    build: Builder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ClaimRows, "_continues", lambda *_: True)
    with pytest.raises(AssertionError, match="continued .* judged after"):
        for seed in range(6):
            world = build("realtime", seed)
            world.bring_up()
            world.rain(WEATHERS["reordered"])
            world.run_ticks(100)
            check_history(world)


def test_the_rules_catch_a_hal_that_trusts_an_old_lease(
    build: Builder, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(LeaseFollower, "is_fresh", lambda *_: True)
    with pytest.raises(AssertionError, match="no fresh lease granted the row"):
        for seed in range(6):
            world = build("realtime", seed)
            world.bring_up()
            world.run_ticks(20 + seed)
            world.run_for(2)  # the lease of the newest state is the last one that arrives
            world.rain(Weather(loss=1.0))
            world.run_ticks(3)
            check_history(world)
