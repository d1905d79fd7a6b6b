"""``fairlead robot new``: what it makes of a person's files, and which files it refuses."""

from __future__ import annotations

import re

import numpy as np
import pytest
import yaml

from fairlead.deploy.deployment import load_deployment
from fairlead.paths import robot_dir
from fairlead.robot.manifest import load_robot
from fairlead.robot.safety_profile import profile_limits
from fairlead_hal_mujoco.mujoco_backend import MujocoBackend
from tests.cli.command import fairlead_here
from tests.draft.drafting import EXAMPLE, Desk


def test_an_mjcf_becomes_a_robot_that_compiles_and_says_what_to_confirm(desk: Desk) -> None:
    done = desk.new("mine", "--mjcf", EXAMPLE)
    assert done.returncode == 0, done.stderr
    assert "arm: pan, lift, elbow, bend, roll; gripper: gripper" in done.stdout
    robot = load_robot("mine")
    assert {one.name for one in (desk.robots / "mine").iterdir()} == {
        "robot.yaml", "mine.urdf", "mine.xml", "capsules.yaml", "gate.sim.json",
    }  # fmt: skip
    assert robot.simulator_joints("gripper") == ("left_finger", "right_finger")
    assert robot.end_effectors[0].tool_frame == "tcp"
    pan, limits = robot.joint("pan"), robot.profile("sim").parts["arm"].joint_position
    assert (pan.lower_rad, pan.upper_rad, pan.effort_nm) == (-2.8, 2.8, 40.0)
    assert limits is not None
    assert limits.step_limits[0] == pytest.approx(pan.velocity_limit * 0.05)
    delta = robot.profile("sim").parts["arm"].cartesian_delta
    assert delta is not None and robot.part("arm").modes[-1] == "cartesian_delta"
    assert (delta.frames, delta.gain[0]) == (("base",), 0.0)
    assert 0.005 < delta.linear_limit_m <= 0.05 and 0.02 < delta.angular_limit_rad <= 0.25
    assert {"joints.pan.velocity_rad_s", "safety.hardware.measured.pan"} <= set(robot.to_confirm)
    assert robot.home is not None and robot.home.source == "the model's own pose"
    assert robot.to_confirm["home"].startswith("the model's own pose: ")
    assert "joints.pan.effort_nm" not in robot.to_confirm
    compiled = fairlead_here("robot", "compile", "mine", state=desk.folder)
    assert compiled.returncode == 0
    assert "gate.hardware.json is not made: robot mine: profile hardware" in compiled.stderr
    deployment = load_deployment(desk.folder / "mine.yaml")
    assert deployment.services["hal"].run == "hal_mujoco"
    backend = MujocoBackend(robot)
    assert backend.transforms()[0].child == robot.base_frame == "base"
    assert np.abs(backend.read().positions[:5] - [0, -0.5, 1.6, 0.5, 0]).max() < 0.06
    code, found = desk.check("mine")
    assert code == 0, found
    assert max(one["random_mm"] for one in found["frames"]) < 1e-3


def test_joints_off_their_bodies_with_a_reference_or_without_end_are_where_the_model_has_them(
    desk: Desk,
) -> None:
    model = desk.example(
        ('<joint name="pan" axis="0 0 1" range="-2.8 2.8"/>', '<joint name="pan" axis="0 0 1"/>'),
        ('name="elbow" axis="0 1 0"', 'name="elbow" axis="0 1 0.3" pos="0.02 0 -0.01" ref="0.4"'),
        ('class="finger" range="0 0.04"', 'class="finger" range="0 0.04" ref="0.01"'),
        ('<body name="wrist"', '<body name="wrist" euler="0.4 1.5707963 0.2"'),
        ("</worldbody>", '<body pos="1 0 0.2"><freejoint/><geom size="0.05"/></body></worldbody>'),
        ('qpos="0 -0.5 1.6 0.5 0 0.03 -0.03"', 'qpos="0 -0.5 1.6 0.5 0 0.03 -0.03 1 0 1 1 0 0 0"'),
    )
    done = desk.new("mine", "--mjcf", model)
    assert done.returncode == 0, done.stderr
    robot = load_robot("mine")
    assert robot.joint("pan").type == "continuous"
    assert robot.simulator is not None
    assert robot.simulator.frames["forearm"] == "site:forearm"
    code, found = desk.check("mine")
    assert code == 0, found
    assert len(found["frames"]) == 9
    assert max(one["random_mm"] for one in found["frames"]) < 1e-3


