"""What keys mean, and how long."""

from __future__ import annotations

import pytest

from fairlead.errors import ConfigError
from fairlead_tools.teleop.keyboard import AGAIN_S, HELD_S, Keys

TOOL = ("x", "y", "z", "rx", "ry", "rz")


ARROWS_AND_FUNCTION_KEYS = (
    "\x1b[A", "\x1b[B", "\x1b[C", "\x1b[D", "\x1bOP", "\x1bOS", "\x1b[15~", "\x1b[3~", "\x1b[1;5D",
    "\x1bw", "\x1b[[A", "\x1b[[B", "\x1b[[C", "\x1bO2S", "\x1bO5R",
)  # fmt: skip


def pressed(keys: str, names: tuple[str, ...] = TOOL) -> Keys:
    made = Keys(names, 0.5)
    for key in keys:
        made.press(key, 1.0)
    return made


@pytest.mark.parametrize(
    ("key", "axes"),
    [
        ("w", (1, 0, 0, 0, 0, 0)),
        ("s", (-1, 0, 0, 0, 0, 0)),
        ("d", (0, -1, 0, 0, 0, 0)),
        ("r", (0, 0, 1, 0, 0, 0)),
        ("o", (0, 0, 0, 1, 0, 0)),
        ("k", (0, 0, 0, 0, -1, 0)),
        ("j", (0, 0, 0, 0, 0, 1)),
        ("wa", (1, 1, 0, 0, 0, 0)),
        ("ws", (0, 0, 0, 0, 0, 0)),
        ("W", (1, 0, 0, 0, 0, 0)),
        *((key, (0, 0, 0, 0, 0, 0)) for key in ARROWS_AND_FUNCTION_KEYS),
        ("\x1b[Aw", (1, 0, 0, 0, 0, 0)),
        ("\x1bOPw", (1, 0, 0, 0, 0, 0)),
    ],
)
def test_a_key_drives_its_axis_while_it_is_held(key: str, axes: tuple[float, ...]) -> None:
    assert pressed(key).read(1.0).axes == axes
    assert pressed(key).read(1.0 + HELD_S).axes == axes
    assert pressed(key).read(1.001 + HELD_S).axes == (0,) * 6


@pytest.mark.parametrize("key", ARROWS_AND_FUNCTION_KEYS)
def test_a_key_of_several_letters_means_nothing_though_they_come_apart(key: str) -> None:
    keys = pressed(" ")
    for number, letter in enumerate(key):
        keys.press(letter, 1.0)
        told = keys.read(1.0 + number * 1e-3)
        assert (told.clutch, told.wish, told.grip) == (True, "", 0.0)
        assert not any(told.axes)


def test_after_the_escape_key_the_space_bar_still_stops() -> None:
    for later_s in (0.01, 1.0):
        keys = pressed(" \x1b")
        keys.press(" ", 1.0 + later_s)
        assert not keys.read(1.0 + later_s).clutch


def test_joints_have_the_upper_row_for_one_way_and_the_middle_row_for_the_other() -> None:
    names = tuple(f"joint{number}" for number in range(10))
    assert pressed("qs;", names).read(1.0).axes == (1, -1, 0, 0, 0, 0, 0, 0, 0, -1)
    with pytest.raises(ConfigError, match="keyboard: expected at most 10 joints to drive by keys"):
        Keys((*names, "joint10"), 0.5)


def test_the_space_bar_lets_the_clutch_in_and_out_and_giving_back_lets_it_out() -> None:
    assert not pressed("").read(1.0).clutch
    assert pressed(" ").read(1.0).clutch
    assert not pressed("  ").read(1.0).clutch
    back = pressed(" b").read(1.0)
    assert (back.clutch, back.wish) == (False, "give back")


def test_a_space_bar_that_is_held_to_stop_only_lets_the_clutch_out() -> None:
    keys, repeats = pressed(" "), [4.0, 4.5, 4.533, 4.566]
    for now_s in repeats:
        keys.press(" ", now_s)
        assert not keys.read(now_s).clutch
    keys.press(" ", repeats[-1] + AGAIN_S)
    assert not keys.read(6.0).clutch
    keys.press(" ", 7.0)
    assert keys.read(7.0).clutch


def test_a_wish_is_told_once_speed_has_steps_and_ends_and_the_gripper_two_keys() -> None:
    keys = pressed("x+++++++++++")
    assert (keys.read(1.0).wish, keys.read(1.0).wish) == ("quit", "")
    assert (keys.read(1.0).speed, pressed("-").read(1.0).speed) == (1.0, 0.4)
    assert pressed("-" * 99).read(1.0).speed == 0.02
    assert (pressed("v").read(1.0).grip, pressed("c").read(1.0).grip) == (1.0, -1.0)
