"""Where the gate takes every link to be, against pinocchio on the robot's own description."""

from __future__ import annotations

import json

import numpy as np
import pinocchio as pin
import pytest

from fairlead.paths import gate_config
from fairlead.robot.manifest import load_robot
from tests.gate.joint_samples import samples
from tests.gate.link_poses import gate_links

pytestmark = pytest.mark.processes

ROBOTS = ("panda", "panda_mobile", "dual_panda")
TOLERANCE = 1e-9  # [m], [rad], [m/s], [rad/s]
COUNT = 10_000


@pytest.mark.parametrize("name", ROBOTS)
def test_every_link_is_where_pinocchio_says_and_moves_as_it_says(name: str) -> None:
    robot, config = load_robot(name), gate_config(name, "sim")
    tree = json.loads(config.read_text())["kinematics"]
    links = [tree["root"], *(link["name"] for link in tree["links"])]
    positions, velocities = samples(robot, COUNT)
    ours = gate_links(config, positions, velocities)
    assert ours.shape[1] == len(links)

    model = pin.buildModelFromUrdf(str(robot.description_path()))
    data = model.createData()
    ids = [model.getFrameId(link, pin.FrameType.BODY) for link in links]
    columns = [
        (model.joints[model.getJointId(joint)].idx_q, robot.measured_joint_names.index(joint))
        for joint in list(model.names)[1:]
    ]
    into, out_of = np.array(columns).T
    q, v = np.zeros(model.nq), np.zeros(model.nv)
    assert len(into) == model.nq == model.nv
    worst = 0.0
    for sample in range(COUNT):
        q[into], v[into] = positions[sample, out_of], velocities[sample, out_of]
        pin.forwardKinematics(model, data, q, v)
        pin.updateFramePlacements(model, data)
        for link, frame in enumerate(ids):
            truth, row = data.oMf[frame], ours[sample, link]
            turn = truth.rotation.T @ pin.Quaternion(row[3:7]).toRotationMatrix()
            motion = pin.getFrameVelocity(model, data, frame, pin.LOCAL_WORLD_ALIGNED)
            errors = (row[:3] - truth.translation, pin.log3(turn), row[7:] - motion.vector)
            worst = max(worst, *(float(np.abs(error).max()) for error in errors))
    assert worst <= TOLERANCE
