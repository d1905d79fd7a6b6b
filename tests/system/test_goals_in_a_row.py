"""One goal after the other on a robot that stays where the last one left it."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
import yaml

from fairlead.deploy.registry import Registry
from fairlead.messages import GateState, GoalResult, Verdict, decode, floats
from fairlead.modes import ControlMode
from fairlead.operate.goal_run import GoalOptions, run_goal
from fairlead.paths import repo_root, rskill_dir
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Sample
from fairlead.wire.verdict_text import describe
from fairlead_tools.record.run_log import newest_log, read_run
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.cli.command import fairlead_here as fairlead

pytestmark = [pytest.mark.processes, pytest.mark.timeout(180)]

SKILL = "panda-joint-reach"
PLANNER = "own-planner"
SLOW = "own-slow-reach"
POLICY = """
from fairlead.policy import Done


class Policy:
    @classmethod
    def from_options(cls, skill, options):
        return cls()

    def reset(self):
        pass

    def infer(self, observation):
        return Done("it is there already")
"""


def write_planner(folder: Path) -> None:
    """A skill of a user's own that says itself when it is done."""
    manifest = yaml.safe_load((rskill_dir(SKILL) / "rskill.yaml").read_text(encoding="utf-8"))
    policy = {"backend": "python", "options": {"file": "policy.py", "class": "Policy"}}
    folder.mkdir(parents=True)
    (folder / "policy.py").write_text(POLICY, encoding="utf-8")
    own = manifest | {"id": PLANNER, "policy": policy, "decided_by": "policy"}
    (folder / "rskill.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")


def write_slow(folder: Path) -> None:
    """The reach at half the robot's rate, its targets met evenly."""
    manifest = yaml.safe_load((rskill_dir(SKILL) / "rskill.yaml").read_text(encoding="utf-8"))
    folder.mkdir(parents=True)
    half = {"rate_hz": manifest["rate_hz"] / 2, "between": "linear", "seam": None}
    own = manifest | {"id": SLOW} | half
    (folder / "rskill.yaml").write_text(yaml.safe_dump(own), encoding="utf-8")


class Robot:
    """A panda in plain MuJoCo, and every verdict of its gate."""

    def __init__(self, robot: ScratchRobot, folder: Path) -> None:
        self.client, self.file = robot.client, robot.scratch.file
        self.state, self.registry = folder / "state", folder / "registry"
        self.verdicts: list[Verdict] = []
        self.client.bus.subscribe(self.client.keys.verdict("runner"), self._on_verdict)

    def _on_verdict(self, sample: Sample) -> None:
        self.verdicts.append(decode(Verdict, sample.payload))

    def new_episode(self) -> None:
        if self.client.gate_status().state == GateState.ARMED:
            self.client.disarm()
        self.client.reset_episode(3)
        self.client.arm()

    def goal(self, deadline_ticks: int, skill: str = SKILL) -> GoalResult:
        progress = run_goal(self.client, GoalOptions(skill, deadline_ticks=deadline_ticks))
        assert progress.result is not None
        return progress.result


@pytest.fixture(scope="module", params=["lockstep", "realtime"])
def robot(
    request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory
) -> Iterator[Robot]:
    folder = tmp_path_factory.mktemp(request.param)
    source = repo_root() / "compose" / "panda_mujoco.yaml"
    scratch = make_scratch(source, folder / "state", ScratchOptions(pacing=request.param))
    write_planner(folder / "skills" / PLANNER)
    write_slow(folder / "skills" / SLOW)
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("FAIRLEAD_SKILLS", str(folder / "skills"))
        with scratch_robot(scratch, Registry(folder / "registry")) as made:
            yield Robot(made, folder)


def test_a_goal_that_follows_at_once_has_no_chunk_refused_for_what_the_last_one_did(
    robot: Robot,
) -> None:
    for _ in range(3):
        robot.new_episode()
        for _ in range(2):  # a third would find the scene solved
            result = robot.goal(deadline_ticks=6)
            assert result.outcome == "deadline", result
    said = [describe(verdict) for verdict in robot.verdicts if verdict.code]
    assert not [words for words in said if "the row that acts before" in words]


def test_a_scene_that_was_solved_before_is_no_success_of_the_skill(robot: Robot) -> None:
    robot.new_episode()
    assert robot.goal(deadline_ticks=0).outcome == "succeeded"
    again = robot.goal(deadline_ticks=0)
    assert (again.outcome, again.decided_by, again.kind) == ("failed", "task", "already_solved")
    own = robot.goal(deadline_ticks=0, skill=PLANNER)
    assert (own.outcome, own.decided_by, own.detail) == (
        "succeeded", "policy", "it is there already",
    )  # fmt: skip
    robot.client.disarm()
    done = fairlead("run", SKILL, "--deployment", str(robot.file), state=robot.registry)
    assert done.returncode == 1
    assert re.match(
        f"{SKILL} failed before its first tick \\(decided by the task\\): already_solved: "
        "the task's own check was true before the skill did anything",
        done.stdout,
    ), done.stdout


def test_a_policy_at_half_the_robots_rate_moves_evenly_between_its_rows(robot: Robot) -> None:
    robot.new_episode()
    result = robot.goal(deadline_ticks=0, skill=SLOW)
    assert result.outcome == "succeeded", result
    robot.client.disarm()
    run = read_run(newest_log(robot.state))
    skills = {claim_id for claim_id, claim in run.claims.items() if claim.skill == SLOW}
    chunks = [chunk for chunk in run.chunks if chunk.claim_id in skills]
    assert chunks and all(chunk.horizon % 2 == 0 for chunk in chunks)
    width = load_robot("panda").n_dof
    reach = next(p for p in chunks[0].parts if p.mode == ControlMode.JOINT_POSITION)
    rows = floats(reach.values, width)
    np.testing.assert_allclose(rows[1:-2:2], (rows[0:-2:2] + rows[2::2]) / 2, atol=1e-12)
    assert np.abs(np.diff(rows[:-1], axis=0)).max() > 1e-4, "it moves"
