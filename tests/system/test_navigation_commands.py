"""Navigation and manipulation from the command line, in the real simulator."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from fairlead.deploy.registry import Registry
from fairlead.messages import GateState
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.cli.command import fairlead_here as fairlead

pytestmark = [pytest.mark.processes, pytest.mark.simulator, pytest.mark.timeout(300)]

SOURCE = repo_root() / "compose" / "panda_mobile_navigation.yaml"
ORACLE = "oracle-counter-to-cabinet"
Command = Callable[..., subprocess.CompletedProcess[str]]


@pytest.fixture(scope="module")
def robot(tmp_path_factory: pytest.TempPathFactory, registry: Registry) -> Iterator[ScratchRobot]:
    folder = tmp_path_factory.mktemp("navigation") / "state"
    with scratch_robot(make_scratch(SOURCE, folder, ScratchOptions()), registry) as running:
        yield running


@pytest.fixture
def do(robot: ScratchRobot) -> Command:
    """A command of ``fairlead`` about this robot, run to its end."""

    def run(*words: str) -> subprocess.CompletedProcess[str]:
        file = str(robot.scratch.file)
        return fairlead(*words, "--deployment", file, state=robot.scratch.state_dir / "registry")

    return run


def test_after_a_goal_that_failed_the_next_one_is_not_begun(do: Command) -> None:
    done = do("run", "go-to", "--prompt", "9 9 0", "--then", ORACLE)
    assert done.returncode == 1
    [failed] = done.stdout.splitlines()
    assert failed.startswith("go-to failed after 1 ticks (decided by the policy): ")
    assert "goal_outside_zones: at 9 9 0 the base would be 5.25 m outside" in failed


def test_with_json_goals_one_after_the_other_are_one_document(do: Command) -> None:
    done = do("run", "go-to", "--prompt", "0 0.1 0", "--then", "go-to: 9 9 0", "--json")
    assert done.returncode == 1, done.stderr
    document = json.loads(done.stdout)
    outcomes = [goal["result"]["outcome"] for goal in document["goals"]]
    assert (document["chain"], outcomes) == ("go-to", ["succeeded", "failed"])


def test_a_skill_that_does_not_exist_is_said_before_the_first_goal_begins(do: Command) -> None:
    done = do("run", "go-to", "--prompt", "0 0 0", "--then", "no-such-skill")
    assert (done.returncode, done.stdout) == (1, "")
    assert "no-such-skill" in done.stderr
    assert "Traceback" not in done.stderr


CHAIN = """
goals:
  - {name: far, skill: go-to, prompt: 9 9 0, deadline_ticks: 100, retries: 3,
     on_failure: {goal_outside_zones: typo}}
  - {name: never, skill: go-to, prompt: 0 0 0, deadline_ticks: 100}
  - {name: typo, skill: go-to, prompt: there, deadline_ticks: 100, retries: 1,
     on_failure: {any: near}}
  - {name: near, skill: go-to, prompt: 0 0.1 0, deadline_ticks: 300}
most_goals: 4
"""


def test_a_chain_goes_on_by_how_each_goal_ended(
    robot: ScratchRobot, do: Command, tmp_path: Path
) -> None:
    file = tmp_path / "chain.yaml"
    file.write_text(CHAIN)
    done = do("run", str(file), "--seed", "0")
    *goals, ending = done.stdout.splitlines()
    assert [line.split(" (")[0] for line in goals[:3]] == ["go-to failed after 1 ticks"] * 3
    assert "goal_outside_zones" in goals[0] and "bad_goal" in goals[1] and "bad_goal" in goals[2]
    assert goals[3].startswith("go-to succeeded after ")
    assert (ending, done.returncode) == (f"{file} succeeded after 4 goals", 0)
    assert robot.client.gate_status().state == GateState.DISARMED


def test_a_chain_that_failed_says_at_which_goal_and_exits_with_1(
    do: Command, tmp_path: Path
) -> None:
    file = tmp_path / "chain.yaml"
    file.write_text(CHAIN.replace("most_goals: 4", "most_goals: 3"))
    done = do("run", str(file), "--json")
    assert done.returncode == 1
    ending = json.loads(done.stdout)
    assert len(ending.pop("goals")) == 3
    assert ending == {
        "chain": str(file), "outcome": "failed",
        "why": "most_goals: 3 goals have run, and near would be the next",
    }  # fmt: skip


def test_no_command_ends_the_claim_of_another_unasked(robot: ScratchRobot, do: Command) -> None:
    robot.client.arm()
    with robot.client.claim(["base"], source="planner", task="drive"):
        episode = do("run", ORACLE, "--seed", "0")
        assert (episode.returncode, episode.stdout) == (1, "")
        assert "a new episode would end the claim of planner, which runs drive" in episode.stderr
        assert "disarm" not in episode.stderr
        refused = do("run", ORACLE)
        assert "part base is held by planner (drive)" in refused.stdout
        assert "try: fairlead cancel planner (if no runner: end" in refused.stdout
        cancelled = do("cancel", "planner")
        assert "expected a runner, got 'planner' (valid: navigation, manipulation)" in (
            cancelled.stderr
        )
        said = do("status").stdout
        assert "claim  planner runs drive on base" in said
        assert f"goal   manipulation: {ORACLE} failed (decided by the runner): " in said
        idle = do("cancel", "navigation")
        assert "no goal" in idle.stderr
        [claim] = robot.client.gate_status().claims
        assert claim.source == "planner"
    robot.client.disarm()


def test_at_a_stopped_gate_run_names_the_reset_that_leads_on(
    robot: ScratchRobot, do: Command
) -> None:
    stop = robot.client.stop("test")
    for words in (["--seed", "0"], []):
        done = do("run", ORACLE, *words)
        assert done.returncode == 1
        assert f"try: fairlead reset {stop:016x}" in done.stderr
        assert "disarm" not in done.stderr.replace("disarmed", "")
    robot.client.reset(stop)
    assert robot.client.gate_status().state == GateState.DISARMED
