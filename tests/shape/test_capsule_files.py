"""The committed capsules: the models' geometry lies inside, and the pairs follow from them."""

from __future__ import annotations

import json
import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.capsules import load_capsules
from fairlead.robot.link_poses import link_poses, random_positions
from fairlead.robot.manifest import load_robot
from fairlead_tools.shape.capsule_pairs import links_apart
from fairlead_tools.shape.geometry import geometry_source
from fairlead_tools.shape.robot_model import robot_model
from fairlead_tools.shape.robot_shape import RobotShape
from tests.cli.command import fairlead_here as fairlead
from tests.shape.own_robot import own_robot
from tests.shape.solid_points import farthest_out

ROUNDING_M = 1e-6  # the URDF's angles and the model's are rounded
SIMULATOR_M = 1e-4  # robosuite's model and the URDF agree so well
ROBOSUITE = "robosuite:PandaOmron"


@pytest.mark.parametrize("name", ["panda", "dual_panda", "kinova3", "ur5e"])
def test_no_point_of_the_model_is_outside_whatever_the_fingers_do(name: str) -> None:
    robot = load_robot(name)
    model = mujoco.MjModel.from_xml_path(str(robot_dir(name) / f"{name}.xml"))
    capsules = list(load_capsules(robot).capsules)
    assert farthest_out(robot, model, capsules, 100) <= ROUNDING_M
    narrow = [c.model_copy(update={"radius_m": c.radius_m - 0.003}) for c in capsules]
    assert farthest_out(robot, model, narrow, 20) > 0.0005


@pytest.mark.simulator
def test_no_point_of_robosuites_robot_is_outside() -> None:
    robot = load_robot("panda_mobile")
    shape = RobotShape(robot, geometry_source(robot, ROBOSUITE))
    capsules = list(load_capsules(robot).capsules)
    assert farthest_out(robot, shape.source.model, capsules, 30) <= SIMULATOR_M
    assert shape.uncovered(capsules) == []
    # MuJoCo's own answer is 0 in 3 % of the poses of these two, which are 0.02 m apart.
    poses = link_poses(shape.tree, random_positions(robot, shape.tree, 500))
    assert (links_apart(shape.source, poses, ["panda_link5"], ["panda_link7"]) != 0.0).all()


@pytest.mark.parametrize("name", ["panda", "dual_panda", "ur5e"])
def test_the_command_finds_the_committed_file_current(name: str, tmp_path: Path) -> None:
    done = fairlead("robot", "capsules", name, "--check", "--json", state=tmp_path)
    assert done.returncode == 0, done.stderr
    table = json.loads(done.stdout)
    checked = [pair["capsules"] for pair in table["pairs"] if pair["checked"]]
    assert checked == [list(pair) for pair in load_capsules(load_robot(name)).checked_pairs]


@pytest.mark.simulator
def test_the_command_finds_panda_mobiles_file_current(tmp_path: Path) -> None:
    """By the model that robot.yaml names."""
    done = fairlead("robot", "capsules", "panda_mobile", "--check", state=tmp_path)
    assert done.returncode == 0, done.stderr
    agreement, verdict = done.stdout.splitlines()[-2:]
    assert agreement.startswith("robosuite:PandaOmron: 15 frames are where panda_mobile.urdf has")
    assert verdict == (
        f"{robot_dir('panda_mobile')}/capsules.yaml covers the geometry, and has the pairs that "
        "follow from it"
    )


@pytest.mark.simulator
def test_a_robot_of_robosuite_wears_the_gripper_that_is_asked_for() -> None:
    robot = load_robot("panda_mobile")
    with pytest.raises(ConfigError, match=r"a gripper of robosuite, got 'Claw' \(valid: BDGripper"):
        robot_model(robot, "robosuite:PandaOmron+Claw", "test")
    found = robot_model(robot, "robosuite:UR5e+PandaGripper", "test")
    assert found is not None
    assert found.model.joint("gripper0_right_finger_joint1").id >= 0
    assert found.model.joint("robot0_elbow_joint").id >= 0


def test_two_arms_are_kept_apart_and_neighbours_are_not() -> None:
    file = load_capsules(load_robot("dual_panda"))
    links = {
        frozenset((file.capsules[one].link, file.capsules[other].link))
        for one, other in file.checked_pairs
    }
    assert {
        frozenset(("left_hand", "right_palm")),
        frozenset(("left_link5", "right_link5")),
    } <= links
    assert frozenset(("left_hand", "base_link")) in links
    for pair in (("left_link1", "left_link2"), ("left_link7", "left_hand"),
                 ("base_link", "left_link0"), ("left_link6", "left_hand")):  # fmt: skip
        assert frozenset(pair) not in links


def test_a_file_that_leaves_geometry_out_is_told() -> None:
    robot = load_robot("panda")
    shape = RobotShape(robot, geometry_source(robot, None))
    capsules = list(load_capsules(robot).capsules)
    assert shape.uncovered(capsules) == []
    hand = next(i for i, one in enumerate(capsules) if one.link == "panda_hand")
    capsules[hand] = capsules[hand].model_copy(update={"radius_m": capsules[hand].radius_m - 0.005})
    (problem,) = shape.uncovered(capsules)
    assert problem.startswith("panda_hand reaches 0.00")
    without = [one for one in capsules if one.link != "panda_link5"]
    assert any(line.startswith("panda_link5 reaches inf") for line in shape.uncovered(without))


def test_compiling_warns_of_a_link_that_reaches_out_of_its_capsules(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file = own_robot(tmp_path, monkeypatch) / "capsules.yaml"
    assert "WARNING" not in fairlead("robot", "compile", "mine", state=tmp_path).stderr
    radius = re.search(r"link: panda_hand\b.*?radius_m: ([\d.]+)", file.read_text(), re.S)
    assert radius is not None
    thinner = radius[0].replace(radius[1], f"{float(radius[1]) - 0.005:g}")
    file.write_text(file.read_text().replace(radius[0], thinner))
    done = fairlead("robot", "compile", "mine", state=tmp_path)
    assert done.returncode == 0
    assert re.search(r"WARNING mine: panda_hand reaches 0\.00\d+ m out of its", done.stderr)


def test_no_pair_is_near_at_rest() -> None:
    robot = load_robot("panda")
    shape = RobotShape(robot, geometry_source(robot, None))
    assert {name: float(value[0]) for name, value in shape.rest().items()} == pytest.approx(
        {"panda_joint1": 0.0, "panda_joint2": -0.3, "panda_joint3": 0.0, "panda_joint4": -2.2,
         "panda_joint5": 0.0, "panda_joint6": 2.0, "panda_joint7": 0.785,
         "panda_finger_joint1": 0.04, "panda_finger_joint2": -0.04}
    )  # fmt: skip
    file = load_capsules(robot)
    spans = shape.drawn(file.capsules)[1]
    for first, second in file.checked_pairs:
        one, other = spans[first], spans[second]
        shares = np.linspace(0.0, 1.0, 101)[:, None]
        lines = [end.points[0] + shares * (end.points[1] - end.points[0]) for end in (one, other)]
        apart = np.linalg.norm(lines[0][:, None] - lines[1][None], axis=2).min()
        assert apart - one.radius - other.radius > 0.01
