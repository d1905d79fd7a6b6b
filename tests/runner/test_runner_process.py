"""The runner as a process on Zenoh, its policy as another, the rest of the robot scripted."""

from __future__ import annotations

import hashlib
import itertools
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from fairlead.errors import RefusedError
from fairlead.messages import (
    NO_HASH,
    ActionChunk,
    Cancel,
    GateState,
    Goal,
    decode,
    floats,
)
from fairlead.paths import rskill_dir
from fairlead_skill_runner.trace import read_trace
from fairlead_tools.supervisor.this_host import free_ports
from tests.runner.scripted_robot import CLAIM, SKILL
from tests.runner.scripted_world import ScriptedWorld

pytestmark = pytest.mark.processes

CONSTANT = {"backend": "constant", "options": {"row": [0.5] * 12}}


@pytest.fixture
def world(make_world: Callable[..., ScriptedWorld]) -> ScriptedWorld:
    made = make_world()
    made.start_runner(CONSTANT)
    return made


def follow(world: ScriptedWorld, first: int = 5) -> Callable[[], None]:
    """Lockstep: steps to the tick after the newest chunk's rows, or repeats the tick."""

    def step() -> None:
        if not world.claims:
            return
        newest = decode(ActionChunk, world.chunks[-1]) if world.chunks else None
        world.tick(newest.start_tick + newest.horizon if newest else first)

    return step


def test_a_goal_is_claimed_run_and_released(world: ScriptedWorld, tmp_path: Path) -> None:
    goal = world.start_goal(deadline_ticks=24)
    ended = world.result(goal, every=follow(world))
    assert ended.result is not None
    assert (ended.result.outcome, ended.result.first_tick, ended.result.last_tick) == (
        "deadline", 5, 29,
    )  # fmt: skip
    assert ended.phase == "ended"
    assert ended.inferences == 3
    claim = world.claims[0]
    assert (claim.source, claim.skill, claim.parts) == (
        "runner", SKILL.id, ("arm", "gripper", "base", "composite"),
    )  # fmt: skip
    assert (claim.period_ns, claim.chunk_rate_hz, claim.horizon_max) == (50_000_000, 20.0, 8)
    assert claim.skill_hash == SKILL.skill_hash
    assert world.released == [CLAIM]
    assert world.wait_for(lambda: None if world.wanted else True), "the token is taken back"
    distinct = list(dict.fromkeys(world.chunks))
    assert [decode(ActionChunk, payload).seq for payload in distinct] == [1, 2, 3]
    arm = decode(ActionChunk, distinct[0]).parts[0]
    np.testing.assert_array_equal(floats(arm.values, 6)[7], [0.025] * 3 + [0.25] * 3)
    trace = list(read_trace(tmp_path / "state" / "trace.jsonl"))
    assert [record.tick for record in trace] == [5, 13, 21]
    np.testing.assert_array_equal(trace[1].state, np.full(30, 13.0))
    np.testing.assert_array_equal(trace[1].actions, np.full((8, 12), 0.5, dtype=np.float32))


def test_a_goal_that_succeeds_is_logged_with_its_detail_alone(
    world: ScriptedWorld, tmp_path: Path
) -> None:
    goal = world.start_goal()

    def step() -> None:
        if world.claims:
            world.tick(13 if world.chunks else 5, success=bool(world.chunks))

    ended = world.result(goal, every=step)
    assert ended.result is not None and ended.result.outcome == "succeeded"
    said = (tmp_path / "runner.log").read_text()
    assert f"goal {goal:016x} succeeded: the task's own check says so\n" in said, said


def test_before_its_first_goal_a_runner_says_nothing_and_wants_nothing(
    world: ScriptedWorld,
) -> None:
    world.tick(5)
    with pytest.raises(RefusedError, match="no goal 0000000000000001 is running"):
        world.bus.query(world.keys.cancel("runner"), Cancel(goal_id=1, by="test"), 10.0)
    assert (world.chunks, world.heartbeats, world.feedback, world.claims) == ([], [], [], [])
    assert not world.wanted


