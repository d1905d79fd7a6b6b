"""Where one answer goes over to the next: what is proposed, to the last row and bit."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from pydantic import ValidationError

from fairlead.errors import ConfigError
from fairlead.messages import FloatArray, Outcome, floats
from fairlead.modes import ControlMode
from fairlead.plugins import Plugin
from fairlead.policy import Observation, PastAnswer
from fairlead.skill.manifest import SeamSpec, SkillManifest
from fairlead_skill_runner.chunk_tracker import CHUNKS_REMEMBERED
from fairlead_skill_runner.policies.backends import make_policy
from fairlead_skill_runner.seam import ReleasedRows, Seam
from fairlead_skill_runner.trace import TraceRecord, TraceWriter, read_trace
from tests.runner.broken_policies import Misbehaving
from tests.runner.scripted_robot import ROBOT, SKILL, Story, rows, story
from tests.runner.seam_parts import BLEND, part

N_DOF = 2


def blended(
    mode: ControlMode, old: npt.ArrayLike, new: npt.ArrayLike, *, last: int, now: int
) -> FloatArray:
    """The new rows, of ticks 4, 5, ...; the old are of ticks 1, 2, ..."""
    before = ReleasedRows((part(mode, old),), 1, last)
    width = mode.width(N_DOF)
    (made,) = Seam(before, now, BLEND).blended([part(mode, new)], [width], 4)
    return floats(made.values, width)


@pytest.mark.parametrize(
    "mode",
    [ControlMode.JOINT_POSITION, ControlMode.JOINT_VELOCITY, ControlMode.CARTESIAN_DELTA,
     ControlMode.CARTESIAN_TWIST, ControlMode.BODY_TWIST],
)  # fmt: skip
def test_rows_lead_over_evenly_and_then_are_the_answer_to_the_bit(mode: ControlMode) -> None:
    one = np.ones(mode.width(N_DOF))
    old, new = np.outer(np.arange(1, 11), one), np.outer([-0.1 / 3] * 8, one)
    made = blended(mode, old, new, last=10, now=4)
    assert made[:2].tolist() == old[3:5].tolist(), "the row of tick 5 may act, if a message is lost"
    between = [old[5 + k] + (k + 1) / (BLEND + 1) * (new[0] - old[5 + k]) for k in range(BLEND)]
    assert made[2 : 2 + BLEND] == pytest.approx(np.array(between))
    assert made[2 + BLEND :].tobytes() == new[2 + BLEND :].tobytes()


def test_where_released_rows_end_within_the_seam_the_last_one_goes_on() -> None:
    old, new = [[1.0, 1.0]] * 5 + [[2.0, 2.0]], [[6.0, 6.0]] * 8
    made = blended(ControlMode.JOINT_POSITION, old, new, last=6, now=4)
    assert made[:, 0].tolist() == [1.0, 1.0, 3.0, 4.0, 5.0, 6.0, 6.0, 6.0]


def test_released_rows_that_were_truncated_count_only_as_far_as_they_were_released() -> None:
    old, new = [[1.0, 1.0]] * 6 + [[9.0, 9.0]] * 4, [[5.0, 5.0]] * 8
    made = blended(ControlMode.JOINT_POSITION, old, new, last=6, now=4)
    assert made[:, 0].tolist() == [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0]


def test_the_last_released_row_leads_over_while_it_acts() -> None:
    new = [[5.0, 5.0]] * 8
    made = blended(ControlMode.JOINT_POSITION, [[1.0, 1.0]] * 4, new, last=4, now=4)
    assert made[:, 0].tolist() == [1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0, 5.0]


@pytest.mark.parametrize(
    "mode",
    [ControlMode.GRIPPER_POSITION, ControlMode.GRIPPER_BINARY, ControlMode.COMPOSITE_MODE,
     ControlMode.DEX_HAND_JOINT],
)  # fmt: skip
def test_grippers_hands_and_switches_change_at_once(mode: ControlMode) -> None:
    new = np.ones((8, mode.width(N_DOF)))
    made = blended(mode, np.zeros((10, mode.width(N_DOF))), new, last=10, now=4)
    assert made.tobytes() == new.tobytes()


def test_a_pose_turns_about_one_axis_the_short_way() -> None:
    def turned(angle: float, sign: float = 1.0) -> list[float]:
        half = angle / 2
        return [0.0, 0.0, 0.0, 0.0, 0.0, sign * math.sin(half), sign * math.cos(half)]

    made = blended(ControlMode.CARTESIAN_POSE, [turned(0.0)] * 10, [turned(1.0, -1.0)] * 8,
                   last=10, now=2)  # fmt: skip
    assert made[0] == pytest.approx(turned(1.0 / (BLEND + 1)))
    assert np.linalg.norm(made[:, 3:], axis=1) == pytest.approx(np.ones(8))
    assert made[BLEND:].tolist() == [turned(1.0, -1.0)] * (8 - BLEND)


def test_a_part_whose_mode_changes_is_not_blended() -> None:
    before = ReleasedRows((part(ControlMode.JOINT_VELOCITY, [[1.0, 1.0]] * 10),), 1, 10)
    new = part(ControlMode.JOINT_POSITION, [[6.0, 6.0]] * 8)
    assert Seam(before, 4, BLEND).blended([new], [2], 4) == (new,)


# --- in a goal -----------------------------------------------------------------------


def with_seam(blend_ticks: int = BLEND) -> SkillManifest:
    seam = {"seam": {"blend_ticks": blend_ticks}}
    return SkillManifest.model_validate(SKILL.model_dump(mode="json") | seam)


def arm(run: Story) -> FloatArray:
    """Of the newest chunk, the arm's numbers along x."""
    index = ROBOT.part_names.index("arm")
    (found,) = [one for one in run.chunk.parts if one.part == index]
    return floats(found.values, 6)[:, 0]


