"""The runner's block in a deployment file."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError
from fairlead.robot.manifest import load_robot
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.offered_skills import OfferedSkills
from fairlead_skill_runner.options import RunnerOptions

ORACLE = "oracle-counter-to-cabinet"
BACKENDS = (
    "valid: constant, go_to, joint_reach, lerobot, onnx, openpi, oracle, oracle_reach_cube, "
    "python, replay, rldx_zmq "
    "from fairlead 0.1.0"
)


def checked(options: dict[str, Any]) -> RunnerOptions:
    return checked_model("service runner: options", RunnerOptions, options)


def offered(options: RunnerOptions, robot: str = "panda_mobile") -> dict[str, SkillManifest]:
    return OfferedSkills("runner", options, load_robot(robot), "sim").at_start()


def test_by_default_a_runner_offers_every_skill_made_for_its_robot() -> None:
    assert ORACLE in offered(checked({}))
    assert offered(checked({}), "dual_panda").keys() == {"dual-panda-lift"}


def test_named_skills_and_policies_are_taken() -> None:
    policy = {"backend": "constant", "options": {"row": [0.0] * 12}}
    options = checked({"skills": [ORACLE], "policies": {ORACLE: policy}})
    assert list(offered(options)) == [ORACLE]
    assert options.policies[ORACLE].backend == "constant"


@pytest.mark.parametrize(
    ("options", "text"),
    [
        ({"skill": ORACLE}, "skill: unknown key, did you mean skills? (valid: skills, trace, "
         "policies, servers, added_latency_ms)"),
        ({"skills": []},
         "skills: expected at least 1 item, got 0"),
        ({"policies": {"x": {"backend": "oracle"}}, "skills": [ORACLE]},
         "policies: expected one of this runner's skills, got 'x' "
         f"(valid: {ORACLE})"),
        ({"policies": {ORACLE: {"backend": "magic"}}},
         f"policies: {ORACLE}.backend: expected a policy backend, got 'magic' ({BACKENDS})"),
    ],
)  # fmt: skip
def test_options_that_do_not_fit_are_named(options: dict[str, Any], text: str) -> None:
    with pytest.raises(ConfigError) as caught:
        checked(options)
    assert str(caught.value) == f"service runner: options: 1 problem(s):\n  {text}"


PI05 = "pi05-robocasa365-human300-nf4"


def test_a_server_elsewhere_changes_the_address_and_nothing_else() -> None:
    options = checked({"servers": {PI05: "ws://gpu:9000"}})
    skills = offered(options)
    own = skills[PI05].policy
    elsewhere = {**own.options, "address": "ws://gpu:9000"}
    assert options.policy(skills[PI05]) == own.model_copy(update={"options": elsewhere})
    assert options.policy(skills[ORACLE]) == skills[ORACLE].policy


def test_a_server_elsewhere_may_want_a_key() -> None:
    told = {"address": "ws://gpu:9000", "api_key_env": "GPU_KEY"}
    options = checked({"servers": {PI05: told}})
    own = offered(options)[PI05]
    assert options.policy(own).options == {**own.policy.options, **told}
    keyed = own.policy.model_copy(
        update={"options": {**own.policy.options, "api_key_env": "OWN_KEY"}}
    )
    with_key = own.model_copy(update={"policy": keyed})
    other = checked({"servers": {PI05: "ws://gpu:9000"}})
    assert "api_key_env" not in other.policy(with_key).options, "whose it is, it stays with"


@pytest.mark.parametrize(
    ("skill", "address", "text"),
    [
        (PI05, "gpu:9000", "expected an address such as ws://127.0.0.1:8000, got 'gpu:9000'"),
        ("rldx-robocasa", "ws://gpu:1",
         "expected an address such as tcp://127.0.0.1:5555, got 'ws://gpu:1'"),
        (ORACLE, "ws://gpu:1",
         "expected a skill whose policy is a server, got oracle"),
        ("panda-joint-reach", "ws://gpu:1",
         "expected one of this runner's skills, got 'panda-joint-reach' (valid: "),
    ],
)  # fmt: skip
def test_a_server_that_does_not_fit_is_refused(skill: str, address: str, text: str) -> None:
    options = checked({"servers": {skill: address}})
    with pytest.raises(ConfigError) as caught:
        offered(options)
    assert str(caught.value).startswith(f"runner: servers.{skill}: {text}")


def test_a_skill_is_replaced_in_one_way_only() -> None:
    with pytest.raises(ConfigError, match=f"skill {PI05}: expected it in policies or in servers"):
        checked({"servers": {PI05: "ws://gpu:1"}, "policies": {PI05: {"backend": "oracle"}}})


def test_an_installed_skill_that_does_not_load_is_left_out_by_name_and_the_others_stay(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    folder = tmp_path / "broken"
    folder.mkdir()
    (folder / "rskill.yaml").write_text("id: broken\n", encoding="utf-8")
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    assert ORACLE in offered(checked({}))
    (said,) = caplog.messages
    assert said.startswith(f"skill broken is left out: {folder}/rskill.yaml: 13 problem(s):")
    with pytest.raises(ConfigError, match="broken/rskill.yaml: 13 problem"):
        offered(checked({"skills": ["broken"]}))


def test_an_added_latency_is_for_a_simulator_only() -> None:
    options = checked({"added_latency_ms": 200.0})
    options.check_profile("runner", "sim")
    with pytest.raises(
        ConfigError, match="added_latency_ms: expected 0 in profile hardware, got 200"
    ):
        options.check_profile("runner", "hardware")
    for wrong in (-1.0, 10_001.0, float("nan")):
        with pytest.raises(ConfigError, match="added_latency_ms"):
            checked({"added_latency_ms": wrong})
