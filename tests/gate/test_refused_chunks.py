"""Chunks that must not move anything: each gets its code, and nothing is released."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from bench.equipment.gate_scene import Scene
from fairlead.messages import (
    ActionChunk,
    Decision,
    GateState,
    Outcome,
    Verdict,
    encode,
    pack_floats,
)

pytestmark = pytest.mark.processes


def rows(value: float, at: int = 0, count: int = 8) -> bytes:
    values = np.zeros((count, 6))
    values[at, 0] = value
    return pack_floats(values)


def nothing_was_released(scene: Scene, verdict: Verdict) -> None:
    assert (verdict.outcome, verdict.released_last) == (Outcome.REFUSED, 0)
    assert scene.safe.unread() == []
    assert all(g.decision != Decision.ROW for m in scene.leases.unread() for g in m.grants)


BAD_CHUNKS: dict[str, tuple[int, Callable[[Scene], ActionChunk]]] = {
    "wrong robot hash": (2, lambda s: s.chunk(robot_hash=bytes(32))),
    "another session": (2, lambda s: s.chunk(session=s.hal.session + 1)),
    "old epoch": (3, lambda s: s.chunk(epoch=s.epoch ^ 1)),
    "unknown claim": (4, lambda s: s.chunk(claim_id=s.claim_id ^ 1)),
    "part of nobody's claim": (4, lambda s: s.chunk(parts=(s.arm_part(part=1),))),
    "sequence jumps": (5, lambda s: s.chunk(seq=5000)),
    "observation from the future": (6, lambda s: s.chunk(obs_tick=s.hal.tick + 2)),
    "older than the claim allows": (6, lambda s: s.chunk(oldest_tick=s.hal.tick - 11)),
    "no rows": (7, lambda s: s.chunk(rows=0)),
    "more rows than numbers": (7, lambda s: s.chunk(horizon=9)),
    "too many rows": (7, lambda s: s.chunk(rows=65)),
    "not a number": (8, lambda s: s.chunk(parts=(s.arm_part(values=rows(np.nan, at=7)),))),
    "infinite": (8, lambda s: s.chunk(parts=(s.arm_part(values=rows(np.inf)),))),
    "beyond 1e6": (8, lambda s: s.chunk(parts=(s.arm_part(values=rows(1e308)),))),
    "mode without a checker": (9, lambda s: s.chunk(parts=(s.arm_part(mode=3),))),
    "part commanded twice": (9, lambda s: s.chunk(parts=(s.arm_part(), s.arm_part()))),
    "every row past": (12, lambda s: s.chunk(start_tick=s.hal.tick - 8)),
    "first row too fast": (20, lambda s: s.chunk(parts=(s.arm_part(values=rows(0.09)),))),
}


@pytest.mark.parametrize("name", BAD_CHUNKS)
def test_a_bad_chunk_is_refused_with_its_code(scene: Scene, name: str) -> None:
    code, make = BAD_CHUNKS[name]
    scene.hal.tick = 20
    scene.ready_to_move()
    scene.leases.skip()

    verdict = scene.send(make(scene))

    assert verdict.code == code, verdict
    nothing_was_released(scene, verdict)


@pytest.mark.parametrize("value", [np.nan, np.inf, 1e308])
def test_a_number_that_is_none_stops_the_robot(scene: Scene, value: float) -> None:
    scene.ready_to_move()
    scene.send(scene.chunk(parts=(scene.arm_part(values=rows(value)),)))
    assert len(scene.wait_state(GateState.STOPPED).stop_ids) == 1


def test_a_chunk_of_a_claim_that_was_given_back_is_refused(scene: Scene) -> None:
    scene.ready_to_move()
    old = scene.chunk()
    scene.release()
    scene.take_claim()
    scene.seq = old.seq
    verdict = scene.send(old)
    assert verdict.code == 4
    nothing_was_released(scene, verdict)


def test_a_chunk_from_before_a_new_arm_is_refused(scene: Scene) -> None:
    scene.ready_to_move()
    old = scene.chunk()
    scene.disarm()
    scene.arm()
    scene.take_claim()
    verdict = scene.send(old)
    assert verdict.code == 3
    nothing_was_released(scene, verdict)


def test_a_sequence_number_used_again_for_other_rows_is_refused(scene: Scene) -> None:
    scene.ready_to_move()
    first = scene.send(scene.chunk())
    scene.safe.wait_for()
    scene.seq -= 1
    second = scene.chunk(goal_id=2)
    scene.send_bytes(encode(second))
    refused = scene.verdicts.wait_for(lambda m: m.verdict_id != first.verdict_id)
    assert (refused.code, refused.outcome) == (5, Outcome.REFUSED)
    assert all(m.verdict_id == first.verdict_id for m in scene.safe.unread())


def test_a_row_too_fast_cuts_the_chunk_before_it(scene: Scene) -> None:
    scene.ready_to_move()
    verdict = scene.send(scene.chunk(parts=(scene.arm_part(values=rows(0.09, at=5)),)))
    assert (verdict.outcome, verdict.code, verdict.row) == (Outcome.TRUNCATED, 20, 5)
    assert verdict.part == "arm"
    assert verdict.value == pytest.approx(0.09)
    assert verdict.limit == pytest.approx(0.0867)
    assert verdict.margin == pytest.approx(0.0867 - 0.09)
    assert scene.safe.wait_for().horizon == 5


FRAMES: dict[str, Callable[[bytes], bytes]] = {
    "truncated": lambda frame: frame[:-1],
    "cut in half": lambda frame: frame[: len(frame) // 2],
    "trailing byte": lambda frame: frame + b"\0",
    "empty": lambda frame: b"",
    "another type": lambda frame: frame[:1] + b"\x08" + frame[2:],
    "another version": lambda frame: frame[:2] + b"\x02" + frame[3:],
    "oversized": lambda frame: frame + bytes(70_000),
}


@pytest.mark.parametrize("name", FRAMES)
def test_a_bad_frame_moves_nothing_and_is_counted(scene: Scene, name: str) -> None:
    scene.ready_to_move()
    frame = FRAMES[name](encode(scene.chunk()))
    scene.send_bytes(frame)
    status = scene.statuses.wait_for(lambda m: dict(m.counters).get("G001", 0) == 1)
    assert status.state == GateState.ARMED
    assert scene.safe.unread() == []


def test_five_unreadable_frames_that_cite_the_claim_end_it(scene: Scene) -> None:
    scene.ready_to_move()
    whole = encode(scene.chunk())
    for _ in range(5):
        scene.send_bytes(whole[:-1])
    told = scene.verdicts.wait_for(lambda m: m.code == 1).limit_source
    assert told.startswith("a chunk, got cut short, at byte "), told
    assert told.endswith(f" of {len(whole) - 1}"), told
    assert scene.statuses.wait_for(lambda m: dict(m.counters).get("G001", 0) >= 5).claims == ()
