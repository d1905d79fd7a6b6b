"""A person drives a mobile base; what is wrong on the command line is said."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from bench.equipment.light_hal import LIGHT_HAL
from fairlead.deploy.registry import Registry
from fairlead.messages import floats
from fairlead.paths import repo_root
from fairlead_tools.supervisor.scratch import (
    ScratchOptions,
    ScratchRobot,
    make_scratch,
    scratch_robot,
)
from tests.cli.command import fairlead_here, terminal

pytestmark = [pytest.mark.processes, pytest.mark.timeout(120)]

SOURCE = repo_root() / "compose/panda_mobile_sim.yaml"


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[ScratchRobot]:
    folder = tmp_path_factory.mktemp("base")
    scratch = make_scratch(SOURCE, folder / "up", ScratchOptions(hal=LIGHT_HAL))
    with scratch_robot(scratch, Registry(folder / "registry")) as robot:
        yield robot


def come(running: ScratchRobot) -> tuple[float, float]:
    """The base's x in odom [m], and sine of half its yaw."""
    for batch in running.client.transforms():
        for one in batch.transforms:
            if (one.parent, one.child) == ("odom", "base_link"):
                return float(floats(one.translation)[0]), float(floats(one.rotation_xyzw)[2])
    raise AssertionError


def test_a_base_in_lockstep_drives_ahead_turns_and_stands_between(
    running: ScratchRobot, tmp_path: Path
) -> None:
    person = terminal(tmp_path, "teleop", "-d", str(running.scratch.file), "--part", "base")
    try:
        person.wait_for("you drive base")
        assert [claim.parts for claim in running.client.gate_status().claims] == [("base",)]
        start = come(running)
        person.press(" ")
        person.hold("w", lambda: come(running)[0] > start[0] + 0.1, "it drives ahead")
        person.wait_for("clutch in | ")
        person.hold("j", lambda: come(running)[1] > start[1] + 0.05, "it turns left")
        assert "refused" not in person.output
        person.press("x")
        assert person.ended() == 0
    finally:
        person.end()


def test_a_base_is_jogged_along_its_own_axes(running: ScratchRobot, tmp_path: Path) -> None:
    where = ("--deployment", str(running.scratch.file))
    words = ("jog", "x", "-0.2", "--part", "base", "--speed", "1")
    done = fairlead_here(*words, *where, state=tmp_path)
    assert done.returncode == 0, done.stderr
    assert -0.22 < float(done.stdout.split()[2]) < -0.18


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["teleop"], "keyboard: expected a terminal on standard input, got none"),
        (["teleop", "--part", "leg"], "robot panda_mobile: expected a part, got 'leg' (valid"),
        (["teleop", "--mode", "warp"], "expected a mode to drive by hand, got 'warp' (valid"),
        (["teleop", "--device", "mouse"], "teleop: expected keyboard, gamepad, a gamepad"),
        (["teleop", "--device", "/dev/no"], "gamepad: /dev/no: No such file or directory"),
        (["jog", "grip", "1", "--part", "gripper"],
         "part gripper: expected an arm or a base, got a gripper: fairlead teleop opens and"),
        (["jog", "w", "1"], "robot panda_mobile: expected a joint or an axis, got 'w'"),
        (["jog", "x", "1rad"], "jog: expected a way for x, as 0.05 [m], got '1rad' (valid: m, mm,"),
        (["jog", "x", "-.1deg"], "jog: expected a way for x, as 0.05 [m], got '-.1deg' (valid: "),
        (["jog", "x", "nan"], "jog: expected a way for x, as 0.05 [m], got 'nan'"),
        (["jog", "x", "1e9"], "jog: expected a way of at most 10 m, got '1e9' [m] (valid: m, mm,"),
        (["jog", "x", "11m"], "jog: expected a way of at most 10 m, got '11m'\n"),
        (["jog", "base_x", "5cm"], "; base_x is of part base, which moves along x, y, rz: --part"),
        (["jog", "gripper", "1cm"], "part gripper: expected an arm or a base, got a gripper: "),
        (["jog", "x", "1mm"], "jog x: expected more than 0.002 m, as near as cartesian_delta"),
        (["home"], "no part is told joint_position, so joints cannot go home; a skill can: "),
    ],
)  # fmt: skip
def test_what_is_wrong_on_the_command_line_is_said_before_anything_is_armed(
    running: ScratchRobot, tmp_path: Path, words: list[str], said: str
) -> None:
    done = fairlead_here(*words, "-d", str(running.scratch.file), state=tmp_path)
    assert (done.returncode, done.stdout) == (1, "")
    assert said in done.stderr
    assert not running.client.gate_status().claims
