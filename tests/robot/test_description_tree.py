"""The description as a tree: what it says, and what is refused with the file's name."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.description import description_tree
from fairlead.robot.gate_file import compile_gate_config
from fairlead.robot.manifest import RobotManifest, load_robot

URDF = load_robot("panda").description_path().read_text(encoding="utf-8")


class Elsewhere(RobotManifest):
    """A robot whose description a test has changed."""

    file: Path

    def description_path(self) -> Path:
        return self.file


def panda(tmp_path: Path, old: str = "", new: str = "") -> Elsewhere:
    assert old in URDF
    file = tmp_path / "panda.urdf"
    file.write_text(URDF.replace(old, new, 1) if old else URDF)
    return Elsewhere(**load_robot("panda").model_dump(), file=file)


def test_every_link_comes_after_its_parent_and_hangs_as_the_file_says(tmp_path: Path) -> None:
    tree = description_tree(panda(tmp_path))
    assert tree.root == "base_link"
    for index, link in enumerate(tree.links):
        assert link.parent in (tree.root, *(before.name for before in tree.links[:index]))
    (second,) = [link for link in tree.links if link.name == "panda_link2"]
    half = 0.707106781186547
    assert second.rotation_xyzw == pytest.approx((-half, 0.0, 0.0, half), abs=1e-14)
    assert (second.joint, second.kind, second.axis) == ("panda_joint2", "revolute", (0, 0, 1))
    (tool,) = [link for link in tree.links if link.name == "panda_hand_tcp"]
    assert (tool.joint, tool.kind, tool.translation) == (None, "fixed", (0.0, 0.0, 0.1034))


def test_a_fixed_joint_needs_no_axis_to_be_read(tmp_path: Path) -> None:
    """Exporters write a direction of no length there."""
    fixed = '<origin xyz="0 0 0.1034" rpy="0 0 0"/>'
    tree = description_tree(panda(tmp_path, fixed, f'{fixed}<axis xyz="0 0 0"/>'))
    (tool,) = [link for link in tree.links if link.name == "panda_hand_tcp"]
    assert (tool.kind, tool.axis) == ("fixed", (1.0, 0.0, 0.0))


BAD = {
    "no XML": ("</robot>", "", "cannot be read as XML: "),
    "two roots": ('<link name="base_link"/>', '<link name="base_link"/><link name="moon"/>',
                  "expected root link 'base_link', got ['base_link', 'moon']"),
    "joint that is not measured": ('<joint name="panda_joint3"', '<joint name="elbow"',
                                   "expected a joint the robot measures, got 'elbow'"),
    "joint of another type": ('<joint name="panda_joint3" type="revolute"',
                              '<joint name="panda_joint3" type="prismatic"',
                              "expected the manifest's type 'revolute', got 'prismatic'"),
    "joint of no known type": ('<joint name="panda_joint3" type="revolute"',
                               '<joint name="panda_joint3" type="floating"',
                               "expected a type, got 'floating'"),
    "no limit": ('<limit lower="-2.8973" upper="2.8973" effort="87" velocity="2.175"/>', "",
                 "joint 'panda_joint1': expected <limit lower="),
    "limit without a speed": (' velocity="2.175"/>', "/>", "limit velocity: expected a number"),
    "axis of no length": ('<axis xyz="0 0 1"/>', '<axis xyz="0 0 0"/>', "expected a direction"),
    "two numbers": ('xyz="0 0 0.333"', 'xyz="0 0.333"', "expected three numbers, got '0 0.333'"),
    "text for a number": ('xyz="0 0 0.333"', 'xyz="0 0 up"', "expected three numbers"),
    "not a finite number": ('xyz="0 0 0.333"', 'xyz="0 0 nan"', "expected three numbers"),
    "a link of its own child": ('<parent link="panda_link0"/>', '<parent link="panda_link3"/>',
                                "links that do not hang on the root: ['panda_hand', "),
}  # fmt: skip


@pytest.mark.parametrize("name", BAD)
def test_a_description_that_is_no_tree_is_refused(name: str, tmp_path: Path) -> None:
    old, new, expected = BAD[name]
    with pytest.raises(ConfigError) as error:
        description_tree(panda(tmp_path, old, new))
    assert str(error.value).startswith(f"{tmp_path}/panda.urdf: ")
    assert expected in str(error.value)


def test_a_frame_that_is_no_link_is_refused_before_the_gate_would(tmp_path: Path) -> None:
    shutil.copy(robot_dir("panda") / "capsules.yaml", tmp_path)
    without_tool = panda(tmp_path, '<link name="panda_hand_tcp"/>', '<link name="hook"/>')
    text = without_tool.file.read_text().replace('"panda_hand_tcp"', '"hook"')
    without_tool.file.write_text(text)
    with pytest.raises(ConfigError) as error:
        compile_gate_config(without_tool, "sim")
    assert str(error.value).startswith(
        "robot panda: end effector 'gripper': expected a link, got 'panda_hand_tcp' (valid: "
    )


@pytest.mark.parametrize(
    ("file", "old", "new", "told"),
    [
        ("capsules.yaml", "hand", "left_inner_finger", "capsules.yaml: capsules"),
        ("robot.yaml", "[base_link]", "[left_outer_knuckle]", "cartesian_delta: frames"),
    ],
)
def test_a_finger_has_no_place_of_its_own_in_the_gate(
    file: str, old: str, new: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It would be judged where it was measured, not where its target brings it."""
    folder = tmp_path / "mine"
    shutil.copytree(robot_dir("kinova3"), folder)
    for name, was, now in (("robot.yaml", "id: kinova3", "id: mine"), (file, old, new)):
        text = (folder / name).read_text(encoding="utf-8")
        assert was in text
        (folder / name).write_text(text.replace(was, now), encoding="utf-8")
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(tmp_path))
    with pytest.raises(ConfigError) as error:
        compile_gate_config(load_robot("mine"), "sim")
    wrong = new.strip("[]")
    carries = f"{told}: expected the link that carries this finger, got {wrong!r} (valid: "
    assert carries in str(error.value)
