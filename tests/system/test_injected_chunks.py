"""Bad chunks injected beside a whole running robot: right code, and nothing moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from bench.equipment.light_hal import Pacing
from bench.equipment.live_robot import LiveRobot, wait_for
from bench.equipment.motion_log import MotionLog
from fairlead.deploy.registry import Registry
from fairlead.messages import (
    ActionChunk,
    GateState,
    Outcome,
    encode,
)
from fairlead_tools.supervisor.scratch import Scratch, scratch_robot
from tests.system.injector import ROWS, SOURCE, Injector

pytestmark = [pytest.mark.processes, pytest.mark.timeout(300)]


@contextmanager
def injecting(robot: LiveRobot) -> Iterator[Injector]:
    with robot.client.claim(["arm"], source=SOURCE) as claim:
        injector = Injector(robot, claim.reply)
        yield injector
        injector.close()


@pytest.fixture
def injector(realtime_robot: LiveRobot) -> Iterator[Injector]:
    robot = realtime_robot
    robot.recover()
    if robot.client.gate_status().state != GateState.ARMED:
        robot.client.arm()
    with injecting(robot) as injector:
        yield injector


BAD_CHUNKS: dict[str, tuple[int, Callable[[Injector], ActionChunk]]] = {
    "wrong robot hash": (2, lambda i: i.chunk(robot_hash=bytes(32))),
    "another session": (2, lambda i: i.chunk(session=i.claim.session ^ 1)),
    "old epoch": (3, lambda i: i.chunk(epoch=i.claim.epoch ^ 1)),
    "old claim": (4, lambda i: i.chunk(claim_id=i.claim.claim_id ^ 1)),
    "overspeed": (20, lambda i: i.chunk(value=0.1)),
}


@pytest.mark.parametrize("name", BAD_CHUNKS)
def test_a_bad_chunk_is_refused_with_its_code_and_nothing_moves(
    injector: Injector, name: str
) -> None:
    code, make = BAD_CHUNKS[name]
    verdict = injector.send(make(injector))
    assert (verdict.outcome, verdict.code) == (Outcome.REFUSED, code), verdict
    injector.nothing_moves()


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_number_that_is_none_is_refused_and_stops_the_robot(
    injector: Injector, value: float
) -> None:
    verdict = injector.send(injector.chunk(value=value))
    assert (verdict.outcome, verdict.code) == (Outcome.REFUSED, 8)
    assert injector.gate().state in (GateState.STOPPED, GateState.LATCHED)
    injector.nothing_moves()


FRAMES: dict[str, Callable[[bytes], bytes]] = {
    "truncated": lambda frame: frame[:-1],
    "trailing byte": lambda frame: frame + b"\0",
}


@pytest.mark.parametrize("name", FRAMES)
def test_a_bad_frame_is_refused_counted_and_moves_nothing(injector: Injector, name: str) -> None:
    before = dict(injector.gate().counters).get("G001", 0)
    injector.send_bytes(FRAMES[name](encode(injector.chunk())))
    wait_for(lambda: bool(injector.verdicts), "a verdict")
    assert (injector.verdicts[0].outcome, injector.verdicts[0].code) == (Outcome.REFUSED, 1)
    assert dict(injector.gate().counters)["G001"] == before + 1
    injector.nothing_moves()


def test_a_good_chunk_moves_and_its_copy_gets_the_same_verdict_and_moves_nothing_more(
    light_scratch: Callable[[Pacing], Scratch], tmp_path: Path
) -> None:
    """In lockstep: in realtime a busy machine is late with any of chunk, lease and tick."""
    with scratch_robot(light_scratch("lockstep"), Registry(tmp_path / "registry")) as scratch:
        robot = LiveRobot(scratch)
        motion = robot.motion
        robot.recover()
        robot.client.arm()
        with injecting(robot) as injector:
            chunk = injector.chunk()
            first = injector.send(chunk)
            assert first.outcome == Outcome.RELEASED, first
            wait_for(lambda: last_tick(motion) >= first.released_last, "the rows act")
            assert injector.send(chunk).verdict_id == first.verdict_id
        robot.client.disarm()
        robot.client.reset_episode(0)  # takes a held tick: whatever was to act has
    acted = [line.tick for line in motion.read() if line.moves]
    assert acted == list(range(first.released_first, first.released_last + 1))
    assert len(acted) == ROWS


def last_tick(motion: MotionLog) -> int:
    return max((line.tick for line in motion.read()), default=0)


def test_a_sequence_number_used_again_for_other_rows_is_refused(injector: Injector) -> None:
    injector.send(injector.chunk(value=0.0))
    refused = injector.send(injector.chunk(value=0.02, goal_id=7))
    assert (refused.outcome, refused.code) == (Outcome.REFUSED, 5)
