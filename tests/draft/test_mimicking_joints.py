"""A finger that mimics another: the URDF's coupling is compared with the model's."""

from __future__ import annotations

import re

import mujoco
import numpy as np
import pytest

from fairlead.hal.mujoco_frames import follow, joint_ties
from fairlead.robot.manifest import load_robot
from tests.draft.drafting import Desk

TIE = '<joint joint1="right_finger" joint2="left_finger" polycoef="0.001 -1 0 0 0"/>'
COUPLED = '<mimic joint="left_finger" multiplier="-1" offset="0.001"/>'


def tied_hand(desk: Desk) -> tuple[str, str]:
    """The example with its fingers tied, and the URDF that is made of it."""
    model = desk.example(
        ('<position joint="right_finger" class="finger"/>', ""),
        ("<keyframe>", f"<equality>{TIE}</equality><keyframe>"),
    )
    assert desk.new("first", "--mjcf", model).returncode == 0
    urdf = (desk.robots / "first" / "first.urdf").read_text()
    assert COUPLED in urdf
    return str(model), urdf


@pytest.mark.parametrize("prefix", ["", "acme_"])
def test_another_multiplier_than_the_models_is_refused_by_link_and_found_by_the_check(
    prefix: str, desk: Desk
) -> None:
    model, urdf = tied_hand(desk)
    wrong = urdf.replace(COUPLED, COUPLED.replace('"-1"', '"1"'))
    named = re.sub(r'<(joint name|mimic joint)="', rf'<\1="{prefix}', wrong)
    done = desk.new("mine", "--mjcf", model, "--urdf", desk.write("maker.urdf", named))
    assert done.returncode == 1
    assert "are not the same robot" in done.stderr
    assert "link right_finger: " in done.stderr and "link left_finger: " not in done.stderr
    (desk.robots / "first" / "first.urdf").write_text(wrong)
    said = ("frames", "URDF and MJCF disagree on right_finger")
    assert said in desk.findings("first", "wrong")


def test_another_offset_than_the_models_is_to_be_confirmed_and_found_by_the_check(
    desk: Desk,
) -> None:
    model, urdf = tied_hand(desk)
    other = urdf.replace(COUPLED, COUPLED.replace("0.001", "0.01"))
    done = desk.new("mine", "--mjcf", model, "--urdf", desk.write("maker.urdf", other))
    assert done.returncode == 0, done.stderr
    assert load_robot("mine").to_confirm["simulator.frames.right_finger"].startswith("9.00 mm")
    (desk.robots / "first" / "first.urdf").write_text(other)
    said = ("frames", "URDF and MJCF disagree on right_finger")
    assert said in desk.findings("first", "wrong")


def test_a_finger_that_the_model_does_not_tie_is_not_compared(desk: Desk) -> None:
    _, urdf = tied_hand(desk)
    model = desk.example(('<position joint="right_finger" class="finger"/>', ""))
    done = desk.new("mine", "--mjcf", model, "--urdf", desk.write("maker.urdf", urdf))
    assert done.returncode == 0, done.stderr
    code, found = desk.check("mine")
    assert code == 0, found
    assert "right_finger" not in [one["frame"] for one in found["frames"]]


def test_what_follows_a_follower_stands_where_both_say_and_what_is_told_does_not_follow() -> None:
    bodies = "".join(
        f'<body><geom size="0.1"/><joint name="{name}" type="slide" ref="{ref}"/></body>'
        for name, ref in (("a", 0.0), ("b", 0.5), ("c", 0.0))
    )
    ties = (
        '<joint joint1="c" joint2="b" polycoef="0 2 1 0 0"/>'
        '<joint joint1="b" joint2="a" polycoef="0.1 -1 0 0 0"/>'
        '<joint joint1="a" joint2="c"/><joint joint1="c" joint2="a" active="false"/>'
    )
    model = mujoco.MjModel.from_xml_string(
        f"<mujoco><worldbody>{bodies}</worldbody><equality>{ties}</equality></mujoco>"
    )
    qpos = np.array([0.2, 0.0, 0.0])
    follow(model, qpos, joint_ties(model, {0}))
    assert qpos.tolist() == pytest.approx([0.2, 0.4, 2 * -0.1 + 0.1**2])


def test_a_tie_that_is_switched_off_ties_nothing(desk: Desk) -> None:
    off = TIE.replace("/>", ' active="false"/>')
    model = desk.example(
        ('<position joint="right_finger" class="finger"/>', ""),
        ("<keyframe>", f"<equality>{off}</equality><keyframe>"),
    )
    assert desk.new("first", "--mjcf", model).returncode == 0
    assert "<mimic" not in (desk.robots / "first" / "first.urdf").read_text()
