"""The seam of a goal that goes on with another's claim, whose rows may still act."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from fairlead.messages import HELD, Acted, floats
from fairlead.policy import Observation
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import resolve_routes
from fairlead_skill_runner import run_core
from fairlead_skill_runner.candidate import candidate
from fairlead_skill_runner.chunk_tracker import SentChunk
from fairlead_skill_runner.observation_buffer import TimedObservation
from fairlead_skill_runner.run_setup import RunSetup
from tests.runner.scripted_robot import EXECUTED, SKILL, rows, story

SEAM: dict[str, Any] = {"seam": {"blend_ticks": 4}}
PANDA = load_robot("panda")
REACH = SkillManifest.model_validate(load_skill("panda-joint-reach").model_dump(mode="json") | SEAM)
TICK, STANDS_AT, TARGET = 10, 0.1, 0.5


def first_joint(others_act: bool) -> list[float]:
    """The rows of panda's first joint [rad], of an answer that says `TARGET`."""
    setup = RunSetup(
        source="runner", goal_id=1, skill=REACH, prompt="", deadline_ticks=0,
        routes=resolve_routes(REACH.action_contract, PANDA), stall_timeout_s=5.0, session=1,
        robot_hash=PANDA.robot_hash, lockstep=False, has_task=True, claim_id=1, epoch=1,
        n_dof=PANDA.n_dof, camera_periods={}, periods=1, handed_over=True,
    )  # fmt: skip
    asked = TimedObservation(Observation(TICK, np.zeros(8), ""), TICK)
    answer = np.full((8, REACH.action_contract.dim), TARGET, np.float32)
    stands = np.full(PANDA.n_dof, STANDS_AT)
    made = candidate(setup, 1, asked, answer, TICK, stands, None, others_act)
    found: list[float] = floats(made.parts[0].values, PANDA.n_dof)[:, 0].tolist()
    return found


def test_what_leads_back_to_where_the_joints_are_is_said_only_to_joints_that_hold() -> None:
    held, moving = first_joint(False), first_joint(True)
    assert held[:2] == [STANDS_AT, STANDS_AT] and held[2] < held[3] < held[-1]
    assert moving == [held[-1]] * len(moving)


@pytest.mark.parametrize(("handed_over", "acted", "expected"), [
    (True, EXECUTED, True), (True, HELD, False), (False, EXECUTED, False),
])  # fmt: skip
def test_the_rows_of_the_goal_before_act_until_all_parts_hold(
    handed_over: bool, acted: Acted, expected: bool, monkeypatch: pytest.MonkeyPatch
) -> None:
    said: list[bool] = []

    def noting(*given: Any) -> SentChunk:
        said.append(given[-1])
        return candidate(*given)

    monkeypatch.setattr(run_core, "candidate", noting)
    skill = SkillManifest.model_validate(SKILL.model_dump(mode="json") | SEAM)
    run = story(lockstep=False, skill=skill, handed_over=handed_over)
    run.tick(10)
    run.tick(11, acted=acted)
    run.answer(rows(8, 0.1))
    assert said == [expected]
