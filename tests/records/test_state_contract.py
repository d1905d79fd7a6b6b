"""The state vector: what a manifest declares, what is admitted, what is refused."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from fairlead.errors import ConfigError, LayoutError
from fairlead.paths import SKILLS_VARIABLE
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.admission import admission_problems
from fairlead.skill.bindings import StateContractBindings
from fairlead.skill.manifest import SkillManifest, load_skill, read_skill
from fairlead.skill.state_contract import StateContract
from fairlead_state_assembler import JointPositions, TransformBuffer, assemble_state, pose_from
from tests.assembler.every_layout import LAYOUTS
from tests.cli.command import fairlead_here as fairlead
from tests.records.poses import (
    FINGERS,
    PI05,
    RECORDED,
    RECORDS_BINDINGS,
    assembled,
    skill_file,
    transforms,
)

TASK_SPACE = ("human300_16d", "rc365", "gr1")
HUMAN300 = {
    "eef place": slice(0, 3), "eef turn": slice(3, 7), "base place": slice(7, 10),
    "base turn": slice(10, 14), "gripper": slice(14, 16),
}  # fmt: skip
OTHERS = "odom, map, object, goal; what others publish is named in tracked_frames of robot.yaml)"


def with_contract(contract: dict[str, Any]) -> SkillManifest:
    return load_skill(PI05).model_copy(
        update={"state_contract": StateContract.model_validate(contract)}
    )


def test_state_01_a_wrapped_layout_is_admitted_on_a_robot_with_another_number_of_joints(
    robot: RobotManifest,
) -> None:
    """A robot of 14 joints may run a skill whose vector has 16 numbers."""
    skill = load_skill(PI05)
    assert len(robot.measured_joint_names) != skill.state_contract.dim == 16
    assert admission_problems(skill, robot) == []


@pytest.mark.parametrize(
    ("binding", "source", "changed"),
    [
        ("eef_frame", "other_hand", {"eef place", "eef turn"}),
        ("base_frame", "other_base", {"eef place", "eef turn", "base place", "base turn"}),
        ("world_frame", "other_world", {"base place", "base turn"}),
        ("gripper_qpos_joints", FINGERS, {"gripper"}),
        ("quaternion_convention", "wxyz", {"eef turn", "base turn"}),
    ],
)
def test_state_02_the_manifest_names_the_shape_and_the_bindings_name_the_sources(
    binding: str, source: object, changed: set[str]
) -> None:
    """A binding changes its own numbers only."""
    bound = StateContractBindings()
    assert (bound.eef_frame, bound.base_frame, bound.world_frame) == (None, None, "map")
    assert (bound.gripper_qpos_joints, bound.quaternion_convention) == ((), "xyzw")
    buffer = transforms()
    for parent, child in (
        ("panda_hand_tcp", "other_hand"), ("base_link", "other_base"), ("other_world", "odom"),
    ):  # fmt: skip
        pose = pose_from(child, [0.1, 0.2, 0.3], [0.1, 0.1, 0.7, 0.7])
        buffer.add(parent, child, pose, 1, is_static=False)
    here, there = (assembled("human300_16d", buffer, **one) for one in ({}, {binding: source}))
    assert {name for name, at in HUMAN300.items() if here[at] != there[at]} == changed


def test_state_03_a_binding_that_does_not_exist_is_refused() -> None:
    """An unknown binding is refused."""
    with pytest.raises(ValueError, match="wrist_frame"):
        StateContractBindings.model_validate(RECORDS_BINDINGS | {"wrist_frame": "panda_hand"})


@pytest.mark.parametrize(("layout", "dim"), [("libero", 9), ("aloha", 14)])
def test_state_04_a_joint_space_layout_needs_no_bindings(layout: str, dim: int) -> None:
    """Layouts of joints alone need no bindings."""
    contract = StateContract.model_validate({"layout": layout, "dim": dim})
    names = (*LAYOUTS[layout].joint_names, *LAYOUTS[layout].gripper_qpos_joints)
    joints = JointPositions.named(names[::-1], np.arange(len(names))[::-1].astype(float))
    found = assemble_state(layout, contract.bindings, joints, TransformBuffer().at(1))
    assert found.tolist() == list(range(dim))


@pytest.mark.parametrize("layout", TASK_SPACE)
def test_state_05_a_task_space_layout_names_every_binding_it_misses_when_it_is_loaded(
    layout: str, tmp_path: Path
) -> None:
    """Composite layouts need bindings, checked when the manifest loads."""
    folder = skill_file(tmp_path / "unbound", {"layout": layout, "dim": LAYOUTS[layout].dim or 39})
    with pytest.raises(ConfigError) as caught:
        read_skill(folder)
    assert f"layout {layout}" in str(caught.value) and str(folder) in str(caught.value)
    assert "also needs eef_frame, base_frame, gripper_qpos_joints" in str(caught.value)


def test_state_13_a_layout_without_an_assembler_is_dropped_with_the_reason(
    robot: RobotManifest,
) -> None:
    """A skill whose layout has no assembler is left out."""
    skill = with_contract({"layout": "gr1", "dim": 39, "bindings": RECORDS_BINDINGS})
    (problem,) = admission_problems(skill, robot)
    assert problem.startswith("layout gr1: no assembler; those that have one: ")
    joints = JointPositions.named(("panda_gripper",), np.zeros(1))
    with pytest.raises(LayoutError, match="layout gr1: no assembler"):
        assemble_state("gr1", skill.state_contract.bindings, joints, transforms().at(1))


def test_state_14_the_list_of_skills_says_which_are_admitted(tmp_path: Path) -> None:
    """The three skills with wrapped layouts are offered."""
    done = fairlead("skill", "ls", "--robot", "panda_mobile", state=tmp_path)
    admitted = [line for line in done.stdout.splitlines() if re.search(r"\badmitted\b", line)]
    for name in (PI05, "rldx1-ft-rc365-nf4", "rldx-robocasa"):
        assert any(name in line for line in admitted), done.stdout


def test_state_15_installing_a_skill_that_lacks_bindings_fails_with_the_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Installing names the missing bindings and installs nothing."""
    monkeypatch.setenv(SKILLS_VARIABLE, str(tmp_path / "installed"))
    folder = skill_file(tmp_path / "unbound", {"layout": "human300_16d", "dim": 16})
    done = fairlead("skill", "install", str(folder), state=tmp_path)
    assert done.returncode == 1
    assert "also needs eef_frame, base_frame, gripper_qpos_joints" in done.stderr
    assert not list((tmp_path / "installed").glob("*/rskill.yaml"))


