"""Which of several runners a goal is for: by name, by what they offer, or an error."""

from __future__ import annotations

from typing import Any

import pytest

from fairlead.deploy.deployment import Deployment
from fairlead.errors import ConfigError
from fairlead.operate.runner_choice import choose_runner


def deployment(**skills: list[str] | None) -> Deployment:
    """One with a runner for each name, and the skills that it lists; None: no list."""
    services: dict[str, Any] = {}
    for name, listed in skills.items():
        options = {} if listed is None else {"skills": listed}
        services[name] = {"run": "skill_runner", "options": options}
    return Deployment.model_validate({"robot": "panda_mobile", "id": "r", "services": services})


def refusal(of: Deployment, skill: str, named: str = "") -> str:
    with pytest.raises(ConfigError) as caught:
        choose_runner(of, skill, named)
    return str(caught.value)


def test_the_only_runner_is_asked_whatever_it_lists() -> None:
    assert choose_runner(deployment(runner=["a"]), "b") == "runner"


def test_the_one_that_lists_the_skill_goes_before_the_one_that_offers_all() -> None:
    of = deployment(arm=None, base=["go-to"])
    assert [choose_runner(of, skill) for skill in ("go-to", "wave")] == ["base", "arm"]
    assert choose_runner(of, "go-to", "arm") == "arm"


def test_two_that_could_are_named_and_one_must_be_chosen() -> None:
    words = "skill wave: left and right can run it; choose one: --runner left"
    assert refusal(deployment(left=None, right=None), "wave") == words
    assert refusal(deployment(left=["wave"], right=["wave"]), "wave") == words


def test_where_none_offers_the_skill_all_offers_are_named() -> None:
    assert refusal(deployment(left=["a", "b"], right=["c"]), "wave") == (
        "skill wave: no runner of r offers it (left: a, b; right: c)"
    )


def test_a_name_that_is_no_runner_is_refused_with_the_runners() -> None:
    assert refusal(deployment(left=None, right=None), "wave", "hal") == (
        "deployment r: expected a runner, got 'hal' (valid: left, right)"
    )


def test_a_deployment_without_a_runner_says_so() -> None:
    hal = {"hal": {"run": "hal_sim"}}
    of = Deployment.model_validate({"robot": "panda_mobile", "id": "r", "services": hal})
    assert refusal(of, "wave") == (
        "deployment r: has no skill_runner, so it runs no skills; a program of your own can claim "
        "parts: docs/navigation.md"
    )
