"""The state vector: joints and transforms of a robot become what the checkpoint saw."""

from __future__ import annotations

import re
import shutil
import time
from pathlib import Path

import numpy as np
import pytest
import yaml

from bench.equipment.expert_episode import commands
from fairlead.errors import LayoutError
from fairlead.messages import FloatArray
from fairlead.paths import ROOT_VARIABLE
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.state_contract import StateContract
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_state_assembler import (
    ForwardKinematics,
    LocalAssembler,
)
from tests.records.poses import RECORDED, RECORDS_BINDINGS, transforms
from tests.repo.tree import ROOT

pytestmark = [pytest.mark.simulator, pytest.mark.timeout(300)]

EXACT_BINDINGS: dict[str, object] = {
    "eef_frame": "grip_site",
    "eef_rotation_frame": "panda_hand",
    "base_frame": "base_site",
    "world_frame": "map",
    "gripper_qpos_joints": ["panda_finger_joint1", "panda_finger_joint2"],
}
"""What robosuite's own observations are made of."""

EXACT: dict[str, object] = {"layout": "human300_16d", "dim": 16, "bindings": EXACT_BINDINGS}


def state_vector(
    robot: RobotManifest, backend: RobosuiteBackend, contract: dict[str, object]
) -> FloatArray:
    assembler = LocalAssembler(robot)
    assembler.take(backend.read().positions, backend.transforms(), backend.static_transforms())
    return assembler.assemble(StateContract.model_validate(contract))


@pytest.fixture(scope="module")
def driven(backend: RobosuiteBackend) -> RobosuiteBackend:
    """The simulator with arm and base away from where they started, at rest."""
    backend.reset(5)
    rng = np.random.default_rng(4)
    for _ in range(30):
        backend.apply(commands(rng.uniform(-0.5, 0.7, 12).astype(np.float32)))
    for _ in range(60):
        backend.apply({})
    return backend


def test_state_20_the_vector_is_what_the_simulator_itself_reports(
    robot: RobotManifest, driven: RobosuiteBackend
) -> None:
    """The vector is robosuite's own observation, field by field."""
    state = state_vector(robot, driven, EXACT)
    seen = driven.env._get_observations(force_update=True)
    wanted = {
        "base_to_eef_pos": state[0:3],
        "base_to_eef_quat": state[3:7],
        "base_pos": state[7:10],
        "base_quat": state[10:14],
        "gripper_qpos": state[14:16],
    }
    for key, ours in wanted.items():
        theirs = np.asarray(seen[f"robot0_{key}"])
        theirs = theirs * (np.sign(theirs @ ours) if key.endswith("quat") else 1.0)
        np.testing.assert_allclose(ours, theirs, atol=2e-5, err_msg=key)


def test_state_21_the_path_knows_no_observation_of_a_simulator(
    robot: RobotManifest, driven: RobosuiteBackend, monkeypatch: pytest.MonkeyPatch
) -> None:
    """No service reads a robosuite observation."""
    before = state_vector(robot, driven, EXACT)
    monkeypatch.setattr(driven.env, "_observables", {})
    driven.apply({})
    np.testing.assert_allclose(state_vector(robot, driven, EXACT), before, atol=1e-3)
    folders = ("services", "shared/fairlead/layouts", "shared/fairlead/hal")
    for path in (file for folder in folders for file in (ROOT / folder).rglob("*.py")):
        words = r"robot0_(base|eef|gripper|joint)|_get_observations|_observables"
        assert not re.search(words, path.read_text()), path


def test_state_22_the_records_tool_frame_is_close_to_the_grip_site_and_the_hand_is_not(
    robot: RobotManifest, driven: RobosuiteBackend
) -> None:
    """panda_hand_tcp is 6 mm from the grip site, panda_hand 9 cm."""
    in_base_link = EXACT_BINDINGS | {"base_frame": "base_link"}
    truth = state_vector(robot, driven, EXACT | {"bindings": in_base_link})
    tcp = state_vector(robot, driven, RECORDED)
    hand = state_vector(
        robot, driven, RECORDED | {"bindings": RECORDS_BINDINGS | {"eef_frame": "panda_hand"}}
    )
    assert 0.004 < np.linalg.norm(tcp[:3] - truth[:3]) < 0.008
    assert 0.085 < np.linalg.norm(hand[:3] - truth[:3]) < 0.105
    assert np.linalg.norm(tcp[:3] - hand[:3]) == pytest.approx(0.1034, abs=1e-6)