def test_a_trace_on_a_full_disk_costs_the_trace_and_nothing_else(
    make_world: Callable[..., ScriptedWorld], tmp_path: Path
) -> None:
    (tmp_path / "state").mkdir()
    (tmp_path / "state" / "trace.jsonl").symlink_to("/dev/full")
    world = make_world()
    world.start_runner(CONSTANT)
    for _ in range(2):
        goal = world.start_goal(deadline_ticks=24)
        ended = world.result(goal, every=follow(world))
        assert ended.result is not None
        assert (ended.result.outcome, ended.inferences) == ("deadline", 3)
        world.chunks.clear()
    said = (tmp_path / "runner.log").read_text()
    assert said.count("trace.jsonl: no longer recorded: No space left on device") == 2


def test_the_result_is_repeated_until_the_next_goal(world: ScriptedWorld) -> None:
    goal = world.start_goal(deadline_ticks=8)
    world.result(goal, every=follow(world))
    seen = len(world.feedback)
    world.wait_for(lambda: True if len(world.feedback) >= seen + 2 else None)
    assert all(f.result is not None for f in world.feedback[seen:])


def test_a_recording_of_the_runner_can_be_replayed(
    make_world: Callable[..., ScriptedWorld], tmp_path: Path
) -> None:
    world = make_world()
    world.start_runner(CONSTANT)
    world.result(world.start_goal(deadline_ticks=8), every=follow(world))
    world.close()
    (tmp_path / "state" / "trace.jsonl").rename(tmp_path / "recorded.jsonl")
    again = make_world()
    again.start_runner(
        {"backend": "replay", "options": {"trace": str(tmp_path / "recorded.jsonl")}}
    )
    ended = again.result(again.start_goal(), every=follow(again))
    assert ended.result is not None
    assert ended.result.detail == (
        "policy worker: inference failed: replay policy: the recording ends after 1 chunks"
    )
    assert decode(ActionChunk, again.chunks[0]).parts == decode(ActionChunk, world.chunks[0]).parts


def test_heartbeats_come_while_the_claim_lives_and_end_with_it(world: ScriptedWorld) -> None:
    goal = world.start_goal()
    world.wait_for(lambda: True if len(world.heartbeats) >= 10 else None)
    assert {beat.claim_id for beat in world.heartbeats} == {CLAIM}  # type: ignore[attr-defined]
    world.cancel(goal)
    ended = world.result(goal)
    assert ended.result is not None
    assert (ended.result.outcome, ended.result.decided_by, ended.result.detail) == (
        "cancelled", "operator", "cancelled by test",
    )  # fmt: skip
    assert world.released == [CLAIM]


def test_a_policy_server_that_is_not_there_fails_the_goal_before_anything_is_claimed(
    make_world: Callable[..., ScriptedWorld],
) -> None:
    address = f"ws://127.0.0.1:{free_ports(1)[0]}"
    world = make_world()
    options = {"address": address, "start": "serve it", "connect_timeout_s": 1.0}
    world.start_runner({"backend": "openpi", "options": options | {"answer_timeout_s": 1.0}})
    ended = world.result(world.start_goal())
    assert ended.result is not None
    assert (ended.result.outcome, ended.result.kind) == ("failed", "policy_error")
    assert ended.result.detail == (
        f"policy worker: loading failed: openpi policy: no policy server at {address}: "
        "[Errno 111] Connection refused\n"
        "  start one: serve it\n"
        "  or, if one runs elsewhere, in the runner's options in the deployment file:\n"
        "    servers: {oracle-counter-to-cabinet: ADDRESS}"
    )
    assert world.claims == []


