"""A description that disagrees with the robot's model: refused wherever both are at hand."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import yaml

from fairlead.errors import ConfigError
from fairlead.hal.backend import FramePose
from fairlead.hal.frame_check import check_frames
from fairlead.messages import FloatArray
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead_tools.shape.robot_model import robot_model
from fairlead_tools.supervisor.command_line import service_environment
from tests.cli.command import fairlead_here as fairlead
from tests.shape.own_robot import NAME, own_robot
from tests.shape.wrong_descriptions import MISTAKES, Mistake, mistaken


def hal_start(tmp_path: Path, robot: str, kind: str = "hal_mujoco") -> subprocess.Popen[str]:
    """Start the HAL alone."""
    deployment = tmp_path / "deployment.yaml"
    spec = {"robot": robot, "id": robot, "pacing": "lockstep", "services": {"hal": {"run": kind}}}
    deployment.write_text(yaml.safe_dump(spec))
    return subprocess.Popen(
        [sys.executable, "-m", "fairlead.hal.serve", "--deployment", str(deployment),
         "--service", "hal", "--state-dir", str(tmp_path / "state")],
        env=service_environment(), stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
    )  # fmt: skip


def never_compiled(folder: Path) -> None:
    """A robot of which there is no gate file yet."""
    for file in folder.glob("gate.*.json"):
        file.unlink()


def refusal(process: subprocess.Popen[str]) -> str:
    """What a HAL says that does not start."""
    try:
        said, _ = process.communicate(timeout=200)
    finally:
        process.kill()
    assert process.returncode not in (0, -9), said
    return said


@pytest.mark.processes
@pytest.mark.parametrize("mistake", MISTAKES.values(), ids=MISTAKES.keys())
def test_a_wrong_description_is_refused_by_capsules_by_compile_and_by_the_hal(
    mistake: Mistake, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    urdf = folder / "panda.urdf"
    urdf.write_text(mistaken(urdf.read_text(), mistake))
    old = refusal(hal_start(tmp_path, NAME))
    assert "gate.sim.json was made of other files than today's" in old
    never_compiled(folder)
    hal = hal_start(tmp_path, NAME)
    before = (folder / "capsules.yaml").read_text()
    capsules = fairlead("robot", "capsules", NAME, state=tmp_path)
    compiled = fairlead("robot", "compile", NAME, state=tmp_path)
    assert (capsules.returncode, compiled.returncode) == (1, 1)
    assert (folder / "capsules.yaml").read_text() == before
    for said in (capsules.stderr, compiled.stderr, refusal(hal)):
        assert "expected each frame where panda.urdf has it, within 0.1 mm and 0.0001 rad" in said
        lines = [line.strip() for line in said.splitlines() if " off at " in line]
        assert lines[0].startswith(f"frame {mistake.frame}: "), said
        assert " mm and " in lines[0] and " rad off at " in lines[0]
        where = lines[0].partition(" off at ")[2]
        assert f"  {where}: panda_joint1 " in said
        assert "Traceback" not in said


def test_compile_says_that_there_is_no_model_to_compare_a_description_with(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (own_robot(tmp_path, monkeypatch) / "mine.xml").unlink()
    done = fairlead("robot", "compile", NAME, state=tmp_path)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines()[0] == (
        "panda.urdf is compared with no model: robot.yaml names none (simulator.model), and "
        "mine.xml is not there"
    )


def test_only_the_link_that_is_turned_is_off_and_by_half_a_turn(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    urdf = folder / "panda.urdf"
    urdf.write_text(mistaken(urdf.read_text(), MISTAKES["a link turned by 180 degrees"]))
    model = robot_model(load_robot(NAME), None, "test")
    assert model is not None
    with pytest.raises(ConfigError) as error:
        model.check()
    [line] = [line for line in str(error.value).splitlines() if " off at " in line]
    assert line.startswith("  frame panda_link2: ")
    assert " mm and 3.142 rad off at " in line


@pytest.mark.simulator
@pytest.mark.processes
def test_robosuites_hal_refuses_a_tool_that_is_elsewhere(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(tmp_path))
    folder = tmp_path / "moved"
    shutil.copytree(robot_dir("panda_mobile"), folder)
    manifest, urdf = folder / "robot.yaml", folder / "panda_mobile.urdf"
    manifest.write_text(manifest.read_text().replace("id: panda_mobile\n", "id: moved\n", 1))
    text = urdf.read_text()
    start = text.index("<origin", text.index('<child link="grip_site"/>'))
    end = text.index("/>", start) + 2
    urdf.write_text(text[:start] + '<origin xyz="0 0 0" rpy="0 0 0"/>' + text[end:])
    never_compiled(folder)
    said = refusal(hal_start(tmp_path, "moved", "hal_sim"))
    [line] = [line for line in said.splitlines() if " off at " in line]
    assert "frame grip_site: " in line


class Controller:
    """An arm's controller: it knows its tool's pose, and only where the arm stands."""

    def __init__(self, robot: RobotManifest, here: FloatArray, off_m: float) -> None:
        model = pin.buildModelFromUrdf(str(robot.description_path()))
        data, q = model.createData(), pin.neutral(model)
        for name, position in zip(robot.measured_joint_names, here, strict=True):
            if model.existJointName(name):
                q[model.joints[model.getJointId(name)].idx_q] = position
        pin.framesForwardKinematics(model, data, q)
        pose = data.oMf[model.getFrameId("panda_hand_tcp", pin.FrameType.BODY)]
        xyzw = pin.Quaternion(pose.rotation).coeffs()
        self.pose = FramePose(
            "base_link", "panda_hand_tcp", pose.translation + np.array([0.0, 0.0, off_m]), xyzw
        )

    def frame_poses(self, positions: FloatArray | None) -> list[FramePose]:
        return [self.pose] if positions is None else []


HERE = np.array([0.1, -0.3, 0.2, -2.2, 0.3, 2.0, 0.785, 0.08, 0.04, -0.04])


def test_a_controller_that_knows_its_tool_only_is_compared_where_it_stands() -> None:
    robot = load_robot("panda")
    said = check_frames(robot, Controller(robot, HERE, 0.5e-4), HERE, "hal", stands="the start")
    assert said.startswith("1 frames are where panda.urdf has them, at the start: within 0.05 mm")
    with pytest.raises(ConfigError, match="frame panda_hand_tcp: 0.2 mm and "):
        check_frames(robot, Controller(robot, HERE, 2e-4), HERE, "hal", stands="the start")
    with pytest.raises(ConfigError, match="frame panda_hand_tcp: inf mm"):
        check_frames(robot, Controller(robot, HERE, np.nan), HERE, "hal", stands="the start")


def test_a_robot_may_declare_a_wider_tolerance_and_capsules_are_then_in_its_descriptions_frames(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    declared = "  frame_tolerance: {distance_m: 0.003}\n"
    folder = own_robot(
        tmp_path, monkeypatch, yaml=("  frames:\n", declared + "  frames:\n"),
        urdf=('xyz="0 -0.316 0"', 'xyz="0 -0.314 0"'),
    )  # fmt: skip
    done = fairlead("robot", "capsules", NAME, state=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "13 frames are where panda.urdf has them" in done.stdout
    assert "within 2 mm" in done.stdout
    manifest = load_robot(NAME)
    assert manifest.robot_hash != load_robot("panda").robot_hash, "another description"
    # Joint 3 turns about z: the model's link 3 lies 2 mm further along it than the description's.
    lines = (folder / "capsules.yaml").read_text().splitlines()
    [upper_arm] = [line for line in lines if "link: panda_link3," in line]
    capsule = yaml.safe_load(upper_arm.partition("- ")[2].partition("  #")[0])
    assert sorted([capsule["a_m"][2], capsule["b_m"][2]]) == pytest.approx(
        [-0.168, -0.058], abs=2e-4
    )


def test_a_site_may_stand_for_a_link_whose_body_lies_otherwise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The way out where a maker's URDF and a model agree on the arm and not on its frames."""
    folder = own_robot(tmp_path, monkeypatch)
    urdf, manifest, model = (folder / name for name in ("panda.urdf", "robot.yaml", "mine.xml"))
    mistake = MISTAKES["a link turned by 180 degrees"]
    urdf.write_text(mistaken(urdf.read_text(), mistake))
    turned = '<site name="turned" euler="180 0 0"/>'
    text = model.read_text()
    if 'angle="radian"' in text:
        turned = turned.replace("180", "3.141592653589793")
    end = text.index(">", text.index('<body name="panda_link2"')) + 1
    model.write_text(text[:end] + turned + text[end:])
    named = "panda_link2: body:panda_link2"
    manifest.write_text(manifest.read_text().replace(named, "panda_link2: site:turned"))
    done = fairlead("robot", "capsules", NAME, "--json", state=tmp_path)
    assert done.returncode == 0, done.stderr
    compiled = fairlead("robot", "compile", NAME, state=tmp_path)
    assert compiled.returncode == 0, compiled.stderr