names = st.text("abcdefgh_", min_size=1, max_size=8)


@settings(max_examples=200)
@given(
    st.fixed_dictionaries(
        {},
        optional={
            "eef_frame": st.none() | names,
            "base_frame": st.none() | names,
            "world_frame": st.none() | names,
            "gripper_qpos_joints": st.lists(names, max_size=3),
            "quaternion_convention": st.sampled_from(["xyzw", "wxyz", "wzyx"]),
        },
    )
)
def test_state_18_any_bindings_are_refused_by_name_or_survive_a_round_trip(
    data: dict[str, Any],
) -> None:
    """Fuzzed bindings are refused or load as written."""
    gripper = data.get("gripper_qpos_joints", [])
    wrong = ["quaternion_convention"] if data.get("quaternion_convention") == "wzyx" else []
    wrong += ["gripper_qpos_joints"] if len(gripper) > len(set(gripper)) % 3 else []
    try:
        bound = StateContractBindings.model_validate(data)
    except ValidationError as error:
        assert wrong, error
        said = "".join(f"{one['loc']} {one['msg']}" for one in error.errors())
        assert any(name in said for name in wrong)
        return
    assert not wrong
    again = StateContractBindings.model_validate(yaml.safe_load(yaml.safe_dump(bound.model_dump())))
    assert again == bound
    assert {key: bound.model_dump(mode="json")[key] for key in data} == data


def test_state_19_the_records_own_manifest_loads_and_is_admitted(
    robot: RobotManifest, tmp_path: Path
) -> None:
    """The first decision's own manifest loads and is admitted."""
    folder = skill_file(tmp_path / "recorded", RECORDED)
    skill = read_skill(folder)
    bound = skill.state_contract.bindings.model_dump(mode="json", exclude_unset=True)
    assert bound == RECORDS_BINDINGS
    assert admission_problems(skill, robot) == []
    done = fairlead("skill", "check", str(folder), "--robot", "panda_mobile", state=tmp_path)
    assert (done.returncode, "may run on panda_mobile" in done.stdout) == (0, True), done.stdout


@pytest.mark.parametrize("binding", ["eef_frame", "base_frame", "world_frame"])
def test_state_36_a_frame_that_the_robot_does_not_have_is_refused_at_check_and_at_install(
    binding: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A frame that the robot lacks is refused at check and install."""
    monkeypatch.setenv(SKILLS_VARIABLE, str(tmp_path / "installed"))
    bindings = RECORDS_BINDINGS | {binding: "no_such_frame"}
    folder = skill_file(tmp_path / "lost", RECORDED | {"bindings": bindings})
    for command in ("check", "install"):
        done = fairlead("skill", command, str(folder), state=tmp_path)
        said = done.stdout + done.stderr
        assert done.returncode == 1
        assert f"{binding}: robot panda_mobile has no frame 'no_such_frame' (valid: " in said
        assert "panda_hand_tcp" in said and OTHERS in said
    assert not list((tmp_path / "installed").glob("*"))
