"""A new layout is one name, one row and one file: shown on a copy of the two packages."""

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from tests.repo.tree import ROOT

SAMPLE = ROOT / "docs" / "examples" / "gripper_pose_8d.py"
NAME = ('    "gr1",\n]', '    "gr1",\n    "gripper_pose_8d",\n]')
ROW = (
    "LAYOUTS: dict[StateLayout, LayoutShape] = {",
    "LAYOUTS: dict[StateLayout, LayoutShape] = {\n"
    '    "gripper_pose_8d": LayoutShape(8, ("eef_frame", "base_frame", "gripper_qpos_joints")),',
)
ASSEMBLE = """
import numpy as np
from fairlead.skill.bindings import LAYOUT_DIMS, StateContract
from fairlead_state_assembler import (
    LAYOUT_EXAMPLES, JointPositions, TransformBuffer, assemble_state, pose_from
)
name = "gripper_pose_8d"
bindings = LAYOUT_EXAMPLES[name]()
contract = StateContract(layout=name, dim=LAYOUT_DIMS[name], bindings=bindings)
buffer = TransformBuffer()
buffer.add("base_link", "grip_site", pose_from("grip_site", [1.0, 2.0, 3.0], [0, 0, 0.6, 0.8]), 1,
           is_static=False)
joints = JointPositions.named(bindings.gripper_qpos_joints, np.array([0.5, -0.25]))
print(assemble_state(contract.layout, bindings, joints, buffer.at(1)).round(9).tolist())
"""
LIST = "import sys; sys.argv = ['fairlead', 'layout', 'ls', '--json']; "
LIST += "from fairlead.cli.main import main; main()"


class Copy:
    """A copy of the shared package and the assembler that nothing else sees."""

    def __init__(self, root: Path) -> None:
        self._paths = [root / "shared", root / "assembler"]
        ignored = shutil.ignore_patterns("__pycache__")
        for source, target in (
            ("shared/fairlead", root / "shared" / "fairlead"),
            (
                "services/state_assembler/fairlead_state_assembler",
                root / "assembler" / "fairlead_state_assembler",
            ),
        ):
            shutil.copytree(ROOT / source, target, ignore=ignored)
        self.bindings = root / "shared" / "fairlead" / "skill" / "bindings.py"
        self.layouts = root / "assembler" / "fairlead_state_assembler" / "layouts"

    def edit(self, *changes: tuple[str, str]) -> None:
        text = self.bindings.read_text()
        for old, new in changes:
            assert text.count(old) == 1, old
            text = text.replace(old, new)
        self.bindings.write_text(text)

    def run(self, code: str) -> subprocess.CompletedProcess[str]:
        path = os.pathsep.join(map(str, self._paths))
        return subprocess.run(
            [sys.executable, "-c", code],
            env=os.environ | {"PYTHONPATH": path},
            capture_output=True,
            text=True,
            timeout=60,
            check=False,
        )


@pytest.fixture
def copy(tmp_path: Path) -> Copy:
    return Copy(tmp_path)


def test_name_row_and_file_make_a_layout_that_loads_assembles_and_is_listed(copy: Copy) -> None:
    copy.edit(NAME, ROW)
    shutil.copy(SAMPLE, copy.layouts)
    done = copy.run(ASSEMBLE)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == [1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8, 0.75]
    listed = {row["layout"]: row for row in json.loads(copy.run(LIST).stdout)}
    assert listed["gripper_pose_8d"] == {
        "layout": "gripper_pose_8d",
        "dim": 8,
        "required_bindings": ["eef_frame", "base_frame", "gripper_qpos_joints"],
        "content": "end effector in the base, opening of the gripper.",
    }


def test_file_without_the_name_is_refused_because_the_set_is_closed(copy: Copy) -> None:
    shutil.copy(SAMPLE, copy.layouts)
    done = copy.run("import fairlead_state_assembler")
    assert done.returncode == 1
    assert done.stderr.splitlines()[-1] == (
        "fairlead.errors.ConfigError: StateLayout: expected a declared layout, got "
        "'gripper_pose_8d' (valid: human300_16d, rc365, mobile_pick_30d, libero_eef8d, "
        "base_pose_6d, libero, aloha, gr1)"
    )


@pytest.mark.parametrize("text", ["", "def example_empty_3d(): ...\n"])
def test_file_that_registers_nothing_is_refused_by_its_name(copy: Copy, text: str) -> None:
    (copy.layouts / "empty_3d.py").write_text(text)
    done = copy.run("import fairlead_state_assembler")
    assert done.stderr.splitlines()[-1] == (
        "fairlead.errors.ConfigError: layouts/empty_3d.py: expected a function registered as "
        "'empty_3d' and example_empty_3d()"
    )


def test_file_without_an_example_is_refused(copy: Copy) -> None:
    copy.edit(NAME, ROW)
    text = SAMPLE.read_text().replace("example_gripper_pose_8d", "sample")
    (copy.layouts / SAMPLE.name).write_text(text)
    done = copy.run("import fairlead_state_assembler")
    assert done.stderr.splitlines()[-1] == (
        "fairlead.errors.ConfigError: layouts/gripper_pose_8d.py: expected a function registered "
        "as 'gripper_pose_8d' and example_gripper_pose_8d()"
    )


@pytest.mark.parametrize(
    "path",
    sorted((ROOT / "services/state_assembler/fairlead_state_assembler/layouts").glob("[!_]*.py")),
    ids=lambda path: path.stem,
)
def test_layout_file_is_one_short_page_with_slice_unit_and_source(path: Path) -> None:
    text = path.read_text()
    assert 30 <= text.count("\n") <= 60
    assert text.count("@register") == 1
    assert "    slice    content " in text
    assert " unit   source\n" in text
    assert "Raises:\n        LayoutError:" in text
