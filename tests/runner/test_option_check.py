"""A policy's options are checked without loading the policy."""

from __future__ import annotations

from typing import get_args

import pytest

from fairlead.errors import ConfigError
from fairlead.skill.manifest import PolicyBackend, PolicySpec, load_skill, skill_ids
from fairlead_skill_runner.policies.option_check import CHECKS, check_policy_options


def test_every_backend_has_a_check() -> None:
    assert set(CHECKS) == set(get_args(PolicyBackend))


@pytest.mark.parametrize("name", skill_ids())
def test_the_options_of_every_skill_that_ships_fit(name: str) -> None:
    check_policy_options(load_skill(name))


@pytest.mark.parametrize(
    ("name", "change", "text"),
    [
        ("rldx-robocasa", {"adress": "tcp://x:1"},
         "rldx policy: 1 problem(s):\n  adress: unknown key, did you mean address? (valid: "),
        ("rldx-robocasa", {"state": {"all": [0, 14]}},
         "rldx policy: state: expected every index of 0..15 once"),
        ("pi05-robocasa365-human300-nf4", {"answer_timeout_s": 60},
         "openpi policy: answer_timeout_s: expected less than the skill's inference_timeout_s"),
        ("oracle-counter-to-cabinet", {"speed": 2},
         "oracle policy: 1 problem(s):\n  speed: unknown key (valid: horizon)"),
    ],
)  # fmt: skip
def test_options_that_do_not_fit_are_named(name: str, change: dict[str, object], text: str) -> None:
    skill = load_skill(name)
    policy = PolicySpec.model_validate(
        {"backend": skill.policy.backend, "options": {**skill.policy.options, **change}}
    )
    with pytest.raises(ConfigError) as caught:
        check_policy_options(skill.model_copy(update={"policy": policy}))
    assert str(caught.value).startswith(text)
