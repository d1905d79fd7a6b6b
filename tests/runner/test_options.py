"""The runner's block in a deployment file."""

from __future__ import annotations

from typing import Any

import pytest

from fairlead.errors import ConfigError
from fairlead_skill_runner.options import check_runner_options

ORACLE = "oracle-counter-to-cabinet"


def test_by_default_a_runner_offers_every_skill_made_for_its_robot() -> None:
    options = check_runner_options("runner", {})
    assert ORACLE in options.manifests("panda_mobile")
    with pytest.raises(ConfigError) as caught:
        options.manifests("aloha")
    assert str(caught.value).startswith("runner: expected a skill made for aloha, got none (valid:")


def test_named_skills_and_policies_are_taken() -> None:
    policy = {"backend": "constant", "options": {"row": [0.0] * 12}}
    options = check_runner_options("runner", {"skills": [ORACLE], "policies": {ORACLE: policy}})
    assert list(options.manifests("panda_mobile")) == [ORACLE]
    assert options.policies[ORACLE].backend == "constant"


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"skill": ORACLE}, "skill: Extra inputs are not permitted"),
        ({"skills": []},
         "skills: Tuple should have at least 1 item after validation, not 0"),
        ({"policies": {"x": {"backend": "oracle"}}, "skills": [ORACLE]},
         "options: Value error, policies: expected one of this runner's skills, got 'x' "
         f"(valid: {ORACLE})"),
        ({"policies": {ORACLE: {"backend": "magic"}}},
         f"policies.{ORACLE}.backend: Input should be 'oracle', 'joint_reach', 'replay', "
         "'constant', 'openpi', 'rldx_zmq' or 'python'"),
    ],
)  # fmt: skip
def test_options_that_do_not_fit_are_named(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        check_runner_options("runner", options)
    assert str(caught.value) == f"service runner: options:\n  {text}"
