"""The state vector: what a manifest declares, what is admitted, what is refused."""

from __future__ import annotations

import ast
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from fairlead.errors import LayoutError
from fairlead.paths import rskill_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.admission import admission_problems
from fairlead.skill.bindings import StateContractBindings
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.state_contract import StateContract
from fairlead_state_assembler import JointPositions, assemble_state
from tests.assembler.every_layout import LAYOUT_DIMS, LAYOUTS
from tests.cli.command import fairlead_here as fairlead
from tests.records.poses import BASE_TURNED, HAND_TURNED, RECORDS_BINDINGS, transforms
from tests.repo.tree import ROOT

PI05 = "pi05-robocasa365-human300-nf4"
LAYOUT_FILES = [ROOT / f"shared/fairlead/layouts/{name}.py" for name in LAYOUT_DIMS]
TASK_SPACE = ("human300_16d", "rc365", "gr1")
FINGERS = ("panda_finger_joint1", "panda_finger_joint2")


def assembled(layout: str, **changes: Any) -> list[float]:
    bindings = StateContractBindings.model_validate(RECORDS_BINDINGS | changes)
    joints = JointPositions.named(("panda_gripper", *FINGERS), np.array([0.03, 0.02, -0.01]))
    return [float(v) for v in assemble_state(layout, bindings, joints, transforms().at(1)).round(9)]


def with_contract(contract: dict[str, Any]) -> SkillManifest:
    return load_skill(PI05).model_copy(
        update={"state_contract": StateContract.model_validate(contract)}
    )


def test_state_01_a_wrapped_layout_is_admitted_on_a_robot_with_another_number_of_joints(
    robot: RobotManifest,
) -> None:
    """A skill whose vector has 16 numbers is offered on a robot that measures 14 joints."""
    skill = load_skill(PI05)
    assert len(robot.measured_joint_names) != skill.state_contract.dim == 16
    assert admission_problems(skill, robot) == []


def test_state_02_the_manifest_names_the_shape_and_the_bindings_name_the_sources() -> None:
    """`bindings` has end effector, base and world frame, gripper joints, quaternion order."""
    bound = StateContractBindings()
    assert (bound.eef_frame, bound.base_frame, bound.world_frame) == (None, None, "map")
    assert (bound.gripper_qpos_joints, bound.quaternion_convention) == ((), "xyzw")
    assert load_skill(PI05).state_contract.bindings.eef_frame == "grip_site"


def test_state_03_a_binding_that_does_not_exist_is_refused() -> None:
    """Bindings are closed: a field nobody knows is an error, never ignored."""
    with pytest.raises(ValueError, match="wrist_frame"):
        StateContractBindings.model_validate(RECORDS_BINDINGS | {"wrist_frame": "panda_hand"})


@pytest.mark.parametrize(("layout", "dim"), [("libero", 9), ("aloha", 14)])
def test_state_04_a_joint_space_layout_needs_no_bindings(layout: str, dim: int) -> None:
    """Bindings are optional where the layout is a slice of the joints."""
    StateContract.model_validate({"layout": layout, "dim": dim})


@pytest.mark.parametrize("layout", TASK_SPACE)
def test_state_05_a_task_space_layout_names_every_binding_it_misses_when_it_is_loaded(
    layout: str,
) -> None:
    """Bindings are required for composites, and the check is made when a manifest is loaded."""
    with pytest.raises(ValueError, match="also needs eef_frame, base_frame, gripper_qpos_joints"):
        StateContract.model_validate({"layout": layout, "dim": 16})


def test_state_06_the_registry_maps_a_layout_to_its_assembler() -> None:
    """load_layout and assemble_state are the public face, and need no transport."""
    assert {name for name, one in LAYOUTS.items() if one.assemble is None} == {"gr1"}
    assert len(assembled("human300_16d")) == 16


def test_state_07_only_a_registered_layout_can_be_named() -> None:
    """The set is what installed packages register by name: a skill can name nothing else."""
    with pytest.raises(ValueError, match="expected a layout, got 'smolvla_9d' .valid: aloha, "):
        StateContract.model_validate({"layout": "smolvla_9d", "dim": 9})


@pytest.mark.parametrize("path", LAYOUT_FILES, ids=lambda path: path.stem)
def test_state_08_a_layout_is_one_short_pure_function_without_knowledge_of_a_robot(
    path: Path,
) -> None:
    """Each layout file has one assembler in 30 to 70 lines, and its code names no robot."""
    tree = ast.parse(path.read_text())
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    assert [function.name for function in functions] == ["assemble"]
    assert 30 <= len(path.read_text().splitlines()) <= 70
    assert "panda" not in ast.unparse(functions[0]).split('"""')[-1]


def test_state_09_human300_16d_is_3_and_4_and_3_and_4_and_2() -> None:
    """End effector in the base, base in the world, gripper: 16 numbers in that order."""
    assert assembled("human300_16d") == [
        *(0.5, 0.1, 1.2, *HAND_TURNED),
        *(2.0, 1.0, 0.0, *BASE_TURNED),
        *(0.03, -0.03),
    ]