def test_a_urdf_whose_frames_lie_otherwise_gets_sites_and_each_is_to_be_confirmed(
    desk: Desk,
) -> None:
    assert desk.new("first", "--mjcf", EXAMPLE).returncode == 0
    urdf = (desk.robots / "first" / "first.urdf").read_text()
    parts = urdf.split('<child link="forearm"/>')
    turned = parts[1].replace('rpy="0 0 0"', 'rpy="0 0 3.14159265359"', 1)
    turned = turned.replace('<axis xyz="0 1 0"/>', '<axis xyz="0 -1 0"/>', 1)
    turned = turned.replace('xyz="0 0 0.25" rpy="0 0 0"', 'xyz="0 0 0.25" rpy="0 0 -3.14159265359"')
    other = desk.write("maker.urdf", '<child link="forearm"/>'.join([parts[0], turned]))
    done = desk.new("mine", "--mjcf", EXAMPLE, "--urdf", other)
    assert done.returncode == 0, done.stderr
    robot = load_robot("mine")
    assert robot.simulator is not None
    assert robot.simulator.frames["forearm"] == "site:forearm"
    assert robot.simulator.frames["wrist"] == "body:wrist"
    assert robot.to_confirm["simulator.frames.forearm"].startswith("0.00 mm and 3.1416 rad")
    assert desk.check("mine")[0] == 0


def test_a_hand_that_turns_is_told_radians_and_a_tied_finger_mimics(desk: Desk) -> None:
    tied = '<equality><joint joint1="right_finger" joint2="left_finger" polycoef="0 -1 0 0 0"/>'
    model = desk.example(
        ('<joint name="left_finger" class="finger" range="0 0.04"/>',
         '<joint name="left_finger" axis="1 0 0" range="-0.2 1.2"/>'),
        ('<joint name="right_finger" class="finger" range="-0.04 0"/>',
         '<joint name="right_finger" axis="1 0 0" range="-1.2 0.2"/>'),
        ('<position joint="left_finger" class="finger"/>', '<position joint="left_finger"/>'),
        ('<position joint="right_finger" class="finger"/>', ""),
        ("<keyframe>", f"{tied}</equality><keyframe>"),
    )  # fmt: skip
    done = desk.new("mine", "--mjcf", model)
    assert done.returncode == 0, done.stderr
    robot = load_robot("mine")
    assert robot.measured_joint_names[-1] == "left_finger"
    told = robot.profile("sim").parts["gripper"].gripper_position
    assert told is not None
    assert (told.lower_rad, told.upper_rad) == (-0.2, 1.2)
    assert '<mimic joint="left_finger" multiplier="-1" offset="0"/>' in (
        (desk.robots / "mine" / "mine.urdf").read_text()
    )
    assert desk.check("mine")[0] == 0


@pytest.mark.parametrize(
    ("old", "new", "off"),
    [
        ('xyz="0 0 0.3"', 'xyz="0 0.2 0.3"', ["hand", "tcp"]),
        ('<axis xyz="0 1 0"/>', '<axis xyz="0 -1 0"/>', ["upper_arm", "forearm"]),
    ],
)
def test_a_urdf_that_is_of_another_arm_is_refused_with_mm_and_rad_by_link(
    old: str, new: str, off: list[str], desk: Desk
) -> None:
    assert desk.new("first", "--mjcf", EXAMPLE).returncode == 0
    urdf = (desk.robots / "first" / "first.urdf").read_text()
    other = desk.write("maker.urdf", urdf.replace(old, new))
    done = desk.new("mine", "--mjcf", EXAMPLE, "--urdf", other)
    assert done.returncode == 1
    assert f"the URDF and {EXAMPLE} are not the same robot: over 20 random poses" in done.stderr
    named = [
        line.split()[1].rstrip(":") for line in done.stderr.splitlines() if " off body " in line
    ]
    assert set(off) <= set(named), done.stderr
    assert "or leave out --urdf: it is then made of the MJCF" in done.stderr
    assert not (desk.robots / "mine").exists()


def test_without_position_actuators_it_runs_without_physics_and_says_what_is_missing(
    desk: Desk,
) -> None:
    done = desk.new("mine", "--mjcf", desk.example(('<position joint="', '<motor joint="')))
    assert done.returncode == 0, done.stderr
    assert "hal_mujoco cannot move it yet: hal_mujoco: joint pan: expected one" in done.stdout
    assert "<position joint='pan' kp=... dampratio=\"1\"/>" in done.stdout
    assert load_deployment(desk.folder / "mine.yaml").services["hal"].run == "hal_kinematic"
    wrong = desk.findings("mine", "wrong")
    assert [one.split(":")[0] for _, one in wrong] == [
        "joint pan", "joint lift", "joint elbow", "joint bend", "joint roll", "joint gripper",
    ]  # fmt: skip
    model = desk.robots / "mine" / "mine.xml"
    motor = r'<general (?:class="finger" )?joint="(\w+)" biastype="none" gainprm="1"/>'
    mended = re.sub(motor, r'<position joint="\1" kp="400" kv="25"/>', model.read_text())
    model.write_text(mended)
    assert [one for subject, one in desk.findings("mine", "ok") if subject == "MJCF"]