def second_answer(skill: SkillManifest) -> tuple[Story, FloatArray]:
    run = story(lockstep=False, skill=skill)
    run.tick(10)
    run.answer(rows(8, 0.0))
    run.judge(first=11)
    for tick in range(11, 16):
        run.tick(tick)
    assert run.seen_ticks() == [10, 15]
    run.answer(rows(8, 0.4))
    return run, arm(run)


def test_a_skill_with_a_seam_leads_from_released_rows_to_the_answer() -> None:
    _, made = second_answer(with_seam())
    whole = made[-1]
    assert whole > 0.0
    # Observed and answered in 15: the row of 16 can act, and that of 17 if a message is lost.
    assert made / whole == pytest.approx([0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0, 1.0])


def test_without_a_seam_an_answer_is_proposed_as_it_is() -> None:
    _, made = second_answer(SKILL)
    assert len(set(made.tolist())) == 1


def test_in_lockstep_nothing_is_blended() -> None:
    run = story(lockstep=True, skill=with_seam())
    run.tick(10)
    run.answer(rows(8, 0.0))
    run.judge()
    for tick in range(11, 19):
        run.tick(tick)
    assert run.seen_ticks() == [10, 18]
    run.answer(rows(8, 0.4))
    assert len(set(arm(run).tolist())) == 1


def test_a_seam_is_no_longer_than_the_rows_until_the_next_answer() -> None:
    assert with_seam(SKILL.execute_steps).seam == SeamSpec(blend_ticks=SKILL.execute_steps)
    with pytest.raises(ValidationError, match=r"seam.blend_ticks: expected at most execute_steps"):
        with_seam(SKILL.execute_steps + 1)
    with pytest.raises(ValidationError, match="greater than or equal to 1"):
        with_seam(0)


class Continues(Misbehaving):
    """Real-time chunking: makes its seams itself."""

    continues_rows = True


def test_a_policy_that_continues_rows_is_not_blended_as_well() -> None:
    plugin = Plugin("policy backend", "continues", f"{__name__}:Continues", "tests")
    make_policy(plugin, SKILL, {}, lambda: ROBOT, "sim")
    with pytest.raises(ConfigError, match="seam: expected none, for the policy continues the rows"):
        make_policy(plugin, with_seam(), {}, lambda: ROBOT, "sim")


def test_however_many_answers_are_refused_the_next_leads_over_from_the_rows_that_act() -> None:
    skill = SkillManifest.model_validate(
        with_seam().model_dump(mode="json") | {"horizon": 40, "age_max_ticks": 60}
    )
    run = story(lockstep=False, skill=skill)
    run.tick(10)
    run.answer(rows(40, 0.1))
    run.judge(first=11)
    acting = arm(run)[-1]
    tick = 10
    while run.chunk.seq <= 1 + CHUNKS_REMEMBERED:
        tick += 1
        run.tick(tick)
        if run.seen_ticks()[-1] == tick:
            run.answer(rows(40, 0.5))
            run.judge(Outcome.REFUSED)
    assert tick < 10 + 40 - BLEND, "the first answer's rows still act"
    proposed = arm(run)
    assert proposed[0] == acting and proposed[-1] == pytest.approx(5 * acting)


def test_the_prefix_is_what_acts_until_the_answer_can_and_a_period_on() -> None:
    run = story(lockstep=False)
    run.tick(10)
    run.tick(11)
    run.tick(12)
    numbered = rows(8, 0.0) + np.arange(8, dtype=np.float32)[:, None]
    run.answer(numbered)  # in tick 12: three ticks after its observation
    run.judge(first=13)
    run.tick(13)
    assert run.seen_ticks() == [10, 13]
    seen = run.asked[-1].observation
    assert seen.delay_ticks == 3
    assert seen.rows_to_act()[:, 0].tolist() == [3.0, 4.0, 5.0, 6.0, 7.0]
    assert seen.prefix().tobytes() == numbered[3:7].tobytes()
    run.answer(rows(8, 0.1))
    assert [one.observation.prefix().shape for one in run.asked] == [(0, 0), (4, 12)]


def test_an_answer_that_waits_for_its_verdict_is_part_of_the_prefix() -> None:
    first = rows(8, 0.0) + np.arange(8, dtype=np.float32)[:, None]
    none, last = np.zeros(8, np.bool_), np.arange(8) == 7
    answers = (
        PastAnswer(10, first, 1, "released", none, none, last),
        PastAnswer(12, first + 10, 1, "", none, none, none),
    )
    seen = Observation(17, np.zeros(30), "", answers=answers, delay_ticks=4)
    assert seen.rows_to_act()[:, 0].tolist() == [7.0]
    assert seen.prefix()[:, 0].tolist() == [7.0, 16.0, 17.0]
    alone = replace(seen, answers=answers[1:])
    assert len(alone.prefix()) == 0, "no row acts in tick 17 itself"


def test_the_trace_has_what_was_said_and_what_was_proposed_of_it(tmp_path: Path) -> None:
    writer = TraceWriter(tmp_path / "trace.jsonl")
    said = TraceRecord(7, np.arange(3.0), rows(2), chunk=b"proposed")
    writer.write(said)
    writer.write(replace(said, tick=8, chunk=b""))
    writer.close()
    first, second = read_trace(tmp_path / "trace.jsonl")
    assert (first.tick, first.chunk, second.tick, second.chunk) == (7, b"proposed", 8, b"")
    assert first.actions.tobytes() == said.actions.tobytes()
