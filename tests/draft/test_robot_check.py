"""``fairlead robot check``: what does not fit together is named, each with its fix."""

from __future__ import annotations

from pathlib import Path

import pytest

from fairlead.hal.backend import describe_part
from fairlead.messages import HalStatus
from fairlead.robot.manifest import load_robot
from fairlead_tools.draft.robot_check import check_robot
from tests.cli.command import fairlead_here as fairlead
from tests.draft.drafting import Desk
from tests.shape.own_robot import NAME, own_robot
from tests.shape.wrong_descriptions import MISTAKES, mistaken


@pytest.fixture
def panda(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder of a robot of one's own that is a panda."""
    folder = own_robot(tmp_path, monkeypatch)
    assert fairlead("robot", "compile", NAME, state=tmp_path).returncode == 0
    return folder


def test_each_frame_that_is_off_is_in_the_table_with_mm_and_rad(panda: Path) -> None:
    desk, urdf = Desk(panda.parent), panda / "panda.urdf"
    assert desk.check(NAME)[0] == 0
    urdf.write_text(mistaken(urdf.read_text(), MISTAKES["a link turned by 180 degrees"]))
    code, found = desk.check(NAME)
    assert code == 1
    off = {one["frame"]: one for one in found["frames"] if one["home_rad"] > 1e-3}
    assert [round(one["random_rad"], 3) for one in off.values()] == [3.142]
    assert ("frames", "URDF and MJCF disagree on panda_link2") in desk.findings(NAME, "wrong")
    done = fairlead("robot", "check", NAME, state=desk.folder)
    assert done.returncode == 1
    assert any(line.split()[:3] == ["panda_link2", "0", "3.1"] for line in done.stdout.splitlines())


def test_what_the_gate_lacks_is_missing_and_each_has_its_command(panda: Path) -> None:
    desk = Desk(panda.parent)
    stale = ("gate file", "gate.sim.json is of other files than those here")
    for other in (b"{}", b"\xff"):
        (panda / "gate.sim.json").write_bytes(other)
        assert desk.findings(NAME, "wrong") == [stale]
    done = fairlead("robot", "compile", NAME, "--check", state=desk.folder)
    assert done.returncode == 1 and "gate.sim.json is not current" in done.stderr, done.stderr
    (panda / "gate.sim.json").unlink()
    assert desk.findings(NAME, "missing") == [("gate file", "gate.sim.json is not there")]
    (panda / "capsules.yaml").unlink()
    fixes = {one["subject"]: one["fix"] for one in desk.check(NAME)[1]["findings"]}
    assert fixes["capsules"] == f"fairlead robot capsules {NAME}"


def test_a_link_that_is_only_drawn_and_a_servo_that_lags_are_named(panda: Path) -> None:
    desk, model = Desk(panda.parent), panda / "mine.xml"
    text = model.read_text()
    start = text.index("<geom", text.index('<body name="panda_link5"'))
    end = text.index("<body", start)
    drawn = text[start:end].replace("<geom ", '<geom contype="0" conaffinity="0" ')
    model.write_text((text[:start] + drawn + text[end:]).replace('kv="250"', 'kv="1500"'))
    capsules = panda / "capsules.yaml"
    capsules.write_text(capsules.read_text().replace("panda_link5", "panda_link8"))
    named = dict(one[::-1] for one in desk.findings(NAME, "missing", "wrong"))
    assert "panda_link5: only visual geometry" in named
    late = [found for subject, found in desk.findings(NAME, "open") if subject == "servos"]
    assert late[0].startswith("panda_joint1: at 1.1 rad/s its servo is 0.41")


def test_a_hal_of_another_robot_is_told_apart_by_joints_parts_and_hash(panda: Path) -> None:
    robot = load_robot(NAME)
    parts = tuple(describe_part(robot, part, "sim") for part in robot.parts)
    status = HalStatus(
        session=1, robot=NAME, robot_hash=robot.robot_hash, pacing="lockstep",
        period_ns=robot.tick_period_ns, tick=1, episode_tick=1, state="ready", detail="",
        joints=robot.joint_names, passive_joints=robot.passive_joint_names, parts=parts,
        simulator_order=(), cameras=(), has_task=False, overruns=0,
    )  # fmt: skip
    assert check_robot(robot, status).is_good
    swapped = (*robot.joint_names[1::-1], *robot.joint_names[2:])
    other = HalStatus(
        **{name: getattr(status, name) for name in status.__struct_fields__}
        | {"joints": swapped, "parts": parts[:1], "robot_hash": bytes(32)}
    )
    wrong = [one.found for one in check_robot(robot, other).findings if one.subject == "HAL"]
    assert [one.split(":")[0] for one in wrong] == ["joints", "parts", "modes", "robot hash"]
    assert not check_robot(robot, other).is_good
