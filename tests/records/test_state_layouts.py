"""The state vector: the set of layouts, and what each assembles."""

from __future__ import annotations

import ast
import inspect
import json
import subprocess
import sys
from importlib import import_module
from importlib.metadata import entry_points
from pathlib import Path

import numpy as np
import pytest

from fairlead.skill.bindings import StateContractBindings
from fairlead.skill.state_contract import StateContract
from tests.assembler.every_layout import LAYOUT_DIMS, LAYOUTS
from tests.plugins import package
from tests.records.poses import (
    BASE_TURNED,
    FINGERS,
    HAND_TURNED,
    RECORDS_BINDINGS,
    assembled,
    skill_file,
)
from tests.repo.tree import ROOT

LAYOUT_FILES = [ROOT / f"shared/fairlead/layouts/{name}.py" for name in LAYOUT_DIMS]


@pytest.mark.processes
def test_state_06_the_registry_maps_a_layout_to_its_assembler() -> None:
    """load_layout and assemble_state are public and need no transport."""
    assert {name for name, one in LAYOUTS.items() if one.assemble is None} == {"gr1"}
    for name in LAYOUT_DIMS:
        assert getattr(LAYOUTS[name].assemble, "__module__", "") == f"fairlead.layouts.{name}"
    code = "import runpy, sys; sys.modules['zenoh'] = None; runpy.run_path(sys.argv[1])"
    words = [sys.executable, "-c", code, str(ROOT / "docs/examples/layout_in_a_notebook.py")]
    done = subprocess.run(words, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    vector = json.loads(done.stdout)
    assert (len(vector), vector[:3]) == (16, [0.5, 0.0, 1.1])


def test_state_07_only_a_registered_layout_can_be_named() -> None:
    """Only layouts that an installed package registers can be named."""
    installed = ", ".join(sorted(entry_points(group="fairlead.layouts").names))
    with pytest.raises(ValueError, match=rf"a layout, got 'smolvla_9d' \(valid: {installed} from "):
        StateContract.model_validate({"layout": "smolvla_9d", "dim": 9})


@pytest.mark.parametrize("path", LAYOUT_FILES, ids=lambda path: path.stem)
def test_state_08_a_layout_is_one_short_pure_function_without_knowledge_of_a_robot(
    path: Path,
) -> None:
    """A layout's assembler has 30 to 70 lines and names no robot."""
    tree = ast.parse(path.read_text())
    functions = [node for node in tree.body if isinstance(node, ast.FunctionDef)]
    assert [function.name for function in functions] == ["assemble"]
    assert 30 <= len(path.read_text().splitlines()) <= 70
    assert "panda" not in ast.unparse(functions[0]).split('"""')[-1]
    assemble = LAYOUTS[path.stem].assemble
    assert assemble is not None
    outside = inspect.getclosurevars(assemble)
    others = (import_module(f"fairlead.layouts.{name}") for name in LAYOUTS)
    read = {one for one in outside.globals.values() if not isinstance(one, str)}
    assert read <= {assemble, np, *others}
    assert not outside.builtins, "nothing is opened, printed or remembered"


def test_state_09_human300_16d_is_3_and_4_and_3_and_4_and_2() -> None:
    """End effector in base, base in world, gripper: 16 numbers."""
    assert assembled("human300_16d") == [
        *(0.5, 0.1, 1.2, *HAND_TURNED),
        *(2.0, 1.0, 0.0, *BASE_TURNED),
        *(0.03, -0.03),
    ]


def test_state_10_rc365_is_human300_16d_under_another_name() -> None:
    """rc365 gives the same numbers as human300_16d."""
    assert assembled("rc365") == assembled("human300_16d")


def test_state_11_the_quaternion_order_is_what_the_manifest_says() -> None:
    """quaternion_convention holds for every quaternion of the vector."""
    wxyz = assembled("human300_16d", quaternion_convention="wxyz")
    assert wxyz[3:7] == [0.8, *HAND_TURNED[:3]]
    assert wxyz[10:14] == [0.8, *BASE_TURNED[:3]]


def test_state_12_a_gripper_is_two_joints_or_one_that_is_mirrored() -> None:
    """Two gripper numbers: two joints, or one as v and -v."""
    assert assembled("human300_16d", gripper_qpos_joints=FINGERS)[14:] == [0.02, -0.01]
    assert assembled("human300_16d")[14:] == [0.03, -0.03]
    with pytest.raises(ValueError, match="two different joints, or one to be mirrored"):
        StateContractBindings(gripper_qpos_joints=("a", "b", "c"))


def test_state_16_a_layout_cannot_be_spelled_in_a_manifest() -> None:
    """A manifest cannot define a layout."""
    fields = [{"kind": "tf", "frame": "panda_hand"}]
    with pytest.raises(ValueError, match="fields"):
        StateContract.model_validate({"layout": "human300_16d", "dim": 16, "fields": fields})


def test_state_17_every_layout_brings_bindings_to_start_from() -> None:
    """Each layout's example bindings load."""
    for layout, dim in LAYOUT_DIMS.items():
        contract = StateContract(layout=layout, dim=dim, bindings=LAYOUTS[layout].example)
        assert contract.dim == dim


@pytest.mark.processes
def test_state_37_a_layout_is_one_file_and_a_new_one_needs_no_other_change(tmp_path: Path) -> None:
    """A new layout is one file."""
    ours = {one.name: one.value for one in entry_points(group="fairlead.layouts")}
    files = {path.stem for path in (ROOT / "shared/fairlead/layouts").glob("[!_]*.py")}
    assert ours == {name: f"fairlead.layouts.{name}:LAYOUT" for name in files}
    new = (ROOT / "docs/examples/gripper_pose_8d.py").read_text()
    registered = {"fairlead.layouts": {"gripper_pose_8d": "gripper_pose_8d:LAYOUT"}}
    bindings = {key: RECORDS_BINDINGS[key] for key in ("eef_frame", "base_frame")}
    bindings["gripper_qpos_joints"] = ["panda_gripper"]
    contract = {"layout": "gripper_pose_8d", "dim": 8, "bindings": bindings}
    words = ("skill", "check", str(skill_file(tmp_path / "newer", contract)))
    without = package.fairlead(tmp_path / "site", *words)
    assert without.returncode == 1 and "'gripper_pose_8d'" in without.stderr
    package.install(tmp_path / "site", "new-layouts", registered, {"gripper_pose_8d.py": new})
    done = package.fairlead(tmp_path / "site", *words)
    assert "may run on panda_mobile" in done.stdout, done.stdout + done.stderr
