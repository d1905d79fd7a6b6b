"""What a skill may do on arms that somebody brings: without a gripper, or slow ones."""

from __future__ import annotations

from fairlead.skill.admission import admission_problems
from fairlead.skill.manifest import read_skill
from fairlead_tools.skills.skeleton import skill_skeleton
from tests.draft.drafting import Desk
from tests.draft.own_arms import drafted, without_gripper


def test_an_arm_without_a_gripper_is_told_where_its_tool_moves(desk: Desk) -> None:
    robot = drafted(desk, "bare", without_gripper())
    (desk.folder / "mine").mkdir()
    for file, text in skill_skeleton("mine", robot, "cartesian_delta").items():
        (desk.folder / "mine" / file).write_text(text)
    assert [tool.actuated for tool in robot.end_effectors] == [False]
    assert admission_problems(read_skill(desk.folder / "mine"), robot) == []