def test_a_moving_link_or_a_tool_that_is_compared_with_nothing_is_refused_by_name(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest = own_robot(tmp_path, monkeypatch) / "robot.yaml"
    text = manifest.read_text().replace("    panda_link4: body:panda_link4\n", "")
    manifest.write_text(text.replace("    panda_hand_tcp: site:panda_hand_tcp\n", ""))
    done = fairlead("robot", "compile", NAME, state=tmp_path)
    assert done.returncode == 1
    assert "simulator.frames in robot.yaml: missing panda_link4, panda_hand_tcp" in done.stderr


def test_a_link_without_a_shape_is_named_until_robot_yaml_says_why(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    folder = own_robot(tmp_path, monkeypatch)
    model, manifest = folder / "mine.xml", folder / "robot.yaml"
    seen_only = model.read_text()
    start = seen_only.index("<geom", seen_only.index('<body name="panda_link5"'))
    end = seen_only.index("<body", start)
    visual = seen_only[start:end].replace("<geom ", '<geom contype="0" conaffinity="0" ')
    model.write_text(seen_only[:start] + visual + seen_only[end:])
    done = fairlead("robot", "capsules", NAME, state=tmp_path)
    assert done.returncode == 1
    assert "no collision geometry, so no capsule, for panda_link5: give them some" in done.stderr
    declared = "no_collision_geometry:\n  panda_link5: a drawing, nothing is there\n"
    manifest.write_text(manifest.read_text().replace("no_collision_geometry:\n", declared, 1))
    assert fairlead("robot", "capsules", NAME, state=tmp_path).returncode == 0
    assert fairlead("robot", "compile", NAME, state=tmp_path).returncode == 0
    manifest.write_text(manifest.read_text().replace("  panda_link8: a frame", "  panda_link7: a"))
    done = fairlead("robot", "compile", NAME, state=tmp_path)
    assert done.returncode == 1
    assert "no capsule, for panda_link8" in done.stderr
