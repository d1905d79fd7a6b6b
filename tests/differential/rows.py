"""Rows of one part: a walk from where the robot is."""

from __future__ import annotations

import numpy as np
import pinocchio

from bench.equipment.case import Measured, PartRows
from bench.equipment.kinematics import quaternion_of, rotation_of
from fairlead.messages import FloatArray
from tests.differential.gate_file import JOINT_MODES, MODES, Block, GateFile
from tests.differential.steps import own_speeds


class RowMaker:
    """Draws rows for one robot."""

    def __init__(self, file: GateFile, rng: np.random.Generator) -> None:
        self._file = file
        self._rng = rng

    def draw(
        self, part: int, mode: int, count: int, measured: Measured, last: PartRows | None
    ) -> PartRows:
        """Mostly good rows: each a step within, or just beyond, the limit from the last."""
        block = self._file.parts[part].modes[mode]
        frame = str(self._rng.choice(block["frames"])) if "frames" in block else ""
        active = self._active(part) if mode in JOINT_MODES else ()
        start = self.start(part, mode, measured, frame)
        if last is not None and last.mode == mode and last.values.ndim == 2:
            start = last.values[0].copy()
        values = np.zeros((count, self._file.width(mode)))
        for row in range(count):
            start = self._step(part, mode, start)
            values[row] = start
        if mode in JOINT_MODES:
            idle = [n for n in range(values.shape[1]) if n not in active]
            values[:, idle] = 0.0
        return PartRows(part, mode, values, frame, active)

    def _active(self, part: int) -> tuple[int, ...]:
        joints = self._file.parts[part].joints
        if self._rng.random() < 0.8:
            return joints
        chosen = tuple(joint for joint in joints if self._rng.random() < 0.6)
        return chosen or joints[:1]

    def start(self, part: int, mode: int, measured: Measured, frame: str) -> FloatArray:
        """The row that would leave the part as it is measured; zeros where nothing is."""
        width = self._file.width(mode)
        joints = self._file.parts[part].joints
        tool, name = self._file.parts[part].tool, MODES[mode]
        if name == "cartesian_pose" and tool:
            place, turn = self._file.kinematics.pose(measured.positions, tool, frame)
            return np.concatenate([place, quaternion_of(turn)])
        if name == "cartesian_twist" and tool:
            q, v = measured.positions, own_speeds(self._file, part, measured.velocities)
            return self._file.kinematics.twist(q, v, tool, frame)
        if mode in JOINT_MODES:
            source = measured.velocities if name == "joint_velocity" else measured.positions
            return np.array(source[:width], dtype=np.float64)
        if width == 1:
            return np.array([measured.positions[joints[0]] if joints else 0.0])
        return np.zeros(width)

    def _step(self, part: int, mode: int, start: FloatArray) -> FloatArray:
        scale = float(self._rng.choice([0.2, 0.2, 0.6, 0.6, 1.05]))
        block = self._file.parts[part].modes[mode]
        if mode in JOINT_MODES:
            return self._joint_step(part, mode, start, scale)
        if MODES[mode] == "cartesian_pose":
            return self._pose_step(block, start, scale)
        if MODES[mode] == "gripper_binary":
            return np.array([float(self._rng.choice([0.0, 1.0, 1.0, 0.5]))])
        if "linear_limit" in block:
            three = [self._ball(block[f"{half}_limit"] * scale) for half in ("linear", "angular")]
            moved = np.concatenate(three)
            free = block.get("free_axes", range(6))
            return np.array([x if n in free else 0.0 for n, x in enumerate(moved)])
        lower, upper = block.get("lower", -1.0), block.get("upper", 1.0)
        step = block["step_limit"] * scale * self._rng.uniform(-1.0, 1.0)
        return np.array([self._kept(float(start[0] + step), lower, upper)])

    def _joint_step(self, part: int, mode: int, start: FloatArray, scale: float) -> FloatArray:
        joints = self._file.parts[part].joints
        limits = self._file.parts[part].modes[mode]["step_limit"]
        moved = start.copy()
        for place, index in enumerate(joints):
            joint = self._file.joints[index]
            top = joint.velocity_limit
            lower, upper = joint.lower, joint.upper
            if MODES[mode] == "joint_velocity":
                lower, upper = -top, top
            step = limits[place] * scale * self._rng.uniform(-1.0, 1.0)
            outside = max(lower - start[index], start[index] - upper, 0.0)
            if outside > 0.0 and self._rng.random() < 0.8:
                back = -1.0 if start[index] > upper else 1.0
                moved[index] = start[index] + back * abs(step)
            else:
                moved[index] = self._kept(start[index] + step, lower, upper)
        return moved

    def _pose_step(self, block: Block, start: FloatArray, scale: float) -> FloatArray:
        place = start[:3] + self._ball(block["linear_step_limit"] * scale)
        for n, (lower, upper) in enumerate(zip(block["lower"], block["upper"], strict=True)):
            place[n] = self._kept(float(place[n]), lower, upper)
        turned = self._turned(start[3:], block["angular_step_limit"] * scale * self._rng.random())
        return np.concatenate([place, turned * self._rng.choice([-1.0, 1.0])])

    def _turned(self, xyzw: FloatArray, angle: float) -> FloatArray:
        """The quaternion after a turn by that angle about any axis; of none, one turned by it."""
        if np.linalg.norm(xyzw) < 0.5:
            xyzw = np.array([0.0, 0.0, 0.0, 1.0])
        turn = pinocchio.exp3(self._ball(1.0, hollow=True) * angle)
        return quaternion_of(turn @ rotation_of(xyzw))

    def _kept(self, value: float, lower: float, upper: float) -> float:
        return min(max(value, lower), upper) if self._rng.random() < 0.97 else value

    def _ball(self, radius: float, hollow: bool = False) -> FloatArray:
        direction = self._rng.normal(size=3)
        direction /= np.linalg.norm(direction)
        if hollow:
            return np.asarray(direction * radius, dtype=np.float64)
        return np.asarray(direction * radius * self._rng.random(), dtype=np.float64)
