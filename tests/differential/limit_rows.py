"""Rows with numbers moved onto limits, next to them, and into the corners of what is allowed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from bench.equipment.case import Measured, PartRows
from fairlead.messages import FloatArray
from tests.differential.gate_file import JOINT_MODES, MODES, Block, GateFile
from tests.differential.rows import RowMaker
from tests.differential.states import nudged


class LimitMover:
    """Changes rows of one robot. file: with a claim's own limits in it."""

    def __init__(self, file: GateFile, rng: np.random.Generator) -> None:
        self._file = file
        self._rng = rng
        self._rows = RowMaker(file, rng)

    def moved(self, rows: PartRows, measured: Measured) -> PartRows:
        """The same rows with one number, or a whole row, moved onto limits."""
        if not len(rows.values):
            return rows
        values = rows.values.copy()
        row = int(self._rng.integers(len(values)))
        block = self._file.parts[rows.part].modes[rows.mode]
        if self._rng.random() < 0.2 and MODES[rows.mode] != "cartesian_pose":
            values[row] = self._corner(rows, block)
        elif rows.mode in JOINT_MODES:
            column = int(self._rng.choice(rows.active))
            here = self._rows.start(rows.part, rows.mode, measured, rows.frame)
            start = here if row == 0 else values[row - 1]
            edges = self._joint_edges(rows, column, float(start[column]))
            values[row, column] = nudged(float(self._rng.choice(edges)), self._rng)
        elif "linear_limit" in block:
            self._onto_norm(values, row, block)
        elif MODES[rows.mode] == "cartesian_pose":
            self._onto_box(values, row, block)
        elif MODES[rows.mode] == "gripper_binary":
            values[row, 0] = nudged(float(self._rng.choice([0.0, 1.0])), self._rng)
        else:
            values[row, 0] = nudged(float(self._rng.choice(self._scalar_edges(block))), self._rng)
        return replace(rows, values=values)

    def _corner(self, rows: PartRows, block: Block) -> FloatArray:
        """Every axis at its absolute limit at once."""
        row = np.zeros(rows.values.shape[1])
        if "linear_limit" in block:
            for half, name in enumerate(("linear_limit", "angular_limit")):
                free = [n for n in block.get("free_axes", range(6)) if n // 3 == half]
                signs = self._rng.choice([-1.0, 1.0], len(free))
                row[free] = signs * block[name] / math.sqrt(len(free))
            return row
        if len(row) == 1:
            ends = [block.get("lower", -1.0), block.get("upper", 1.0)]
            return np.array([self._rng.choice(ends)])
        for index in rows.active:
            joint, sign = self._file.joints[index], float(self._rng.choice([-1.0, 1.0]))
            bound = joint.upper if sign > 0.0 else joint.lower
            if MODES[rows.mode] == "joint_velocity":
                row[index] = sign * joint.velocity_limit
            else:
                row[index] = bound if math.isfinite(bound) else sign
        return row

    def _joint_edges(self, rows: PartRows, column: int, start: float) -> list[float]:
        part, joint = self._file.parts[rows.part], self._file.joints[column]
        step = part.modes[rows.mode]["step_limit"][part.joints.index(column)]
        edges = [start - step, start, start + step]
        rooms = (step + joint.tolerance, 2.0 * step + joint.tolerance)
        edges += [start + way * room for room in rooms for way in (-1.0, 1.0)]
        if MODES[rows.mode] == "joint_velocity":
            return [*edges, -joint.velocity_limit, joint.velocity_limit, 0.0]
        if math.isinf(joint.lower):
            return edges
        return [*edges, joint.lower, joint.upper]

    def _onto_norm(self, values: FloatArray, row: int, block: Block) -> None:
        """One half of the row gets a limit's norm, along one axis or in any direction."""
        half = int(self._rng.integers(2))
        name = str(self._rng.choice(["limit", "step_limit"]))
        limit = block[f"{('linear', 'angular')[half]}_{name}"]
        free = [n for n in block.get("free_axes", range(6)) if n // 3 == half]
        direction = np.zeros(6)
        if self._rng.random() < 0.5:
            direction[self._rng.choice(free)] = self._rng.choice([-1.0, 1.0])
        else:
            direction[free] = self._rng.normal(size=len(free))
            direction /= np.linalg.norm(direction)
        last = values[row - 1] if row and name == "step_limit" else np.zeros(6)
        three = slice(3 * half, 3 * half + 3)
        values[row, three] = (last + direction * nudged(limit, self._rng))[three]

    def _onto_box(self, values: FloatArray, row: int, block: Block) -> None:
        """A side of the box, a step of exactly the limit, or a quaternion of another norm."""
        kind = int(self._rng.integers(3))
        axis = int(self._rng.integers(3))
        if kind == 0:
            side = block[str(self._rng.choice(["lower", "upper"]))][axis]
            values[row, axis] = nudged(side, self._rng)
        elif kind == 1 and row:
            values[row] = values[row - 1]
            values[row, axis] += nudged(block["linear_step_limit"], self._rng)
        else:
            values[row, 3:] *= float(self._rng.choice([1.0 + 9e-7, 1.0 + 1.1e-6, 1.0 - 1e-5, 0.0]))

    def _scalar_edges(self, block: Block) -> list[float]:
        lower, upper = block.get("lower", -1.0), block.get("upper", 1.0)
        return [lower, upper, lower + block["step_limit"], upper - block["step_limit"]]
