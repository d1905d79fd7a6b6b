"""A contract against the checkpoint's statistics: constant but routed, active but discarded."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from fairlead.errors import ConfigError
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.manifest import load_skill
from fairlead_tools.skills.checkpoint_stats import (
    contract_findings,
    named_outputs,
    read_checkpoint_stats,
)
from tests.cli.command import fairlead_here as fairlead

STATS = Path(__file__).parent / "stats"
RLDX = load_skill("rldx1-ft-rc365-nf4")
PI05 = load_skill("pi05-robocasa365-human300-nf4")
FORMS = ("lerobot", "openpi", "rldx")
ARM = [
    {"range": [0, 5], "control_mode": "cartesian_delta", "ee": "gripper", "frame": "base_link"},
    {"range": [6, 6], "control_mode": "gripper_position", "ee": "gripper"},
]


def findings(form: str, contract: ActionContract = PI05.action_contract) -> list[str]:
    read = read_checkpoint_stats(STATS / f"{form}.json", named_outputs(RLDX))
    assert read.form == form
    return contract_findings(contract, read.actions)


def contract(*slots: dict[str, Any]) -> ActionContract:
    return ActionContract.model_validate({"dim": 12, "slots": [*ARM, *slots]})


@pytest.mark.parametrize("form", FORMS)
def test_the_shipped_contract_fits_what_was_trained(form: str) -> None:
    assert findings(form) == []


@pytest.mark.parametrize("form", FORMS)
def test_a_base_that_moved_in_training_but_is_discarded_is_reported(form: str) -> None:
    old = contract({"range": [7, 10], "discard": True}, {"range": [11, 11], "discard": True})
    assert findings(form, old) == [
        "dimension 7: active in training (std 0.21), but discarded",
        "dimension 8: active in training (std 0.14), but discarded",
        "dimension 9: active in training (std 0.17), but discarded",
        "dimension 11: active in training (std 0.62), but discarded",
    ]


@pytest.mark.parametrize("form", FORMS)
def test_a_twist_that_is_one_dimension_off_is_reported_at_both_ends(form: str) -> None:
    shifted = contract(
        {"range": [7, 7], "discard": True},
        {"range": [8, 10], "control_mode": "body_twist", "axes": [0, 1, 5]},
        {"range": [11, 11], "control_mode": "composite_mode"},
    )
    assert findings(form, shifted) == [
        "dimension 7: active in training (std 0.21), but discarded",
        "dimension 10: constant in training (std 0), but slot [8, 10] body_twist commands it",
    ]


def test_named_outputs_are_joined_in_the_skills_order_and_not_the_files() -> None:
    by_file = read_checkpoint_stats(STATS / "rldx.json").actions
    by_skill = read_checkpoint_stats(STATS / "rldx.json", named_outputs(RLDX)).actions
    assert [stats.constant for stats in by_skill].index(True) == 10
    assert [stats.constant for stats in by_file].index(True) == 5


def changed(tmp_path: Path, **actions: Any) -> Path:
    path = tmp_path / "stats.json"
    document = json.loads((STATS / "openpi.json").read_text())
    document["norm_stats"]["actions"] = {
        key: value
        for key, value in (document["norm_stats"]["actions"] | actions).items()
        if value is not None
    }
    path.write_text(json.dumps(document))
    return path


def test_quantiles_decide_where_there_is_no_deviation(tmp_path: Path) -> None:
    read = read_checkpoint_stats(changed(tmp_path, std=None))
    assert [stats.constant for stats in read.actions].index(True) == 10
    assert read.actions[10].evidence == "q01 0, q99 0"
    assert read.actions[9].evidence == "q01 -1, q99 1"


def test_constant_padding_beyond_the_contract_is_no_finding_and_active_padding_is(
    tmp_path: Path,
) -> None:
    std = json.loads((STATS / "openpi.json").read_text())["norm_stats"]["actions"]["std"]
    padded = read_checkpoint_stats(changed(tmp_path, std=std + [0.0] * 20)).actions
    assert contract_findings(PI05.action_contract, padded) == []
    wider = read_checkpoint_stats(changed(tmp_path, std=[*std, 0.5])).actions
    assert contract_findings(PI05.action_contract, wider) == [
        "action_contract: dim 12, the statistics have 13"
    ]
    narrower = read_checkpoint_stats(changed(tmp_path, std=std[:11])).actions
    assert contract_findings(PI05.action_contract, narrower) == [
        "action_contract: dim 12, the statistics have 11"
    ]


@pytest.mark.parametrize(
    ("content", "text"),
    [
        ("{", "not JSON: "),
        ("[" * 100_000, "not JSON: "),
        ("[]", "expected a map, got list"),
        ('{"state": {}}', "no action statistics (valid: action, norm_stats.actions, "
         "<embodiment>.action.<name>; the file has: state)"),
        ('{"norm_stats": {"state": {}}}', "norm_stats.actions: expected a map of statistics"),
        ('{"action": {"mean": [1]}}',
         "action: expected std, min and max, or q01 and q99, got mean"),
        ('{"action": {"std": [1, NaN]}}', "action.std: expected finite numbers, got nan"),
        ('{"action": {"std": [1, true]}}', "action.std: expected finite numbers, got True"),
        ('{"action": {"min": [1, 2], "max": [3]}}', "action.max: expected 2 numbers, got 1"),
        ('{"a": {"action": {"x": {"std": [1]}}}, "b": {"action": {"x": {"std": [1]}}}}',
         "expected one of its embodiments, got none named (valid: a, b)"),
        ('{"a": {"action": {"x": {"std": [1]}}}}',
         "a.action: expected outputs y, got no y (valid: x)"),
    ],
)  # fmt: skip
def test_a_file_that_does_not_fit_names_what_is_wrong(
    tmp_path: Path, content: str, text: str
) -> None:
    path = tmp_path / "stats.json"
    path.write_text(content)
    with pytest.raises(ConfigError) as caught:
        read_checkpoint_stats(path, ("y",))
    assert str(caught.value).startswith(f"{path}: ")
    assert text in str(caught.value)


def test_one_of_several_embodiments_can_be_named(tmp_path: Path) -> None:
    path = tmp_path / "stats.json"
    path.write_text(
        '{"a": {"action": {"x": {"std": [1]}}}, "b": {"action": {"x": {"std": [0, 0]}}}}'
    )
    assert len(read_checkpoint_stats(path, embodiment="b").actions) == 2
    with pytest.raises(ConfigError, match="got 'c' \\(valid: a, b\\)"):
        read_checkpoint_stats(path, embodiment="c")


def test_skill_check_compares_with_the_statistics_and_its_exit_status_says_the_outcome(
    tmp_path: Path,
) -> None:
    good = STATS / "rldx.json"
    done = fairlead("skill", "check", RLDX.id, "--stats", str(good), "--json", state=tmp_path)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout)["statistics"] == {
        "file": str(good), "form": "rldx", "findings": [],
    }  # fmt: skip
    still = changed(tmp_path, std=[0.3] * 9 + [0.0, 0.0, 0.6])
    done = fairlead("skill", "check", PI05.id, "--stats", str(still), state=tmp_path)
    assert done.returncode == 1
    assert done.stdout == (
        f"{PI05.id} may run on panda_mobile\n"
        f"{PI05.id} does not fit what {still} was trained on:\n"
        "  dimension 9: constant in training (std 0), but slot [7, 9] joint_velocity commands it\n"
    )
    done = fairlead("skill", "check", PI05.id, "--stats", str(tmp_path / "no"), state=tmp_path)
    assert done.returncode == 2