def test_joints_whose_names_have_a_prefix_in_the_urdf_are_the_models(
    desk: Desk,
) -> None:
    assert desk.new("first", "--mjcf", EXAMPLE).returncode == 0
    urdf = (desk.robots / "first" / "first.urdf").read_text()
    named = desk.write(
        "maker.urdf", re.sub(r'<joint name="(?!.*fixed)', '<joint name="acme_', urdf)
    )
    done = desk.new("mine", "--mjcf", EXAMPLE, "--urdf", named)
    assert done.returncode == 0, done.stderr
    robot = load_robot("mine")
    assert robot.simulator_joints("acme_elbow") == ("elbow",)
    assert desk.check("mine")[0] == 0


def test_a_stop_may_last_as_long_as_a_slow_hands_stroke(desk: Desk) -> None:
    wide = ('range="0 0.04"', 'range="0 0.3"'), ('range="-0.04 0"', 'range="-0.3 0"')
    assert desk.new("mine", "--mjcf", desk.example(*wide)).returncode == 0
    hand, told = load_robot("mine").joint("left_finger"), load_robot("mine").profile("sim")
    speed = profile_limits(hand, told)[0]
    assert told.protocol.stop_ramp_ms > 1e3 * (hand.upper - hand.lower) / (0.9 * speed) > 1500


def test_a_urdf_alone_brings_its_meshes_and_moves_without_physics(desk: Desk) -> None:
    package = desk.folder / "acme_description"
    (package / "meshes").mkdir(parents=True)
    corners = ["0 0 0", "0.1 0 0", "0 0.1 0", "0 0 0.1"]
    faces = ["1 2 3", "1 2 4", "1 3 4", "2 3 4"]
    obj = "".join(f"v {one}\n" for one in corners) + "".join(f"f {one}\n" for one in faces)
    (package / "meshes" / "link.obj").write_text(obj)
    urdf = (robot_dir("panda") / "panda.urdf").read_text()
    mesh = '<geometry><mesh filename="package://acme_description/meshes/link.obj"/></geometry>'
    link = f'<link name="panda_link2"><collision>{mesh}</collision></link>'
    visual = f'<link name="panda_link4"><visual>{mesh}</visual></link>'
    other = package / "other" / "link.obj"  # of the same name, in another folder
    other.parent.mkdir()
    other.write_text(obj.replace("0.1", "0.2"))
    urdf = urdf.replace('<link name="panda_link2"/>', link)
    third = link.replace("meshes/", "other/").replace("link2", "link3")
    urdf = urdf.replace('<link name="panda_link3"/>', third)
    urdf = urdf.replace("base_link", "world")  # as many makers call their root
    (package / "arm.urdf").write_text(urdf.replace('<link name="panda_link4"/>', visual))
    done = desk.new("mine", "--urdf", package / "arm.urdf")
    assert done.returncode == 0, done.stderr
    assert (desk.robots / "mine" / "meshes" / "link.obj").read_text() == obj
    assert (desk.robots / "mine" / "meshes" / "1_link.obj").read_text() == other.read_text()
    robot = load_robot("mine")
    assert robot.joint("panda_joint1").velocity_rad_s == 2.175
    assert "joints.panda_joint1.velocity_rad_s" not in robot.to_confirm
    assert "it has only visual geometry" in robot.to_confirm["no_collision_geometry.panda_link4"]
    assert yaml.safe_load((desk.folder / "mine.yaml").read_text())["services"]["hal"]["run"] == (
        "hal_kinematic"
    )
    assert ("capsules", "panda_link4: only visual geometry; declared: only visual geometry") in (
        desk.findings("mine", "open")
    )
    assert ("MJCF", "none: the URDF is compared with nothing") in desk.findings("mine", "open")
    assert desk.findings("mine", "missing") == []


def test_a_joint_of_short_stroke_has_limits_within_it(desk: Desk) -> None:
    model = desk.example(
        (
            'name="bend" axis="0 1 0" range="-1.8 1.8"',
            'name="bend" axis="0 1 0" range="0 0.0166667"',
        )
    )
    done = desk.new("mine", "--mjcf", model)
    assert done.returncode == 0, done.stderr
    safety = load_robot("mine").profile("sim")
    told, measured = safety.parts["arm"].joint_position, safety.measured["bend"]
    assert told is not None
    assert (told.tracking_limits[3], measured.jump_per_tick, measured.tolerance) == (0.0166667,) * 3
    assert 0.0166 < told.step_limits[3] <= 0.0166667


def test_a_speed_of_many_digits_is_not_rounded(desk: Desk) -> None:
    assert desk.new("first", "--mjcf", EXAMPLE).returncode == 0
    urdf = (desk.robots / "first" / "first.urdf").read_text().replace('"1000000"', '"2.17511"')
    model = desk.example((' kv="25"', ' kv="0"'), (' damping="1"', ""))
    done = desk.new("mine", "--mjcf", model, "--urdf", desk.write("arm.urdf", urdf))
    assert done.returncode == 0, done.stderr
    robot = load_robot("mine")
    assert profile_limits(robot.joint("pan"), robot.profile("sim"))[0] == 2.17511
