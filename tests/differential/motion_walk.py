"""Robots that are told rows and do about what they are told: sometimes more, sometimes less."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio

from bench.equipment.case import Measured, PartRows, still
from bench.equipment.kinematics import quaternion_of, rotation_of
from fairlead.messages import FloatArray
from tests.differential.gate_file import JOINT_MODES, GateFile, Part
from tests.differential.motion_judge import BODY, CLOSED, DELTA, HALVES, POSE, TARGETS, VELOCITY
from tests.differential.quiet import let_tools_be_fast

ROWS = 8
FREEDOM = 1.4
"""How far beyond its tracking limit a motion may be, as a share of it."""
FAR_M = 1e4
ENCODER_STEP, DEAD_BAND, STUCK_TICKS = 1e-4, 2e-3, 3


def narrowed(config: Path, folder: Path) -> Path:
    """The gate file with limits that a robot comes near, and surroundings that it does not."""
    data = json.loads(config.read_text())
    _clear_the_way(data)
    data["protocol"]["stuck_ticks"] = STUCK_TICKS
    for joint in data["joints"]:
        joint |= {"encoder_step": ENCODER_STEP, "dead_band": DEAD_BAND, "contact_limit": 12.0}
    for part in data["parts"]:
        for name, block in part["modes"].items():
            _narrow(name, block, len(part["joints"]))
    path = folder / f"gate.{data['robot']}.json"
    path.write_text(json.dumps(data))
    return path


def _clear_the_way(data: dict[str, Any]) -> None:
    """Far walls, links that never meet, joints that brake at once: nothing ahead is in the way."""
    for joint in data["joints"]:
        if joint["acceleration_limit"] is not None:  # null for a gripper's
            joint["acceleration_limit"] = 1e30
    for part in data["parts"]:
        if part["singularity_limit"] is not None:
            part["singularity_limit"] = 1e-12
    let_tools_be_fast(data)
    for number, capsule in enumerate(data["collision"]["capsules"]):
        capsule |= {"a": [0.0, 0.0, 100.0 * number], "b": [0.0, 0.0, 100.0 * number]}
        capsule["radius"] = 0.001
    for volume in data["workspace"]["volumes"]:
        volume |= {"kind": "keep_in", "lower": [-FAR_M] * 3, "upper": [FAR_M] * 3}
    if data["base"] is not None:
        data["base"]["command_frame"] = "odom"
    square = [[-FAR_M, -FAR_M], [FAR_M, -FAR_M], [FAR_M, FAR_M], [-FAR_M, FAR_M]]
    for zone in (data["base"] or {"zones": []})["zones"]:
        zone |= {"kind": "keep_in", "corners": square}


def _narrow(mode: str, block: dict[str, Any], joints: int) -> None:
    per_second = 20.0 if mode in ("cartesian_twist", "body_twist") else 1.0
    if mode in ("joint_position", "dex_hand_joint"):
        block["tracking"] = [0.03] * joints
    elif mode == "joint_velocity":
        block |= {"tracking": [0.08] * joints, "gain": [0.3, 0.9]}
    elif mode == "gripper_position":
        block["slip_limit"] = 0.004
    elif mode.startswith("cartesian_") or mode == "body_twist":
        tracking = {"linear_tracking": 0.004, "angular_tracking": 0.02}
        block |= {name: value * per_second for name, value in tracking.items()}
        if mode != "cartesian_pose":
            block["gain"] = [0.2, 0.9]


class MotionMaker:
    """Draws rows for one part, and states of a robot that was told them."""

    def __init__(self, file: GateFile, rng: np.random.Generator, period_s: float) -> None:
        self._file, self._rng, self._period_s = file, rng, period_s

    def start(self) -> Measured:
        """At rest, away from every bound, where arms are bent."""
        joints = (*self._file.joints, *self._file.passive)
        ends = [(max(j.lower, -4.0), min(j.upper, 4.0)) for j in joints]
        share = self._rng.uniform(0.35, 0.65, len(ends))
        positions = [low + s * (high - low) for (low, high), s in zip(ends, share, strict=True)]
        return still(int(self._rng.integers(2, 100)), np.array(positions))

    def rows(self, index: int, mode: int, state: Measured) -> PartRows:
        """Eight rows from where the robot is; mostly of the kind that a gate releases."""
        part = self._file.parts[index]
        block = part.modes[mode]
        if mode in JOINT_MODES:
            return self._joint_rows(index, part, mode, state)
        if mode in HALVES:
            return self._half_rows(index, mode, block)
        if mode == POSE:
            return self._pose_rows(index, part, block, state)
        if mode == CLOSED:
            return PartRows(index, mode, np.full((ROWS, 1), float(self._rng.integers(2))))
        opening = state.positions[part.joints[0]]
        target = np.clip(opening + self._rng.uniform(-0.02, 0.02), block["lower"], block["upper"])
        return PartRows(index, mode, np.full((ROWS, 1), target))

    def _joint_rows(self, index: int, part: Part, mode: int, state: Measured) -> PartRows:
        step = np.array(part.modes[mode]["step_limit"])
        start = state.positions[list(part.joints)] if mode in TARGETS else np.zeros(len(step))
        steps = self._rng.uniform(-0.4, 0.4, (ROWS, len(step))) * step
        if self._rng.random() < 0.5:  # all in one direction, and far
            steps = np.abs(steps)
        values = np.zeros((ROWS, len(self._file.joints)))
        values[:, part.joints] = start + np.cumsum(steps, axis=0)
        return PartRows(index, mode, values, active=part.joints)

    def _half_rows(self, index: int, mode: int, block: dict[str, Any]) -> PartRows:
        axes = np.isin(np.arange(6), block.get("free_axes", range(6)))
        values = np.zeros((ROWS, 6))
        row = np.zeros(6)
        for k in range(ROWS):
            if k == 0 or self._rng.random() < 0.4:
                for half, name in ((slice(0, 3), "linear"), (slice(3, 6), "angular")):
                    most = min(block[f"{name}_limit"], 0.4 * block[f"{name}_step_limit"])
                    row[half] = self._ball(most * 0.8)
            values[k] = row * axes
        frame = str(self._rng.choice(block["frames"]))
        return PartRows(index, mode, values, frame)

    def _pose_rows(
        self, index: int, part: Part, block: dict[str, Any], state: Measured
    ) -> PartRows:
        assert part.tool is not None
        frame = str(self._rng.choice(block["frames"]))
        place, turn = self._file.kinematics.pose(state.positions, part.tool, frame)
        values = np.zeros((ROWS, 7))
        for k in range(ROWS):
            place = place + self._ball(0.4 * min(block["linear_step_limit"], 0.02))
            twist = self._ball(0.4 * min(block["angular_step_limit"], 0.1))
            turn = pinocchio.exp3(twist) @ turn
            values[k] = [*place, *quaternion_of(turn)]
        return PartRows(index, POSE, values, frame)

    # --- what the robot does ---

    def follow(self, part: Part, rows: PartRows, row: int, last: Measured) -> Measured:
        """About what the row says, near the limits of the tracking model."""
        positions, velocities = last.positions.copy(), np.zeros(len(last.positions))
        values, own = rows.values[row], list(part.joints)
        block = part.modes[rows.mode]
        if rows.mode in TARGETS:
            off = self._off(np.array(block["tracking"]))
            positions[own] = values[own] + off
        elif rows.mode == VELOCITY:
            share = self._rng.uniform(0.25, 0.95, len(own))
            velocities[own] = share * values[own] + self._off(np.array(block["tracking"]))
            positions[own] += velocities[own] * self._period_s
        elif rows.mode in HALVES or rows.mode == POSE:
            positions[own] += self._tool_or_base(part, rows, row, last)
            velocities[own] = (positions[own] - last.positions[own]) / self._period_s
        else:
            target = float(values[0])
            if rows.mode == CLOSED:
                joint = self._file.joints[own[0]]
                target = joint.lower if target == 1.0 else joint.upper
            positions[own] = self._slip(target, float(positions[own[0]]))
        reach = np.array([j.jump_limit for j in (*self._file.joints, *self._file.passive)])
        moved = np.clip(positions - last.positions, -0.9 * reach, 0.9 * reach)
        if self._rng.random() < 0.1:  # this joint's sensor rests
            moved[int(self._rng.choice(own))] = 0.0
        return Measured(last.tick + 1, last.positions + moved, velocities, self._efforts())

    def frozen(self, last: Measured) -> Measured:
        """Nothing changes but the noise of the sensors, which is too little."""
        size = len(last.positions)
        noise = self._rng.uniform(-1.02, 1.02, size) * ENCODER_STEP * self._rng.choice([0.0, 1.0])
        positions = last.positions + noise
        return Measured(last.tick + 1, positions, np.zeros(size), self._efforts())

    def _tool_or_base(self, part: Part, rows: PartRows, row: int, last: Measured) -> FloatArray:
        block, values = part.modes[rows.mode], rows.values[row]
        limits = np.repeat([block["linear_tracking"], block["angular_tracking"]], 3)
        if rows.mode == POSE:
            wanted = self._to_pose(part, rows.frame, values, last) + self._off(limits / 1.7)
            return self._joint_motion(part, rows.frame, wanted, last)
        share = self._rng.uniform(0.1, 1.0)
        wanted = share * values + self._off(limits / 1.7)
        wanted *= 1.0 if rows.mode == DELTA else self._period_s
        if rows.mode == BODY:
            yaw = last.positions[part.joints[2]]
            x, y = wanted[:2]
            c, s = np.cos(yaw), np.sin(yaw)
            return np.array([c * x - s * y, s * x + c * y, wanted[5]])
        return self._joint_motion(part, rows.frame, wanted, last)

    def _to_pose(self, part: Part, frame: str, told: FloatArray, last: Measured) -> FloatArray:
        assert part.tool is not None
        place, turn = self._file.kinematics.pose(last.positions, part.tool, frame)
        rotation = np.asarray(pinocchio.log3(rotation_of(told[3:]) @ turn.T))
        return np.concatenate([told[:3] - place, rotation])

    def _joint_motion(
        self, part: Part, frame: str, wanted: FloatArray, last: Measured
    ) -> FloatArray:
        """Joint motion that moves the tool by about that much, by a damped inverse."""
        assert part.tool is not None
        columns = []
        for j in part.joints:
            one = np.zeros(len(last.positions))
            one[j] = 1.0
            columns.append(self._file.kinematics.twist(last.positions, one, part.tool, frame))
        jacobian = np.array(columns).T
        damped = jacobian.T @ np.linalg.inv(jacobian @ jacobian.T + 1e-6 * np.eye(6))
        return np.asarray(damped @ wanted)

    def _slip(self, target: float, opening: float) -> float:
        kind = self._rng.random()
        if kind < 0.6:
            return opening
        if kind < 0.8:
            return opening + float(np.sign(target - opening)) * float(self._rng.uniform(0, 0.006))
        return target

    def _efforts(self) -> FloatArray:
        size = len(self._file.joints) + len(self._file.passive)
        efforts = self._rng.uniform(-11.0, 11.0, size)
        if self._rng.random() < 0.02:
            efforts[int(self._rng.integers(size))] = self._rng.choice([12.0, -12.5, 12.5])
        return efforts

    def _off(self, limits: FloatArray) -> FloatArray:
        """Small mostly, sometimes beyond the limit."""
        most = FREEDOM if self._rng.random() < 0.25 else 0.5
        return np.asarray(self._rng.uniform(-most, most, len(limits)) * limits)

    def _ball(self, radius: float) -> FloatArray:
        direction = self._rng.normal(size=3)
        direction *= radius * self._rng.random() / np.linalg.norm(direction)
        return np.asarray(direction)
