"""What a skill may do on arms that somebody brings: without a gripper, or slow ones."""

from __future__ import annotations

from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import read_skill
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
    assert line.endswith(", limit 0.01")
    assert desk.check("straight")[0] == 0
    assert ("home", line) in desk.findings("straight", "open")


def test_a_bent_home_is_no_finding(desk: Desk) -> None:
    drafted(desk, "bare", without_gripper())
    assert "home" not in [subject for subject, _ in desk.findings("bare", "open")]
