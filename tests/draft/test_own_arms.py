"""What a skill may do on arms that somebody brings: without a gripper, or slow ones."""

from __future__ import annotations

import re

from fairlead.robot.home_check import smallest_singular_values
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import read_skill
from fairlead_tools.draft.derived_urdf import position_range
from fairlead_tools.draft.source_model import load_source
from fairlead_tools.skills.skeleton import skill_skeleton
from tests.draft.drafting import Desk
from tests.draft.own_arms import drafted, straight_arm, without_gripper


def test_an_arm_without_a_gripper_is_told_where_its_tool_moves(desk: Desk) -> None:
    robot = drafted(desk, "bare", without_gripper())
    (desk.folder / "mine").mkdir()
    for file, text in skill_skeleton("mine", robot, "cartesian_delta").items():
        (desk.folder / "mine" / file).write_text(text)
    assert [tool.actuated for tool in robot.end_effectors] == [False]
    assert admission_problems(read_skill(desk.folder / "mine"), robot) == []


def test_a_home_where_the_tool_is_singular_is_said_by_new_and_check(desk: Desk) -> None:
    done = desk.new("straight", "--mjcf", desk.write("straight.xml", straight_arm()))
    assert done.returncode == 0, done.stderr
    said = "home is singular for the tool of arm: smallest singular value "
    (line,) = [one for one in done.stdout.splitlines() if one.startswith(said)]
    assert line.endswith(", limit 0.03")
    assert desk.check("straight")[0] == 0
    assert ("home", line) in desk.findings("straight", "open")


def test_a_bent_home_is_no_finding(desk: Desk) -> None:
    robot = drafted(desk, "bare", without_gripper())
    assert robot.home is not None
    (value,) = smallest_singular_values(robot, robot.home.positions).values()
    limit = robot.profile("sim").parts["arm"].singularity_limit
    assert 0.03 < value / 2.0 < 0.1 and limit == round(value / 2.0, 3)
    assert "home" not in [subject for subject, _ in desk.findings("bare", "open")]


def test_end_stops_of_the_model_hold_for_a_joint_that_the_urdf_calls_continuous(desk: Desk) -> None:
    model = desk.example()
    assert desk.new("first", "--mjcf", model).returncode == 0
    urdf = (desk.robots / "first" / "first.urdf").read_text()
    turning = re.sub(r'(<joint name="pan" type=)"revolute"', r'\1"continuous"', urdf)
    assert turning != urdf
    done = desk.new("mine", "--mjcf", model, "--urdf", desk.write("maker.urdf", turning))
    assert done.returncode == 0, done.stderr
    joint = load_robot("mine").joint("pan")
    assert (joint.type, joint.lower, joint.upper) == ("revolute", -2.8, 2.8)


def test_a_servo_that_is_geared_backwards_reaches_the_other_way(desk: Desk) -> None:
    servo = '<position joint="roll" gear="-1" ctrlrange="0 1"/>'
    model = desk.example(('<position joint="roll"/>', servo))
    source = load_source(model)
    number = source.model.joint("roll").id
    assert position_range(source, number) == (-1.0, 0.0)


def test_a_link_whose_shape_only_the_urdf_has_is_no_frame(desk: Desk) -> None:
    """MuJoCo fuses the fixed base of a URDF that it converts with the world."""
    ball = '<collision><geometry><sphere radius="0.05"/></geometry></collision>'
    robot = drafted(desk, "first", without_gripper())
    urdf = robot.description_path().read_text()
    (link,) = re.findall(r'<link name="base"[^>]*/>|<link name="base".*?</link>', urdf, flags=re.S)
    maker = desk.write("maker.urdf", urdf.replace(link, f'<link name="base">{ball}</link>'))
    geom = '      <geom type="cylinder" size="0.07" fromto="0 0 0 0 0 0.1"/>\n'
    model = desk.write("fused.xml", without_gripper().replace(geom, ""))
    assert desk.new("mine", "--mjcf", model, "--urdf", maker).returncode == 0
    only = "collision geometry only in its URDF"
    said = load_robot("mine").to_confirm["no_collision_geometry.base"]
    assert said.startswith(f"it has {only}, so no capsule: give it collision geometry in ")
    assert said.endswith("mine.xml, or say why it needs none")
    assert ("capsules", f"base: {only}; declared: {only}") in desk.findings("mine", "open")


def test_the_effort_of_motors_is_what_they_can_be_told(desk: Desk) -> None:
    """A model with motors, as many are, and with the gear of one."""
    motor = '<motor joint="pan" ctrlrange="-20 30" ctrllimited="true" gear="-2"/>'
    text = without_gripper().replace('<position joint="pan"/>', motor)
    joint = drafted(desk, "motored", text).joint("pan")
    assert (joint.effort_nm, "assumed" in joint.source) == (60.0, True)
    assert "joints.pan.effort_nm" not in load_robot("motored").to_confirm


def test_an_effort_that_gravity_exceeds_is_found_before_the_gate_stops_for_it(desk: Desk) -> None:
    weak = without_gripper().replace('forcerange="-40 40"', 'forcerange="-1.5 1.5"')
    drafted(desk, "weak", weak.replace(' gravcomp="1"', ""))
    found = [text for subject, text in desk.findings("weak", "open") if subject == "servos"]
    said = r"lift: gravity and friction take up to [\d.]+ N m"
    assert [text for text in found if re.fullmatch(said, text)], found
