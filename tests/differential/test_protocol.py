"""Who may send what, when, and how often: the core against the reference, message by message."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

import numpy as np
import pytest

from bench.equipment.case import Case, Chunk, Pacing, PartRows, still
from bench.equipment.core_gate import CoreGate
from fairlead.messages import encode
from fairlead.paths import gate_config
from tests.differential.plain_mobile import COMPOSITE, COMPOSITE_PART, REST
from tests.differential.reference import open_tick
from tests.differential.runner_walk import FIRST_TICK, RunnerWalk

pytestmark = pytest.mark.processes

WALKS = 150
LONG_WALKS = 10_000
MOVES = 60
PACINGS: tuple[Pacing, ...] = ("lockstep", "realtime")


@pytest.fixture(scope="module")
def core() -> Iterator[CoreGate]:
    gate = CoreGate(gate_config("panda_mobile", "sim"))
    yield gate
    gate.close()


@pytest.mark.parametrize(
    "walks",
    [WALKS, pytest.param(LONG_WALKS, marks=[pytest.mark.soak, pytest.mark.timeout(3600)])],
)
def test_gate_and_reference_agree_on_every_message_of_a_runner_gone_wrong(
    core: CoreGate, walks: int
) -> None:
    codes: Counter[int] = Counter()
    stops = 0
    for seed in range(walks):
        walk = RunnerWalk(core, PACINGS[seed % 2], seed)
        found = walk.run(MOVES)
        assert not found, f"seed {seed}, {PACINGS[seed % 2]}: {found}"
        codes += walk.codes
        stops += core.has_stopped
    assert stops >= 2, "nobody was far ahead often enough to be stopped"
    assert min(codes[code] for code in (0, 1, 2, 3, 4, 5, 6, 10)) >= 10, codes


def released_frame(core: CoreGate, pacing: Pacing) -> bytes:
    """A chunk under a fresh claim that the gate has just let through."""
    measured = still(FIRST_TICK, REST)
    core.start(pacing, measured)
    core.claim(Case("panda_mobile", pacing, measured, Chunk(FIRST_TICK, 1, ())))
    rows = PartRows(COMPOSITE_PART, COMPOSITE, np.zeros((2, 1)))
    answer = core.send(Chunk(open_tick(pacing, FIRST_TICK), 2, (rows,)), FIRST_TICK)
    assert answer.safe is not None
    return encode(answer.chunk)


@pytest.mark.parametrize("pacing", PACINGS)
def test_a_copy_of_an_answered_chunk_is_answered_and_released_as_the_first_time(
    core: CoreGate, pacing: Pacing
) -> None:
    frame = released_frame(core, pacing)
    one, two = core.send_bytes(frame), core.send_bytes(frame)
    assert one.verdicts == two.verdicts
    assert {safe.verdict_id for safe in two.safe} <= {one.verdicts[0].verdict_id}


@pytest.mark.parametrize("pacing", PACINGS)
@pytest.mark.parametrize("change", ["claim", "epoch", "session"])
def test_nothing_of_another_claim_epoch_or_session_is_ever_released(
    core: CoreGate, pacing: Pacing, change: str
) -> None:
    frame = released_frame(core, pacing)
    measured = still(FIRST_TICK, REST)
    if change == "session":
        core.start(pacing, measured, session=77)
    elif change == "epoch":
        core.arm_again()
    else:
        core.release()
    core.claim(Case("panda_mobile", pacing, measured, Chunk(FIRST_TICK, 1, ())))
    reply = core.send_bytes(frame)
    assert [verdict.code for verdict in reply.verdicts] == [
        {"session": 2, "epoch": 3, "claim": 4}[change]
    ]
    assert reply.safe == []
