"""Which goal of a chain comes after which."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.messages import GoalResult
from fairlead.operate.chain import Chain, ChainRun, read_chain
from fairlead.operate.failure_kinds import FAILURE_KINDS
from tests.cli.command import fairlead_here

PICK = {"name": "pick", "skill": "my-pick", "deadline_ticks": 600}
DRIVE = {"name": "drive", "skill": "go-to", "prompt": "0 1 0", "deadline_ticks": 400}
PLACE = {"name": "place", "skill": "my-place", "deadline_ticks": 600}


def chain(*goals: dict[str, object], most_goals: int = 20) -> Chain:
    return Chain.model_validate(
        {"goals": goals, "most_goals": most_goals, "own_kinds": ["object_lost"]}
    )


def result(kind: str = "", outcome: str = "failed") -> GoalResult:
    how = outcome if kind else "succeeded"
    return GoalResult(
        outcome=how, decided_by="runner", kind=kind, detail="why", first_tick=1, last_tick=2  # type: ignore[arg-type]
    )  # fmt: skip


def told(run: ChainRun, *kinds: str) -> list[str]:
    """Names of the goals that run, while each ends so."""
    names = []
    for kind in kinds:
        assert run.current is not None, f"it has ended: {run.why}"
        names.append(run.current.name)
        run.ended(result(kind))
    return names


def test_goals_follow_each_other_to_the_end() -> None:
    run = ChainRun(chain(PICK, DRIVE, PLACE))
    assert told(run, "", "", "") == ["pick", "drive", "place"]
    assert (run.current, run.ending, run.why) == (None, "succeeded", "")


def test_a_failed_goal_is_begun_again_as_often_as_it_says() -> None:
    run = ChainRun(chain(PICK | {"retries": 2}, DRIVE))
    assert told(run, "deadline", "stalled", "", "") == ["pick", "pick", "pick", "drive"]
    run = ChainRun(chain(PICK | {"retries": 2}, DRIVE))
    assert told(run, "deadline", "stalled", "deadline") == ["pick"] * 3
    assert (run.ending, run.why, run.begun) == ("failed", "pick: deadline: why", 3)


def test_a_kind_that_is_named_leads_elsewhere_at_once_and_any_once_retries_are_used_up() -> None:
    ways = {"object_lost": "pick", "any": "drive"}
    run = ChainRun(chain(PICK, DRIVE, PLACE | {"retries": 1, "on_failure": ways}))
    seen = told(run, "", "", "object_lost", "", "", "stalled", "stalled", "", "")
    assert seen == ["pick", "drive", "place", "pick", "drive", "place", "place", "drive", "place"]
    assert run.ending == "succeeded"


def test_a_goal_that_is_come_back_to_has_all_its_retries_again() -> None:
    run = ChainRun(chain(PICK | {"retries": 1}, DRIVE | {"on_failure": {"stalled": "pick"}}))
    assert told(run, "x", "", "stalled", "x", "", "") == [
        "pick", "pick", "drive", "pick", "pick", "drive",
    ]  # fmt: skip


def test_success_may_lead_elsewhere_or_end_the_chain() -> None:
    run = ChainRun(chain(PICK | {"on_success": "place"}, DRIVE, PLACE | {"on_success": "done"}))
    assert told(run, "", "") == ["pick", "place"]
    assert run.ending == "succeeded"


def test_a_chain_that_goes_round_ends_after_most_goals() -> None:
    run = ChainRun(chain(PICK | {"on_success": "pick"}, most_goals=3))
    assert told(run, "", "", "") == ["pick"] * 3
    assert (run.ending, run.begun) == ("failed", 3)
    assert run.why == "most_goals: 3 goals have run, and pick would be the next"


@pytest.mark.parametrize("kind", ["claim_lost", "cancelled"])
def test_whoever_stops_the_robot_ends_the_chain(kind: str) -> None:
    run = ChainRun(chain(PICK | {"retries": 5, "on_failure": {"any": "drive"}}, DRIVE))
    run.ended(result(kind, "cancelled" if kind == "cancelled" else "failed"))
    assert (run.current, run.ending) == (None, "failed")


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("goals: []\nmost_goals: 1\n", "at least 1 item"),
        ("goals: [{name: a, skill: s, deadline_ticks: 1}]\n", "most_goals"),
        ("goals: [{name: a, skill: s}]\nmost_goals: 1\n", "deadline_ticks"),
        ("goals: [{name: a, skill: s, deadline_ticks: 99999999999999999999999}]\nmost_goals: 1\n",
         "goals.0.deadline_ticks: Input should be less than"),
        ("goals: [{name: next, skill: s, deadline_ticks: 1}]\nmost_goals: 1\n",
         "expected names of their own, none of next, done, fail, any; got 'next'"),
        ("goals: [{name: a, skill: s, deadline_ticks: 1}, {name: a, skill: s, deadline_ticks: 1}]\n"
         "most_goals: 1\n", "expected names of their own"),
        ("goals: [{name: a, skill: s, deadline_ticks: 1, on_success: b}]\nmost_goals: 1\n",
         "chain.yaml:1:48: goal 'a': on_success: expected one of next, done, a, got 'b'"),
        ("goals: [{name: a, skill: s, deadline_ticks: 1, on_failure: {stalled: done}}]\n"
         "most_goals: 1\n", "goal 'a': on_failure: stalled: expected one of fail, a, got 'done'"),
        ("goals: [{name: a, skill: s, deadline_ticks: 1, on_failure: {claim_lost: a}}]\n"
         "most_goals: 1\n", "goal 'a': on_failure: claim_lost ends the whole chain"),
        ("goals: [{name: a, skill: s, deadline_ticks: 1, on_failure: {deadlin: a}}]\n"
         "most_goals: 1\n", "got 'deadlin' (did you mean deadline?); one that a policy of yours"),
        ("goals: [{name: a, skill: s, deadline_ticks: 1, on_failure: {obect_lost: a}}]\n"
         "most_goals: 1\nown_kinds: [object_lost]\n", "(did you mean object_lost?)"),
        ("goals: [{name: a, skill: s, deadline_ticks: 1}]\nmost_goals: 1\nown_kinds: [Lost]\n",
         "own_kinds.0: "),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused_with_the_file(tmp_path: Path, text: str, said: str) -> None:
    file = tmp_path / "chain.yaml"
    file.write_text(text)
    with pytest.raises(ConfigError) as caught:
        read_chain(file)
    assert str(file) in str(caught.value) and said in str(caught.value)


def test_every_kind_of_failure_may_be_named() -> None:
    kinds = [kind for kind in FAILURE_KINDS if kind not in ("cancelled", "claim_lost")]
    run = ChainRun(chain(PICK | {"on_failure": dict.fromkeys([*kinds, "any"], "pick")}))
    assert told(run, *kinds[:3], "") == ["pick"] * 4


def test_a_goal_knows_what_follows_its_success_as_long_as_the_chain_may_run_on() -> None:
    run = ChainRun(chain(PICK, DRIVE | {"on_success": "pick"}, most_goals=3))
    seen = []
    while run.current is not None:
        seen.append(run.following.name if run.following else "")
        run.ended(result())
    assert seen == ["drive", "pick", ""]
    last = ChainRun(chain(PICK, DRIVE))
    last.ended(result())
    assert last.following is None


def test_a_failure_that_is_named_uses_up_no_retry() -> None:
    run = ChainRun(chain(PICK | {"retries": 1, "on_failure": {"object_lost": "pick"}}))
    assert told(run, "object_lost", "object_lost", "stalled", "") == ["pick"] * 4
    assert run.ending == "succeeded"


def test_more_goals_than_a_chain_may_have_are_a_wrong_command_line(tmp_path: Path) -> None:
    done = fairlead_here("run", "go-to", *["--then", "go-to"] * 1000, state=tmp_path)
    assert (done.returncode, done.stderr) == (
        1, "ERROR run: --then: expected at most 999 goals after the first, got 1000\n"
    )  # fmt: skip


def test_a_goal_whose_skill_there_is_not_is_named(tmp_path: Path) -> None:
    done = fairlead_here("run", "go-to", "--then", "nobody-s", state=tmp_path)
    assert done.returncode == 1
    assert done.stderr.startswith("ERROR goal 2: skill 'nobody-s': ")
