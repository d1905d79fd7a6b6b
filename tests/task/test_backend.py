"""The backend describes what it finds, and publishes the simulator's truth."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import yaml

from bench.equipment.expert_episode import commands, true_state
from fairlead.errors import ConfigError
from fairlead.messages import floats
from fairlead.modes import ControlMode
from fairlead.paths import repo_root, robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_hal_sim.driver import DRIVER
from fairlead_hal_sim.introspection import simulator_slot
from fairlead_hal_sim.options import HalSimOptions, SimulatorOptions
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_hal_sim.snapshot import restore_snapshot, take_snapshot
from tests.packing.vectors import JOINTS, base_velocity, delta, mode, opening

pytestmark = pytest.mark.simulator

PASSIVE = ("panda_finger_joint1", "panda_finger_joint2", "torso_height")


def test_it_finds_panda_mobiles_parts_joints_and_ranges(backend: RobosuiteBackend) -> None:
    found = backend.describe()
    assert found.joints == JOINTS
    assert found.passive_joints == PASSIVE
    assert found.simulator_order == ("right", "torso", "base", "right_gripper")
    assert found.has_task
    parts = {part.name: part for part in found.parts}
    assert list(parts) == ["arm", "gripper", "base", "composite"]
    assert [part.simulator_part for part in found.parts] == ["right", "right_gripper", "base", ""]
    ranges = {
        (part.name, entry.mode): floats(entry.upper).tolist()
        for part in found.parts
        for entry in part.ranges
    }
    assert ranges[("arm", ControlMode.CARTESIAN_DELTA)] == [0.05, 0.05, 0.05, 0.5, 0.5, 0.5]
    assert ranges[("base", ControlMode.JOINT_VELOCITY)] == [1.0, 1.0, 1.5]
    assert ranges[("gripper", ControlMode.GRIPPER_POSITION)] == [0.08]
    assert ranges[("composite", ControlMode.COMPOSITE_MODE)] == [1.0]
    lower = floats(parts["gripper"].ranges[0].lower)
    assert lower.tolist() == [0.0]


def test_the_robot_rests_where_robot_yaml_has_its_home(backend: RobosuiteBackend) -> None:
    home = load_robot("panda_mobile").home
    assert home is not None
    backend.reset(5)
    measured = dict(zip(JOINTS + PASSIVE, backend.read().positions, strict=True))
    resting = {name: at for name, at in measured.items() if not name.startswith("base_")}
    assert resting == pytest.approx(home.positions, abs=1e-5)


def test_transforms_and_joints_agree_with_the_simulators_observations(
    backend: RobosuiteBackend,
) -> None:
    backend.reset(2)
    rng = np.random.default_rng(1)
    for _ in range(30):
        backend.apply(commands(rng.uniform(-0.6, 0.6, 12).astype(np.float32)))
    for _ in range(40):  # the observations are 2 ms old: compare at rest
        backend.apply({})
    seen = backend.env._get_observations(force_update=True)
    frames = {frame.child: frame for frame in backend.transforms()}
    state = true_state(backend)
    can = backend.env.sim.data.body_xpos[backend.env.sim.model.body_name2id("can_main")]
    np.testing.assert_allclose(frames["object"].translation, can, atol=1e-5)
    np.testing.assert_allclose(
        frames["base_link"].translation[:2], seen["robot0_base_pos"][:2], atol=1e-5
    )
    np.testing.assert_allclose(state[0:3], seen["robot0_base_to_eef_pos"], atol=1e-5)
    np.testing.assert_allclose(
        np.abs(state[3:7]), np.abs(seen["robot0_base_to_eef_quat"]), atol=1e-5
    )
    measured = backend.read()
    np.testing.assert_allclose(measured.positions[3:10], seen["robot0_joint_pos"], atol=1e-6)
    np.testing.assert_allclose(measured.positions[11:13], seen["robot0_gripper_qpos"], atol=1e-6)
    assert measured.positions[10] == measured.positions[11] - measured.positions[12]


def test_map_to_odom_stands_still_and_odom_is_where_the_base_joints_start(
    backend: RobosuiteBackend,
) -> None:
    backend.reset(1)
    (static,) = backend.static_transforms()
    assert (static.parent, static.child) == ("map", "odom")
    base = next(f for f in backend.transforms() if f.child == "base_link")
    np.testing.assert_allclose(base.translation[:2], backend.read().positions[:2], atol=1e-12)


def test_the_task_reports_its_metrics(backend: RobosuiteBackend) -> None:
    backend.reset(0)
    reading = backend.task()
    assert reading is not None
    assert not reading.success
    assert set(reading.metrics) == {"object_gripper_distance", "base_travel"}
    assert 0.3 < reading.metrics["object_gripper_distance"] < 0.8
    assert reading.metrics["base_travel"] == 0.0


def test_the_packed_vector_is_logged_before_the_simulator_turns_it() -> None:
    order = ("right", "right_gripper", "base", "torso")
    backend = RobosuiteBackend(SimulatorOptions(part_order=order))
    assert backend.describe().simulator_order == order
    assert simulator_slot(backend.env.robots[0].composite_controller, "base") == (7, 10)
    backend.apply({})
    start = backend.read().positions
    for _ in range(6):
        backend.apply(
            {
                "arm": delta([0.0, 0.0, 0.05, 0.0, 0.0, 0.0]),
                "gripper": opening(0.0),
                "base": base_velocity(base_x=-0.8, base_y=0.5, base_yaw=0.75),
                "composite": mode(-1.0),
            }
        )
    expected = np.array([0, 0, 1, 0, 0, 0, 1, -0.8, 0.5, 0.5, 0, -1], dtype=np.float32)
    assert backend.last_packed is not None
    assert backend.last_packed.tolist() == expected.tolist()
    moved = backend.read().positions - start
    assert moved[0] < -0.05
    assert moved[1] > 0.02
    assert moved[2] > 0.1
    assert moved[10] < -0.02  # closing
    assert abs(moved[13]) < 1e-3  # torso
    backend.close()


def test_skill_slots_are_inclusive_and_simulator_slots_half_open(
    backend: RobosuiteBackend,
) -> None:
    """``[7, 9]`` in a skill and ``(7, 10)`` in the simulator are the same three inputs."""
    first, last = 7, 9
    start, stop = simulator_slot(backend.env.robots[0].composite_controller, "base")
    assert (start, stop) == (first, last + 1)


def test_an_unknown_simulator_part_is_refused(backend: RobosuiteBackend) -> None:
    text = (
        "hal_sim: expected a simulator part, got 'left' (valid: right, torso, base, right_gripper)"
    )
    with pytest.raises(ConfigError, match=f"^{re.escape(text)}$"):
        simulator_slot(backend.env.robots[0].composite_controller, "left")


@pytest.mark.parametrize(
    ("options", "start"),
    [
        ({"env": "Nowhere"}, "hal_sim: expected a registered environment, got 'Nowhere' (valid: "),
        ({"robot": "Nobody"}, "hal_sim: expected a registered robot, got 'Nobody' (valid: "),
        (
            {"imports": ["no_such_module"]},
            "hal_sim: expected a module that registers environments, got 'no_such_module': ",
        ),
        ({"controller": "NONE"}, "hal_sim: expected a registered controller, got 'NONE' (valid: "),
        (
            {"part_order": ["right", "right_gripper", "base"]},
            "hal_sim: part_order of robot PandaOmron: expected each of base, right, right_gripper, "
            "torso once, got ['right', 'right_gripper', 'base']",
        ),
        (
            {"robot": "Panda", "part_order": ["right", "right_gripper", "base", "torso"]},
            "hal_sim: part_order of robot Panda: expected each of right, right_gripper once, got ",
        ),
        (
            {"env_options": {"gripper_typ": "default"}},
            "hal_sim: env_options of environment MobilePickPlace: expected an option, got "
            "'gripper_typ' (valid: base_pose, ",
        ),
        (
            {"env_options": {"seed": 1}},
            "hal_sim: env_options of environment MobilePickPlace: expected an option, got 'seed', "
            "which hal_sim sets (valid: ",
        ),
        (
            {"env_options": {"gripper_types": "none"}},
            "hal_sim: environment MobilePickPlace with robot PandaOmron and env_options "
            "{'gripper_types': 'none'} cannot be made: AssertionError: Unknown end effector name",
        ),
        (
            {"cameras": [{"name": "x", "width": 8, "height": 8, "period_ticks": 1}]},
            "hal_sim: expected a camera of this environment, got 'x' (valid: overview, top, ",
        ),
    ],
)
def test_unknown_names_are_refused_with_the_valid_ones(
    options: dict[str, object], start: str
) -> None:
    with pytest.raises(ConfigError, match=f"^{re.escape(start)}"):
        RobosuiteBackend(SimulatorOptions.model_validate(options))


@pytest.mark.parametrize(
    ("env", "robot", "parts"),
    [
        ("Lift", "PandaOmron", ["arm", "gripper", "base", "composite"]),
        ("Lift", "Panda", ["arm", "gripper"]),
    ],
)
def test_other_environments_and_robots_work_by_name(env: str, robot: str, parts: list[str]) -> None:
    backend = RobosuiteBackend(SimulatorOptions(env=env, robot=robot))
    assert [part.name for part in backend.describe().parts] == parts
    before = backend.read().positions
    for _ in range(5):
        backend.apply({"arm": delta([0.0, 0.0, 0.05, 0.0, 0.0, 0.0])})
    assert np.abs(backend.read().positions - before).max() > 0.01
    assert backend.task() is not None
    assert [frame.child for frame in backend.transforms()] == ["base_link"]
    backend.close()


def named(text: str) -> RobotManifest:
    """The fixed panda as robosuite's Panda, with a text of robot.yaml changed."""
    document = yaml.safe_load(text)
    joints = document["simulator"]["joints"]
    for name, called in joints.items():
        numbered = [re.sub("^panda_", "robot0_", one) for one in called]
        joints[name] = [re.sub("^robot0_finger", "gripper0_right_finger", one) for one in numbered]
    return RobotManifest.model_validate(document)