def test_without_onnxruntime_a_goal_says_what_to_install_before_anything_is_claimed(
    make_world: Callable[..., ScriptedWorld], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    hidden = tmp_path / "hidden"
    hidden.mkdir()
    (hidden / "onnxruntime.py").write_text("raise ImportError('hidden')")
    monkeypatch.setenv("PYTHONPATH", str(hidden))
    file = rskill_dir(SKILL.id) / "rskill.yaml"  # any: it is compared, then onnxruntime is needed
    digest = hashlib.sha256(file.read_bytes()).hexdigest()
    world = make_world()
    options = {"model": {"file": file.name, "sha256": digest}}
    world.start_runner({"backend": "onnx", "options": options})
    ended = world.result(world.start_goal())
    assert ended.result is not None
    assert (ended.result.outcome, ended.result.kind) == ("failed", "policy_error")
    assert ended.result.detail == (
        "policy worker: loading failed: onnx policy: the package onnxruntime is not installed: "
        "pip install 'fairlead[onnx]'"
    )
    assert world.claims == []


def test_a_lost_claim_fails_the_goal_with_the_gates_cause_and_fix(world: ScriptedWorld) -> None:
    goal = world.start_goal()
    world.wait_for(lambda: True if world.chunks else None, every=follow(world))
    world.publish_lease(GateState.LATCHED)
    ended = world.result(goal)
    assert ended.result is not None
    assert (ended.result.outcome, ended.result.kind) == ("failed", "claim_lost")
    assert ended.result.detail == (
        "claim of runner lost: the gate is latched (three stops within 60 s; try: fairlead reset 7)"
    )


def test_a_claim_in_the_way_that_is_the_runners_own_is_waited_for(world: ScriptedWorld) -> None:
    world.claim_refusals += [RefusedError("safety", "part arm is held by runner")] * 3
    world.start_goal()
    world.wait_for(lambda: world.claims or None)
    assert world.claim_refusals == []


def test_a_refused_claim_fails_the_goal_with_reason_and_fix(
    make_world: Callable[..., ScriptedWorld],
) -> None:
    world = make_world("realtime")
    world.start_runner(CONSTANT)
    world.claim_refusals += [RefusedError("safety", "disarmed", "fairlead arm")] * 50
    goal = world.start_goal()
    ended = world.result(goal)
    assert ended.result is not None
    assert (ended.result.kind, ended.result.detail) == (
        "claim_refused", "safety refused: disarmed\n  try: fairlead arm",
    )  # fmt: skip


def test_a_second_goal_is_refused_while_one_runs_and_accepted_afterwards(
    world: ScriptedWorld,
) -> None:
    first = world.start_goal()
    with pytest.raises(RefusedError) as caught:
        world.start_goal()
    assert str(caught.value) == (
        f"runner refused: goal {first:016x} of skill {SKILL.id} is still running\n"
        "  try: fairlead cancel runner"
    )
    world.cancel(first)
    world.result(first)
    second = world.wait_for(lambda: _accepted(world))
    assert second != first


def test_a_skill_that_was_not_there_when_the_runner_started_is_refused_with_the_way_out(
    world: ScriptedWorld,
) -> None:
    goal = Goal(
        skill="my-new-one", skill_hash=NO_HASH, prompt="", deadline_ticks=0, stall_timeout_s=5.0
    )
    with pytest.raises(RefusedError) as caught:
        world.bus.query(world.keys.goal("runner"), goal, 10.0)
    assert str(caught.value) == (
        f"runner refused: goal: expected a skill on offer, got 'my-new-one' (valid: {SKILL.id})\n"
        "  try: fairlead skill ls --robot panda_mobile"
    )


def _accepted(world: ScriptedWorld) -> int | None:
    try:
        return world.start_goal()
    except RefusedError:
        return None


def test_realtime_rows_never_run_out_while_the_policy_is_fast(
    make_world: Callable[..., ScriptedWorld],
) -> None:
    world = make_world("realtime")
    world.start_runner(CONSTANT)
    goal = world.start_goal(deadline_ticks=40)
    ticks = itertools.count(5)
    ended = world.result(goal, every=lambda: world.tick(next(ticks)) if world.claims else None)
    assert ended.result is not None
    assert ended.result.outcome == "deadline"
    chunks = [decode(ActionChunk, payload) for payload in dict.fromkeys(world.chunks)]
    assert len(chunks) >= 5
    gaps = [b.obs_tick - a.obs_tick for a, b in itertools.pairwise(chunks)]
    assert max(gaps) <= 7, "the next chunk starts before the last row of the one before"
