"""What a base that turns was released to do, and what it did."""

from __future__ import annotations

from collections.abc import Sequence

from bench.equipment.motion_log import MotionLine
from fairlead.keys import Keys
from fairlead.messages import FloatArray, Hold, JointState, SafeChunk, decode, floats
from fairlead.robot.manifest import load_robot
from fairlead.wire.bus import Bus, Sample

ROBOT = load_robot("panda_mobile")
BASE = ROBOT.part_names.index("base")
_COLUMN = ROBOT.joint_names.index("base_yaw")
_MEASURED = ROBOT.measured_joint_names.index("base_yaw")


class TurningBase:
    """Hears what the gate releases for the base, and where it turns.

    rows: turning speeds [rad/s] of each released chunk, by verdict. yaw: by tick [rad].
    """

    def __init__(self, bus: Bus, keys: Keys) -> None:
        self.rows: dict[int, FloatArray] = {}
        self.yaw: dict[int, float] = {}
        bus.subscribe(keys.every_safe, self._on_rows)
        bus.subscribe(keys.joints, self._on_joints)

    def _on_rows(self, sample: Sample) -> None:
        chunk = decode(SafeChunk, sample.payload)
        for part in chunk.parts:
            if part.part == BASE:
                rows = floats(part.values).reshape(chunk.horizon, -1)
                self.rows[chunk.verdict_id] = rows[:, _COLUMN]

    def _on_joints(self, sample: Sample) -> None:
        joints = decode(JointState, sample.payload)
        self.yaw[joints.tick] = float(floats(joints.positions)[_MEASURED])

    def clear(self) -> None:
        """Forget it all."""
        self.rows.clear()
        self.yaw.clear()

    def speed(self, line: MotionLine) -> float | None:
        """Of the row that acted [rad/s]; None: none did, or its chunk was not heard."""
        verdict, row = line.rows[BASE]
        rows = self.rows.get(verdict)
        if line.holds[BASE] != Hold.NONE or rows is None or row >= len(rows):
            return None
        return float(rows[row])

    def largest_turn(self, lines: Sequence[MotionLine]) -> float:
        """From one of these ticks to the next [rad]."""
        ticks = [line.tick for line in lines]
        steps = [
            abs(self.yaw[tick + 1] - self.yaw[tick])
            for tick in ticks
            if tick in self.yaw and tick + 1 in self.yaw
        ]
        return max(steps, default=0.0)
