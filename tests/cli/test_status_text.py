"""What ``fairlead status`` says of the gate's counters and of goals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from msgspec import structs

from fairlead.errors import RefusedError
from fairlead.messages import NO_HASH, GateState, GateStatus, GoalFeedback, GoalResult
from fairlead.operate.goal_hearing import Progress
from fairlead_tools.cli.run_output import goal_hints
from fairlead_tools.cli.status import full_disk, gate_lines, goal_line


def gate_with(*counters: tuple[str, int]) -> GateStatus:
    return GateStatus(
        robot="r", profile="sim", session=1, epoch=1, state=GateState.ARMED, cause="", fix="",
        latch_id=0, stop_ids=(), claims=(), counters=counters, state_tick=1,
        lockstep_allowed=True, config_hash=NO_HASH, robot_hash=NO_HASH,
    )  # fmt: skip


def test_chunks_are_counted_by_outcome_and_findings_are_said_in_words() -> None:
    counters = (("released", 9), ("refused", 1), ("copies", 0), ("G002", 3), ("G020", 1))
    assert gate_lines(gate_with(*counters)) == [
        "gate   armed",
        "judged released 9, refused 1",
        "       G002 3 times: other HAL session or robot",
        "       G020 1 times: limit",
    ]


def ended(kind: str, **verdicts: int) -> Progress:
    result = GoalResult(
        outcome="failed", decided_by="runner", kind=kind, detail="", first_tick=1, last_tick=2
    )
    return Progress("ended", 2, 20.0, verdicts, 1, 0, "", result)


def test_a_run_that_did_not_succeed_names_the_next_command() -> None:
    gate = gate_with()
    assert goal_hints(ended("deadline", released=9), gate, "arm_runner") == []
    assert goal_hints(ended("deadline", released=9, refused=3), gate, "arm_runner") == [
        "3 of 12 chunks were refused; see why: fairlead why"
    ]
    told = ended("stalled", released=9, refused=2)
    assert told.result is not None
    result = structs.replace(told.result, detail="no released row for 30 s; 3 of 13 chunks refused")
    assert goal_hints(replace(told, result=result), gate, "arm_runner") == [
        "see why chunks were refused: fairlead why"
    ], "the runner has counted those whose verdicts have not been heard here"
    assert goal_hints(ended("policy_error"), gate, "arm_runner") == [
        "what the policy printed, tracebacks too: fairlead logs arm_runner"
    ]


def test_what_a_goal_that_was_refused_is_told_to_try_is_no_part_of_the_sentence() -> None:
    why = str(RefusedError("safety", "the gate is latched", "fairlead reset 1f"))
    result = GoalResult(
        outcome="failed", decided_by="runner", kind="refused", detail=why, first_tick=0, last_tick=0
    )
    goal = GoalFeedback(
        source="runner", goal_id=1, skill="wave", phase="", tick=0, queue_depth=0, inferences=0,
        starved=0, last_refusal="", result=result,
    )  # fmt: skip
    assert goal_line(goal) == (
        "wave failed (decided by the runner): safety refused: the gate is latched; "
        "try: fairlead reset 1f"
    )


def test_a_gate_that_judged_nothing_says_so() -> None:
    assert gate_lines(gate_with(("released", 0))) == ["gate   armed", "judged nothing yet"]


def test_a_disk_that_is_nearly_full_is_warned_of(tmp_path: Path) -> None:
    assert full_disk(tmp_path, least_bytes=0) == ""
    assert full_disk(tmp_path / "deleted", least_bytes=2**62) == ""
    said = full_disk(tmp_path, least_bytes=2**62)
    assert said.startswith(f"{tmp_path}: ") and "MB left on its disk" in said