def test_state_23_the_description_hangs_the_arm_where_the_simulator_mounts_it(
    robot: RobotManifest, driven: RobosuiteBackend
) -> None:
    """The URDF's links are the simulator's, to 0.1 mm and 0.1 mrad."""
    kinematics = ForwardKinematics(robot)
    found = kinematics.poses(driven.read().positions)
    poses = {name: found[place] for name, place in kinematics.frames.items()}
    sim = driven.env.sim
    base = sim.data.body_xpos[sim.model.body_name2id("mobilebase0_base")]
    turn = sim.data.body_xmat[sim.model.body_name2id("mobilebase0_base")].reshape(3, 3)
    for frame, body in (("panda_link0", "robot0_link0"), ("panda_hand", "robot0_right_hand")):
        index = sim.model.body_name2id(body)
        position = turn.T @ (sim.data.body_xpos[index] - base)
        rotation = turn.T @ sim.data.body_xmat[index].reshape(3, 3)
        np.testing.assert_allclose(poses[frame].translation, position, atol=1e-4)
        np.testing.assert_allclose(poses[frame].rotation, rotation, atol=1e-4)


def test_state_24_the_same_manifest_works_on_another_robot_with_these_frames(
    driven: RobosuiteBackend, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The manifest works on a taller robot."""
    robot = load_robot("panda_mobile")
    here = state_vector(robot, driven, RECORDED)
    for entry in ("rskills", "compose", "services", "shared"):
        (tmp_path / entry).symlink_to(ROOT / entry)
    tall = tmp_path / "robots" / "panda_tall"
    shutil.copytree(ROOT / "robots" / "panda_mobile", tall)
    plain = yaml.safe_load((tall / "robot.yaml").read_text()) | {"id": "panda_tall"}
    (tall / "robot.yaml").write_text(yaml.safe_dump(plain))
    urdf = (tall / "panda_mobile.urdf").read_text()
    mount = urdf.index('<child link="panda_link0"/>')
    before, origin = urdf[:mount], urdf[mount:]
    start = origin.index('xyz="') + 5
    x, y, z = origin[start : origin.index('"', start)].split()
    raised = origin.replace(f'xyz="{x} {y} {z}"', f'xyz="{x} {y} {float(z) + 0.25}"', 1)
    (tall / "panda_mobile.urdf").write_text(before + raised)
    monkeypatch.setenv(ROOT_VARIABLE, str(tmp_path))
    there = state_vector(load_robot("panda_tall"), driven, RECORDED)
    np.testing.assert_allclose(there - here, [0, 0, 0.25] + [0] * 13, atol=1e-9)


def test_state_25_assembling_costs_less_than_the_simulators_own_tick(
    robot: RobotManifest, driven: RobosuiteBackend
) -> None:
    """Assembling costs less than one step of physics."""

    def median_s(action: object) -> float:
        times = []
        for _ in range(7):
            start = time.perf_counter()
            action()  # type: ignore[operator]
            times.append(time.perf_counter() - start)
        return sorted(times)[3]

    assembling = median_s(lambda: state_vector(robot, driven, EXACT))
    assert assembling < median_s(lambda: driven.apply({}))


def test_state_31_a_transform_that_is_too_old_is_named_with_parent_and_age() -> None:
    """A stale frame is an error with frame, parent and age."""
    with pytest.raises(LayoutError) as caught:
        transforms(tick=1).at(9).pose("odom", "base_link")
    assert caught.value.kind == "stale_frame"
    said = "odom -> base_link is stale at tick 9: the newest before it is 8 tick(s) old, allowed "
    assert said in str(caught.value)


def test_state_32_without_a_layout_the_joints_are_taken_in_the_policys_order(
    robot: RobotManifest, driven: RobosuiteBackend
) -> None:
    """Without a layout, joints come in the policy's order and unit."""
    names = [f"panda_joint{n}" for n in (7, 3, 1)]
    field = {"names": names, "quantity": "position", "unit": "deg"}
    state = state_vector(robot, driven, {"dim": 3, "joints": [field]})
    measured = dict(zip(robot.measured_joint_names, driven.read().positions, strict=True))
    np.testing.assert_allclose(np.radians(state), [measured[name] for name in names], rtol=1e-12)
