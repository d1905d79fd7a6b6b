"""Poses of links against pinocchio's, for the three robots that ship."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

from fairlead.robot.description import description_tree
from fairlead.robot.link_poses import link_poses, random_positions
from fairlead.robot.manifest import load_robot


@pytest.mark.parametrize("name", ["panda", "panda_mobile", "dual_panda"])
def test_links_are_where_pinocchio_has_them(name: str) -> None:
    robot = load_robot(name)
    tree = description_tree(robot)
    positions = random_positions(robot, tree, 50)
    poses = link_poses(tree, positions)
    model = pin.buildModelFromUrdf(str(robot.description_path()))
    data = model.createData()
    for sample in range(50):
        q = pin.neutral(model)
        for joint, values in positions.items():
            q[model.joints[model.getJointId(joint)].idx_q] = values[sample]
        pin.framesForwardKinematics(model, data, q)
        for link in tree.frames:
            truth = data.oMf[model.getFrameId(link, pin.FrameType.BODY)]
            np.testing.assert_allclose(
                poses[link].translation[sample], truth.translation, atol=1e-9
            )
            np.testing.assert_allclose(poses[link].rotation[sample], truth.rotation, atol=1e-9)


def test_random_positions_fill_the_joints_limits_and_are_always_the_same() -> None:
    robot = load_robot("panda")
    tree = description_tree(robot)
    first, second = (random_positions(robot, tree, 10_000) for _ in range(2))
    assert set(first) == {link.joint for link in tree.links} - {None}
    for name, values in first.items():
        joint = robot.joint(name)
        room = joint.upper - joint.lower
        assert joint.lower <= values.min() < joint.lower + 0.01 * room
        assert joint.upper - 0.01 * room < values.max() <= joint.upper
        assert np.array_equal(values, second[name])
