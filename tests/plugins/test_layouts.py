"""A layout from another package: listed, loaded, assembled; a broken one is in nobody's way."""

import json
from pathlib import Path

import pytest

from tests.assembler.every_layout import LAYOUT_DIMS
from tests.plugins.package import fairlead, install, run
from tests.repo.tree import ROOT

pytestmark = pytest.mark.processes

SAMPLE = (ROOT / "docs" / "examples" / "gripper_pose_8d.py").read_text()
OURS = (
    "valid: aloha, base_pose_6d, gr1, human300_16d, libero, libero_eef8d, mobile_pick_30d, "
    "panda_omron_53d, rc365 "
    "from fairlead 0.1.0"
)
ASSEMBLE = """
import numpy as np
from fairlead.layout import load_layout
from fairlead_state_assembler import JointPositions, TransformBuffer, assemble_state, pose_from
bindings = load_layout("gripper_pose_8d").example
buffer = TransformBuffer()
buffer.add("base_link", "grip_site", pose_from("grip_site", [1.0, 2.0, 3.0], [0, 0, 0.6, 0.8]), 1,
           is_static=False)
joints = JointPositions.named(bindings.gripper_qpos_joints, np.array([0.5, -0.25]))
print(assemble_state("gripper_pose_8d", bindings, joints, buffer.at(1)).round(9).tolist())
"""
LOAD = """
import sys
from fairlead.errors import ConfigError
from fairlead.layout import load_layout
for name in sys.argv[1:]:
    try:
        print(load_layout(name).dim)
    except ConfigError as error:
        print(error)
"""


def with_layout(site: Path, value: str, text: str, name: str = "gripper_pose_8d") -> None:
    install(site, "acme-layouts", {"fairlead.layouts": {name: value}}, {"acme_layouts.py": text})


def loaded(site: Path, *names: str) -> list[str]:
    """What loading each layout says in one process: its width, or the error."""
    return run(site, "-c", LOAD, *names).stdout.splitlines()


def test_a_layout_of_another_package_assembles_and_is_listed_with_its_package(
    tmp_path: Path,
) -> None:
    with_layout(tmp_path, "acme_layouts:LAYOUT", SAMPLE)
    done = run(tmp_path, "-c", ASSEMBLE)
    assert (done.returncode, done.stderr) == (0, "")
    assert json.loads(done.stdout) == [1.0, 2.0, 3.0, 0.0, 0.0, 0.6, 0.8, 0.75]
    listed = fairlead(tmp_path, "layout", "ls", "--json")
    rows = {row["layout"]: row for row in json.loads(listed.stdout)}
    assert rows["gripper_pose_8d"] == {
        "layout": "gripper_pose_8d",
        "dim": 8,
        "required_bindings": ["eef_frame", "base_frame", "gripper_qpos_joints"],
        "content": "end effector in the base, opening of the gripper",
        "package": "acme-layouts 1.2",
    }
    assert rows["libero"]["package"] == "fairlead 0.1.0"


def test_an_unknown_name_is_refused_with_every_name_and_where_it_comes_from(tmp_path: Path) -> None:
    with_layout(tmp_path, "acme_layouts:LAYOUT", SAMPLE)
    assert loaded(tmp_path, "smolvla_9d") == [
        "expected a layout, got 'smolvla_9d' (valid: gripper_pose_8d from acme-layouts 1.2; "
        f"{OURS.removeprefix('valid: ')})"
    ]


@pytest.mark.parametrize(
    ("value", "text", "complaint"),
    [
        (
            "acme_layouts:LAYOUT",
            "import torrch\n",
            "acme_layouts:LAYOUT cannot be imported: ModuleNotFoundError: No module named "
            "'torrch'; mend or uninstall that package",
        ),
        (
            "acme_layouts:LAYOT",
            SAMPLE,
            "acme_layouts:LAYOT cannot be imported: AttributeError: module 'acme_layouts' has no "
            "attribute 'LAYOT'; mend or uninstall that package",
        ),
        (
            "acme_layouts:LAYOUT",
            "raise SystemExit(3)\n",
            "acme_layouts:LAYOUT cannot be imported: SystemExit: 3; mend or uninstall that package",
        ),
        (
            "acme_layouts:LAYOUT",
            "LAYOUT = 8\n",
            "acme_layouts:LAYOUT: expected a fairlead.layout.Layout, got 8",
        ),
        (
            "acme_layouts:LAYOUT",
            SAMPLE.replace("    dim=8,", "    dim=None,"),
            "expected dim and assemble, or neither of them",
        ),
        (
            "acme_layouts:LAYOUT",
            SAMPLE.replace("    dim=8,", '    dim="8",'),
            "dim: expected at least 1, or None, got '8'",
        ),
        (
            "acme_layouts:LAYOUT",
            SAMPLE.replace('"eef_rotation_frame"', '"eef_rotation"'),
            "required and optional: expected binding fields, got eef_rotation (valid: eef_frame, "
            "eef_rotation_frame, base_frame, world_frame, gripper_qpos_joints, joint_names, "
            "quaternion_convention, quaternion_signs, object_frame, goal_frame)",
        ),
    ],
)
def test_a_broken_layout_is_named_with_its_package_and_breaks_nothing_else(
    value: str, text: str, complaint: str, tmp_path: Path
) -> None:
    with_layout(tmp_path, value, text)
    who = "layout 'gripper_pose_8d' of acme-layouts 1.2: "
    assert loaded(tmp_path, "gripper_pose_8d", "libero") == [f"{who}{complaint}", "9"]
    listed = fairlead(tmp_path, "layout", "ls")
    assert (listed.returncode, listed.stderr) == (0, f"{who}{complaint}\n")
    assert "human300_16d" in listed.stdout


def test_a_name_that_two_packages_register_is_refused_with_both(tmp_path: Path) -> None:
    with_layout(tmp_path, "acme_layouts:LAYOUT", SAMPLE, name="libero")
    assert loaded(tmp_path, "libero", "aloha") == [
        "layout 'libero': acme-layouts 1.2 and fairlead 0.1.0 register it; uninstall one of them",
        "14",
    ]


def test_looking_names_up_imports_none_of_them(tmp_path: Path) -> None:
    with_layout(tmp_path, "acme_layouts:LAYOUT", "raise RuntimeError('imported')\n")
    code = "import sys; from fairlead import load_skill; load_skill('panda-joint-reach'); print("
    code += "sorted(m for m in sys.modules if m.startswith(('acme', 'fairlead.layouts.'))))"
    done = run(tmp_path, "-c", code)
    assert done.stdout.strip() == "['fairlead.layouts.libero']", done.stderr


@pytest.mark.parametrize(
    "path",
    [ROOT / f"shared/fairlead/layouts/{name}.py" for name in LAYOUT_DIMS],
    ids=lambda path: path.stem,
)
def test_layout_that_ships_says_slice_unit_and_source_of_every_number(path: Path) -> None:
    text = path.read_text()
    assert "    slice    content " in text
    assert " unit   source\n" in text
    assert "Raises:\n        LayoutError:" in text
