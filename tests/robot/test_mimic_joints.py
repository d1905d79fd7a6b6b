"""Joints of a linkage: their links move with a measured joint; for the gate they are fixed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.robot.description import description_tree
from fairlead.robot.link_poses import link_poses
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_state_assembler.forward_kinematics import ForwardKinematics
from fairlead_tools.shape.convex_part import box
from fairlead_tools.shape.geometry import with_swept_fingers

FINGER = '<joint name="panda_finger_joint2" type="prismatic">'
MIMIC = '<mimic joint="panda_finger_joint1" multiplier="-0.5" offset="-0.01"/>'


class Elsewhere(RobotManifest):
    """A robot whose description a test has changed."""

    file: Path

    def description_path(self) -> Path:
        return self.file


def panda(tmp_path: Path, mimic: str = MIMIC, tool: str = "panda_hand_tcp") -> Elsewhere:
    """One finger is measured, the other one mimics it."""
    robot = load_robot("panda")
    text = robot.description_path().read_text(encoding="utf-8")
    assert FINGER in text
    file = tmp_path / "panda.urdf"
    file.write_text(text.replace(FINGER, FINGER + mimic), encoding="utf-8")
    data = robot.model_dump() | {"file": file}
    data["passive_joints"] = data["passive_joints"][:1]
    data["end_effectors"] = [data["end_effectors"][0] | {"tool_frame": tool}]
    del data["safety"]["sim"]["measured"]["panda_finger_joint2"]
    del data["simulator"]["joints"]["panda_finger_joint2"]
    del data["home"]["positions"]["panda_finger_joint2"]
    return Elsewhere.model_validate(data)


def test_a_mimic_joint_moves_its_link_by_its_multiplier_and_offset(tmp_path: Path) -> None:
    robot = panda(tmp_path)
    tree = description_tree(robot)
    (finger,) = [link for link in tree.links if link.name == "panda_rightfinger"]
    assert (finger.joint, finger.kind) == (None, "fixed"), "what the gate gets"
    assert tree.coupled == {"panda_rightfinger"}
    positions = np.zeros(len(robot.measured_joint_names))
    positions[robot.measured_joint_names.index("panda_finger_joint1")] = 0.03
    at = dict(zip(robot.measured_joint_names, positions[:, None], strict=True))
    poses = link_poses(tree, at)
    hand, other = poses["panda_hand"], poses["panda_rightfinger"]
    in_hand = hand.rotation[0].T @ (other.translation[0] - hand.translation[0])
    np.testing.assert_allclose(in_hand, [0.0, -0.5 * 0.03 - 0.01, 0.0584], atol=1e-12)
    assembler = ForwardKinematics(robot)
    found = assembler.poses(positions)[assembler.frames["panda_rightfinger"]]
    np.testing.assert_allclose(found.translation, other.translation[0], atol=1e-12)


def test_a_link_of_a_linkage_counts_as_everywhere_it_can_be(tmp_path: Path) -> None:
    robot = panda(tmp_path)
    finger = {"panda_rightfinger": [box(np.array([0.01, 0.01, 0.01]))]}
    pieces = with_swept_fingers(robot, description_tree(robot), finger)["panda_hand"]
    across = np.concatenate([piece.points for piece in pieces])[:, 1]
    np.testing.assert_allclose([across.min(), across.max()], [-0.04, 0.0], atol=1e-9)


@pytest.mark.parametrize(
    ("mimic", "tool", "text"),
    [
        (MIMIC.replace("finger_joint1", "elbow"), "panda_hand_tcp",
         "joint 'panda_finger_joint2': mimic: expected a joint the robot measures, got "),
        (MIMIC.replace("panda_finger_joint1", "panda_gripper"), "panda_hand_tcp",
         "what moves link 'panda_rightfinger' mimics: expected a joint that moves a link, got "),
        (MIMIC.replace("-0.5", "half"), "panda_hand_tcp",
         "mimic: multiplier: expected a number, got 'half'"),
        (MIMIC, "panda_rightfinger",
         "end effector 'gripper': tool_frame: expected no link that a mimic joint moves, got "),
    ],
)  # fmt: skip
def test_a_mimic_joint_that_cannot_be_followed_is_refused(
    mimic: str, tool: str, text: str, tmp_path: Path
) -> None:
    with pytest.raises(ConfigError) as caught:
        description_tree(panda(tmp_path, mimic, tool))
    assert text in str(caught.value)
