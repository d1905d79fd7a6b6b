"""How far a jogged tool has come: said by its own transform, waited for no longer than it pays."""

from __future__ import annotations

import math
import time
from typing import Any

import numpy as np

from fairlead.messages import Transform, TransformBatch, pack_floats
from fairlead.operate.tick import Tick
from fairlead_tools.teleop.target import ToolWay
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