def test_joints_go_by_the_names_of_robot_yaml_and_a_name_that_is_none_is_refused() -> None:
    text = (robot_dir("panda") / "robot.yaml").read_text()
    options = SimulatorOptions(env="Lift", robot="Panda")
    renamed = text.replace("panda_joint2", "shoulder_lift")
    robot = named(renamed.replace("[shoulder_lift]", "[panda_joint2]"))
    backend = RobosuiteBackend(options, robot=robot)
    found = backend.describe()
    assert found.joints == robot.joint_names
    assert found.joints[1] == "shoulder_lift"
    assert found.passive_joints == robot.passive_joint_names
    assert found.parts[0].joints == robot.part("arm").joints
    backend.close()
    wrong = "hal_sim: simulator.joints of robot.yaml: shoulder_lift: expected joints of robosuite's"
    with pytest.raises(ConfigError, match=re.escape(wrong)):
        RobosuiteBackend(options, robot=named(renamed))


def test_the_hal_moves_without_observations_as_an_environment_moves_with_them(
    backend: RobosuiteBackend,
) -> None:
    driven = DRIVER.equip(load_robot("panda_mobile"), "sim", HalSimOptions()).backend
    assert isinstance(driven, RobosuiteBackend)
    rows = np.random.default_rng(4).uniform(-0.6, 0.6, (10, 12)).astype(np.float32)
    states = []
    for one in (driven, backend):
        one.reset(4)
        for row in rows:
            one.apply(commands(row))
        states.append(take_snapshot(one.env.sim))
    assert states[0] == states[1]
    assert driven.env.enabled_observables == set()
    assert backend.env.enabled_observables
    driven.close()