def test_state_10_rc365_is_human300_16d_under_another_name() -> None:
    """The rc365 layout wraps human300_16d: the same bindings give the same numbers."""
    assert assembled("rc365") == assembled("human300_16d")


def test_state_11_the_quaternion_order_is_what_the_manifest_says() -> None:
    """quaternion_convention puts w first or last, in every quaternion of the vector."""
    wxyz = assembled("human300_16d", quaternion_convention="wxyz")
    assert wxyz[3:7] == [0.8, *HAND_TURNED[:3]]
    assert wxyz[10:14] == [0.8, *BASE_TURNED[:3]]


def test_state_12_a_gripper_is_two_joints_or_one_that_is_mirrored() -> None:
    """Two gripper numbers come from two joints as they are, or from one as v and -v."""
    assert assembled("human300_16d", gripper_qpos_joints=FINGERS)[14:] == [0.02, -0.01]
    assert assembled("human300_16d")[14:] == [0.03, -0.03]
    with pytest.raises(ValueError, match="two different joints, or one to be mirrored"):
        StateContractBindings(gripper_qpos_joints=("a", "b", "c"))


def test_state_13_a_layout_without_an_assembler_is_dropped_with_the_reason(
    robot: RobotManifest,
) -> None:
    """Without an assembler the skill stays out, and raw joints never take its place."""
    skill = with_contract({"layout": "gr1", "dim": 39, "bindings": RECORDS_BINDINGS})
    (problem,) = admission_problems(skill, robot)
    assert problem.startswith("layout gr1: no assembler; those that have one: ")
    joints = JointPositions.named(("panda_gripper",), np.zeros(1))
    with pytest.raises(LayoutError, match="layout gr1: no assembler"):
        assemble_state("gr1", skill.state_contract.bindings, joints, transforms().at(1))


def test_state_14_the_list_of_skills_says_which_are_admitted(tmp_path: Path) -> None:
    """The three skills with wrapped layouts are in the robot's palette."""
    done = fairlead("skill", "ls", "--robot", "panda_mobile", state=tmp_path)
    admitted = [line for line in done.stdout.splitlines() if re.search(r"\badmitted\b", line)]
    for name in (PI05, "rldx1-ft-rc365-nf4", "rldx-robocasa"):
        assert any(name in line for line in admitted), done.stdout


def test_state_15_installing_a_skill_that_lacks_bindings_fails_with_the_list(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The missing fields are told when a skill is installed, and nothing is installed."""
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "installed"))
    plain = yaml.safe_load((rskill_dir(PI05) / "rskill.yaml").read_text())
    plain |= {"id": "unbound", "state_contract": {"layout": "human300_16d", "dim": 16}}
    folder = tmp_path / "unbound"
    folder.mkdir()
    (folder / "rskill.yaml").write_text(yaml.safe_dump(plain))
    done = fairlead("skill", "install", str(folder), state=tmp_path)
    assert done.returncode == 1
    assert "also needs eef_frame, base_frame, gripper_qpos_joints" in done.stderr
    assert not list((tmp_path / "installed").glob("*/rskill.yaml"))


def test_state_16_a_layout_cannot_be_spelled_in_a_manifest() -> None:
    """There is no declarative list of fields: the set of layouts is closed."""
    fields = [{"kind": "tf", "frame": "panda_hand"}]
    with pytest.raises(ValueError, match="fields"):
        StateContract.model_validate({"layout": "human300_16d", "dim": 16, "fields": fields})


def test_state_17_every_layout_brings_bindings_to_start_from() -> None:
    """Shape and sources together are a whole contract: each layout's example loads."""
    for layout, dim in LAYOUT_DIMS.items():
        contract = StateContract(layout=layout, dim=dim, bindings=LAYOUTS[layout].example)
        assert contract.dim == dim


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
    """Fuzzed bindings never load as something else than what was written."""
    gripper = data.get("gripper_qpos_joints", [])
    is_valid = len(gripper) <= 2 and len(set(gripper)) == len(gripper)
    is_valid &= data.get("quaternion_convention") != "wzyx"
    try:
        bound = StateContractBindings.model_validate(data)
    except ValueError as error:
        assert not is_valid, error
        return
    assert is_valid
    again = StateContractBindings.model_validate(yaml.safe_load(yaml.safe_dump(bound.model_dump())))
    assert again == bound
    assert {key: bound.model_dump(mode="json")[key] for key in data} == data


def test_state_19_the_records_own_manifest_loads_and_is_admitted(robot: RobotManifest) -> None:
    """panda_hand_tcp, base_link, odom, one gripper joint, xyzw: the record's fixture."""
    contract = {"layout": "human300_16d", "dim": 16, "bindings": RECORDS_BINDINGS}
    assert admission_problems(with_contract(contract), robot) == []
