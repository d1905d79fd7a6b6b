"""A policy backend from another package: checked, loaded in its own process, or named as broken."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.plugins import POLICIES
from fairlead.skill.manifest import PolicySpec, load_skill, skill_ids
from fairlead_skill_runner.policies.backends import check_policy_options, policy_class
from tests.plugins.package import install, run

POLICY = """
import numpy as np
from pydantic import BaseModel, ConfigDict
from fairlead.errors import ConfigError
from fairlead.policy import Done

class Still:
    def __init__(self, ticks):
        self.ticks = ticks

    @classmethod
    def check_options(cls, skill, options):
        if options.keys() - {"ticks"}:
            raise ConfigError("still: unknown option")

    @classmethod
    def from_options(cls, skill, options):
        return cls(options["ticks"])

    def reset(self): ...

    def infer(self, observation):
        return Done("still") if observation.tick > self.ticks else np.zeros((1, 12), np.float32)
"""
LOAD = """
import asyncio
import json
import numpy as np
from fairlead.errors import FairleadError
from fairlead.plugins import POLICIES
from fairlead.policy import Observation
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.backends import check_policy_options
from fairlead_skill_runner.policy_worker import PolicyWorker
ours = load_skill("oracle-counter-to-cabinet")
skill = ours.model_copy(update={"policy": type(ours.policy)(backend="still", options={"ticks": 3})})
async def say():
    worker = PolicyWorker(POLICIES.find("still"), skill, skill.policy.options)
    await worker.load()
    said = [await worker.infer(Observation(tick, np.zeros(30), "")) for tick in (3, 4)]
    print(json.dumps([said[0].shape, said[1].reason]))
    await worker.close()
try:
    check_policy_options(skill)
    asyncio.run(say())
except FairleadError as error:
    print(error)
"""


NO_POLICY = """
class Still:
    @classmethod
    def from_options(cls, skill, options):
        return 3
"""


def load(site: Path, value: str, text: str) -> str:
    install(site, "acme-policies", {"fairlead.policies": {"still": value}}, {"acme.py": text})
    done = run(site, "-c", LOAD)
    assert done.returncode == 0, done.stderr
    return done.stdout.strip()


@pytest.mark.processes
def test_a_policy_of_another_package_is_loaded_and_asked(tmp_path: Path) -> None:
    said = json.loads(load(tmp_path, "acme:Still", POLICY))
    assert said == [[1, 12], "still"]


@pytest.mark.parametrize(
    ("value", "text", "complaint"),
    [
        ("acme:Still", "import torrch\n",
         "acme:Still cannot be imported: ModuleNotFoundError: No module named 'torrch'; mend or "
         "uninstall that package"),
        ("acme:Still", "class Still:\n    def infer(self, observation): ...\n",
         "acme:Still: expected a class with from_options (fairlead.policy.Policy), got <class "
         "'acme.Still'>"),
        ("acme:POLICY", "POLICY = 3\n",
         "acme:POLICY: expected a class with from_options (fairlead.policy.Policy), got 3"),
    ],
)  # fmt: skip
@pytest.mark.processes
def test_a_broken_policy_is_named_with_its_package(
    value: str, text: str, complaint: str, tmp_path: Path
) -> None:
    said = load(tmp_path, value, text)
    assert said == f"policy backend 'still' of acme-policies 1.2: {complaint}"


@pytest.mark.processes
def test_what_is_made_has_to_be_a_policy(tmp_path: Path) -> None:
    assert load(tmp_path, "acme:Still", NO_POLICY) == (
        "policy worker: loading failed: policy backend 'still' of acme-policies 1.2: acme:Still: "
        "expected an object with infer and reset, got 'int without infer and reset'"
    )


NARROW = POLICY.replace("(1, 12)", "(1, 11)")


@pytest.mark.processes
def test_rows_of_another_width_are_known_as_the_policy_is_loaded(tmp_path: Path) -> None:
    assert load(tmp_path, "acme:Still", NARROW) == (
        "policy worker: loading failed: policy backend 'still' of acme-policies 1.2: asked with a "
        "probe observation: policy: expected actions as floats [1 to 8, 12], got float32 [1, 11]\n"
        "  for a policy that cannot be asked before its goal: probe = False in its class"
    )


@pytest.mark.processes
def test_a_policy_that_wants_no_probe_is_asked_for_its_goal_only(tmp_path: Path) -> None:
    shy = POLICY.replace("class Still:", "class Still:\n    probe = False\n").replace(
        "return Done", "assert observation.tick\n        return Done"
    )
    assert json.loads(load(tmp_path, "acme:Still", shy)) == [[1, 12], "still"]


@pytest.mark.parametrize("name", POLICIES.names())
def test_every_policy_that_ships_checks_its_options_without_being_loaded(name: str) -> None:
    assert callable(getattr(policy_class(POLICIES.find(name)), "check_options", None))


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
         "oracle policy: 1 problem(s):\n  speed: unknown key (valid: "
         "horizon, first, last, memory)"),
        ("oracle-counter-to-cabinet", {"first": "RETREAT", "last": "ALIGN"},
         "oracle policy: first: expected a step that is not after last, got RETREAT after ALIGN"),
    ],
)  # fmt: skip
def test_options_that_do_not_fit_are_named(name: str, change: dict[str, object], text: str) -> None:
    skill = load_skill(name)
    policy = PolicySpec.model_validate(
        {"backend": skill.policy.backend, "options": {**skill.policy.options, **change}}
    )
    with pytest.raises(ConfigError) as caught:
        check_policy_options(skill.model_copy(update={"policy": policy}))
    assert str(caught.value).startswith(f"policy.options: {text}")
