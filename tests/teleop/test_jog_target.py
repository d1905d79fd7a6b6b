"""How far a jogged tool has come: said by its own transform, waited for no longer than it pays."""

from __future__ import annotations

import math
import time
from typing import Any, cast

import numpy as np
import pytest

from fairlead.messages import Transform, TransformBatch, pack_floats
from fairlead.operate.tick import Tick
from fairlead_tools.teleop.target import BaseWay, Target, ToolWay, tolerance
from tests.teleop.drives import drive

ARM = drive("panda_mobile", "arm")


def batch(parent: str, child: str, x: float = 0.0) -> TransformBatch:
    place, turn = pack_floats([x, 0.0, 0.0]), pack_floats([0.0, 0.0, 0.0, 1.0])
    moved = Transform(parent=parent, child=child, translation=place, rotation_xyzw=turn)
    return TransformBatch(session=1, tick=9, is_static=False, transforms=(moved,))


class Heard:
    """Transforms that come at once, one after the other, for ever."""

    def __init__(self, *batches: TransformBatch) -> None:
        self._batches, self.asked = batches, 0

    def next(self, timeout_s: float) -> TransformBatch:
        assert timeout_s > 0.0
        self.asked += 1
        return self._batches[min(self.asked, len(self._batches)) - 1]


def tick() -> Tick:
    joints: Any = None  # a tool's way needs none
    return Tick(9, joints, {})


def test_other_frames_that_come_for_ever_are_not_waited_through() -> None:
    heard: Any = Heard(batch("odom", "base_link"))
    began_s = time.monotonic()
    way = ToolWay(ARM, heard)(tick())
    assert np.isnan(way).all() and len(way) == len(ARM.columns)
    assert heard.asked > 1
    assert time.monotonic() - began_s < 20.0, "it waits for ever"


def test_the_way_is_that_of_the_tool_since_the_start() -> None:
    heard: Any = Heard(
        batch("odom", "base_link"), batch(ARM.frame, ARM.tool), batch(ARM.frame, ARM.tool, 0.05)
    )
    at = ToolWay(ARM, heard)
    assert not at(tick()).any()
    assert math.isclose(at(tick())[0], 0.05)


class Turning:
    """A base that does as it is told, told as a tick tells it."""

    def __init__(self) -> None:
        self.yaw = 0.0

    def planar_pose(self, parent: str, child: str) -> tuple[float, float, float]:
        return 0.0, 0.0, math.remainder(self.yaw, math.tau)


@pytest.mark.parametrize("goal", [math.radians(200.0), math.radians(-350.0)])
def test_a_base_turns_by_more_than_half_a_turn_and_no_further(goal: float) -> None:
    base, robot = drive("panda_mobile", "base"), Turning()
    axis, tick_of = base.names.index("rz"), cast(Any, robot)
    step = np.zeros(len(base.names))
    step[axis] = goal
    way, now_s = BaseWay(base, "base_link"), 0.0
    target = Target(base, lambda at: at + step, tolerance(base), 0.3)
    for _ in range(5000):
        now_s += 0.05
        asked = target.read(now_s, way(tick_of))
        if asked.wish:
            break
        robot.yaw += asked.axes[axis] * base.full[axis] * asked.speed
    assert target.is_there
    assert abs(robot.yaw - goal) <= tolerance(base)[axis]


def test_slowly_over_a_long_way_is_no_standing_still() -> None:
    base, speed = drive("panda_mobile", "base"), 0.02
    step = np.zeros(len(base.names))
    step[0] = 10.0
    target, at, now_s = (
        Target(base, lambda now: now + step, tolerance(base), speed),
        0.0 * step,
        0.0,
    )
    for _ in range(20_000):
        now_s += 0.05
        asked = target.read(now_s, at)
        if asked.wish:
            break
        at = at + np.array(asked.axes) * base.full * speed
    assert target.is_there, at