def test_a_snapshot_puts_another_simulator_into_the_same_poses(
    backend: RobosuiteBackend,
) -> None:
    backend.reset(6)
    for _ in range(5):
        backend.apply(commands(np.full(12, 0.4, dtype=np.float32)))
    snapshot = take_snapshot(backend.env.sim)
    other = RobosuiteBackend(SimulatorOptions(seed=3))
    restore_snapshot(other.env.sim, snapshot)
    assert [f.translation.tobytes() for f in other.transforms()] == [
        f.translation.tobytes() for f in backend.transforms()
    ]
    other.close()


@pytest.mark.processes
def test_a_hal_process_with_a_wrong_part_order_ends_with_the_right_one_and_no_traceback(
    tmp_path: Path,
) -> None:
    spec = yaml.safe_load((repo_root() / "compose" / "panda_mobile_sim.yaml").read_text())
    spec["services"]["hal"]["options"]["part_order"] = ["right", "base", "torso"]
    file = tmp_path / "deployment.yaml"
    file.write_text(yaml.safe_dump(spec))
    command = [sys.executable, "-m", "fairlead.hal.serve", "--deployment", str(file)]
    command += ["--service", "hal", "--state-dir", str(tmp_path / "state")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    said = done.stdout + done.stderr
    assert done.returncode == 1, said
    assert "Traceback" not in said
    assert "expected each of base, right, right_gripper, torso once" in said
