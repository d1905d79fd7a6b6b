"""A base that goes further than it is told: rows judged while it was elsewhere are revoked in time.

The HAL core, the gate and the channel are the real ones of this folder; the base slides on by
`SLIDE_M` in every tick in which a row moves it, which no prediction knows.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.real_gate import RealGate
from fairlead.hal.core import Pacing
from fairlead.messages import FloatArray, Verdict
from fairlead.paths import gate_config
from tests.explorer.channel import FAIR, Weather
from tests.explorer.hal_actor import Tick
from tests.explorer.rules import check_history, moves
from tests.explorer.runner_actor import HORIZON
from tests.explorer.world import World

pytestmark = pytest.mark.processes

SLIDE_M = 0.02
FRONT_M = 0.15
"""Of the footprint, ahead of the base's origin."""
EDGE_M = 1.0
"""Where the zone ends, ahead of the base's start."""
SPEED_M_S = 0.3
TICKS = 60


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """panda_mobile's gate file with a zone that ends soon."""
    data = json.loads(gate_config("panda_mobile", "sim").read_text())
    corners = [[-5.0, -5.0], [EDGE_M, -5.0], [EDGE_M, 5.0], [-5.0, 5.0]]
    zone = {"name": "near", "kind": "keep_in", "corners": corners}
    data["base"] |= {"zones": [zone], "footprint": [[-0.5, -0.2], [FRONT_M, -0.2],
                                                    [FRONT_M, 0.2], [-0.5, 0.2]]}  # fmt: skip
    path = tmp_path_factory.mktemp("gate") / "gate.zone.json"
    path.write_text(json.dumps(data))
    return path


def straight_ahead(positions: FloatArray, tick: int) -> FloatArray:
    rows = np.zeros((HORIZON, 3))
    rows[:, 0] = SPEED_M_S
    return rows


class SlidingWorld(World):
    """Counts verdicts of chunks that had got one before."""

    def __init__(self, config: Path, pacing: Pacing, seed: int) -> None:
        super().__init__(RealGate(seed, config=config), pacing, seed)
        self.judged: dict[int, set[int]] = {}
        self.cut_again = 0
        backend, on_verdict = self.hal._backend, self.runner.on_verdict
        apply = backend.apply

        def slide(commands: dict[str, object]) -> None:
            apply(commands)  # type: ignore[arg-type]
            if "base" in commands:
                backend._positions[0] += SLIDE_M

        def note(source: str, verdict: Verdict) -> None:
            ids = self.judged.setdefault(verdict.seq, set())
            if verdict.verdict_id not in ids and ids and verdict.code == 34:
                self.cut_again += 1
            ids.add(verdict.verdict_id)
            on_verdict(source, verdict)

        backend.apply = slide  # type: ignore[method-assign,assignment]
        self.runner.on_verdict = note  # type: ignore[method-assign]


@pytest.fixture
def make(config: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[type[SlidingWorld]]:
    monkeypatch.setattr("tests.explorer.runner_actor.policy", straight_ahead)
    yield SlidingWorld


def front(history: list[Tick]) -> float:
    """How far the footprint came."""
    return max(float(tick.positions[0]) for tick in history) + FRONT_M


@pytest.mark.parametrize(
    ("pacing", "in_flight"),
    [pytest.param("lockstep", 1, marks=pytest.mark.thorough), ("realtime", 2)],
)
def test_a_sliding_base_is_stopped_by_the_states_it_is_seen_in(
    make: type[SlidingWorld], config: Path, pacing: Pacing, in_flight: int
) -> None:
    for seed in range(4):
        world = make(config, pacing, seed)
        world.bring_up()
        world.rain(FAIR)
        if pacing == "lockstep":
            world.run_for(4000)
        else:
            world.run_ticks(TICKS)
        check_history(world)
        assert world.cut_again >= 1, "no released row was revoked"
        assert EDGE_M - 0.3 < front(world.history) <= EDGE_M + in_flight * SLIDE_M
        world.gate.close()


def test_a_lossy_channel_lets_no_more_rows_slide_than_a_grant_covers(
    make: type[SlidingWorld], config: Path
) -> None:
    for seed in range(6):
        world = make(config, "realtime", seed)
        world.bring_up()
        world.rain(Weather(loss=0.3))
        world.run_ticks(2 * TICKS)
        check_history(world)
        assert moves(world.history) > 10
        # A lease grants two ticks ahead, and the newest two may be lost before it goes stale.
        assert front(world.history) <= EDGE_M + 4 * SLIDE_M, f"seed {seed}"
        world.gate.close()
