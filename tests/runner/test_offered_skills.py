"""What a runner offers: its skills as their files say now, and nothing that cannot run."""

from __future__ import annotations

import logging
import os
from pathlib import Path

import pytest

from fairlead.errors import ConfigError, RefusedError
from fairlead.robot.manifest import load_robot
from fairlead_skill_runner.offered_skills import OfferedSkills
from fairlead_skill_runner.options import RunnerOptions
from fairlead_tools.skills.skeleton import skill_skeleton
from tests.shape.own_robot import own_robot

MOBILE = load_robot("panda_mobile")


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A skill of the user's own, my-wave."""
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    (tmp_path / "my-wave").mkdir()
    for name, text in skill_skeleton("my-wave", MOBILE).items():
        (tmp_path / "my-wave" / name).write_text(text)
    return tmp_path / "my-wave"


def offer(**options: object) -> OfferedSkills:
    return OfferedSkills("runner", RunnerOptions.model_validate(options), MOBILE, "sim")


def edit(file: Path, old: str, new: str) -> None:
    text = file.read_text()
    assert old in text
    file.write_text(text.replace(old, new))
    stat = file.stat()  # a clock as coarse as an edit is quick would hide it
    os.utime(file, ns=(stat.st_atime_ns, stat.st_mtime_ns + 1))


@pytest.mark.asyncio
async def test_a_skill_that_did_not_change_keeps_its_policy_and_one_that_did_gets_a_new_one(
    folder: Path,
) -> None:
    skills = offer()
    first = await skills.worker(skills.find("my-wave").skill)
    assert await skills.worker(skills.find("my-wave").skill) is first
    edit(folder / "policy.py", "def reset", "def  reset")
    second = await skills.worker(skills.find("my-wave").skill)
    assert second is not first
    (folder / "weights.txt").write_text("one")
    third = await skills.worker(skills.find("my-wave").skill)
    assert third is not second
    edit(folder / "weights.txt", "one", "two")
    second = await skills.worker(skills.find("my-wave").skill)
    assert second is not third
    edit(folder / "rskill.yaml", "version: 0.1.0", "version: 0.2.0")
    changed = skills.find("my-wave").skill
    assert changed.version == "0.2.0"
    assert await skills.worker(changed) is not second


def test_a_skill_is_held_against_the_robot_once_until_its_manifest_is_edited(folder: Path) -> None:
    skills = offer()
    first = skills.find("my-wave")
    assert skills.find("my-wave") is first
    edit(folder / "rskill.yaml", "rate_hz: 20", "rate_hz: 30")
    second = skills.find("my-wave")
    assert (first.problems(), second.problems() != []) == ([], True)


@pytest.mark.asyncio
async def test_a_robot_that_is_edited_is_read_anew_with_its_skills_and_their_policies(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot_file = own_robot(tmp_path, monkeypatch) / "robot.yaml"
    options = RunnerOptions(skills=("panda-joint-reach",))
    skills = OfferedSkills("runner", options, load_robot("mine"), "sim")
    first = skills.find("panda-joint-reach")
    worker = await skills.worker(first.skill)
    edit(robot_file, "horizon_max: 64", "horizon_max: 1")
    second = skills.find("panda-joint-reach")
    asked = "horizon: expected at most 1, got"
    assert (asked in str(first.problems()), asked in str(second.problems())) == (False, True)
    assert await skills.worker(second.skill) is not worker
    assert skills.find("panda-joint-reach") is second
    robot_file.rename(tmp_path / "away")
    with pytest.raises(ConfigError, match="robot.yaml"):
        skills.find("panda-joint-reach")


@pytest.mark.parametrize(
    ("one", "other", "same"),
    [
        ("ws://localhost:8000", "ws://127.0.0.1:8000", True),
        ("ws://127.0.0.1:8000", "ws://127.0.0.1:8000/policy", True),
        ("ws://localhost:8000", "ws://127.0.0.1:8001", False),
        ("ws://127.0.0.1", "wss://127.0.0.1", False),
        ("ws://nowhere.invalid:8000", "ws://nowhere.invalid:8000", True),
        ("ws://nowhere.invalid:8000", "ws://127.0.0.1:8000", False),
    ],
)
def test_two_names_of_one_server_are_one_policy(one: str, other: str, same: bool) -> None:
    """Loaded ahead, the other would be asked while it answers the goal that runs."""
    options = {"start": "-", "connect_timeout_s": 4.0, "answer_timeout_s": 4.0}
    policies = {
        name: {"backend": "openpi", "options": options | {"address": address}}
        for name, address in (("oracle-counter-to-cabinet", one), ("bc-counter-to-cabinet", other))
    }
    skills = offer(policies=policies)
    first, second = (skills.find(name).skill for name in policies)
    assert skills.share_a_policy(first, second) == same


def test_a_skill_that_came_after_the_start_is_on_offer(folder: Path) -> None:
    skills = offer()
    assert "my-wave" in skills.at_start()
    folder.rename(folder.parent / "away")
    with pytest.raises(
        RefusedError,
        match="expected a skill on offer, got 'my-wave' .valid: bc-counter-to-cabinet, go-to",
    ):
        skills.find("my-wave")
    (folder.parent / "away").rename(folder)
    assert skills.find("my-wave").skill.id == "my-wave"


@pytest.mark.parametrize(
    ("old", "new", "text"),
    [
        ("  backend: python", "  backend: pyhton",
         "policy.backend: expected a policy backend, got 'pyhton' (valid: constant, go_to, "
         "joint_reach, lerobot, onnx, openpi, oracle, oracle_reach_cube, python, replay, "
         "rldx_zmq from fairlead 0.1.0)"),
        ("id: my-wave", "idd: my-wave", "idd: unknown key"),
    ],
)  # fmt: skip
def test_a_skill_that_cannot_run_is_said_and_the_others_are_offered(
    folder: Path, old: str, new: str, text: str, caplog: pytest.LogCaptureFixture
) -> None:
    edit(folder / "rskill.yaml", old, new)
    with caplog.at_level(logging.ERROR):
        found = offer().at_start()
    assert "oracle-counter-to-cabinet" in found and "my-wave" not in found
    assert "skill my-wave is left out: " in caplog.text and text in caplog.text
    with pytest.raises(ConfigError) as caught:
        offer(skills=["my-wave"]).at_start()
    assert text in str(caught.value)


def test_a_skill_for_another_robot_is_not_on_offer_unless_it_is_named() -> None:
    with pytest.raises(RefusedError, match="fairlead skill ls --robot panda_mobile"):
        offer().find("panda-joint-reach")
    named = offer(skills=["panda-joint-reach"])
    assert named.find("panda-joint-reach").skill.id == "panda-joint-reach"
