"""Cartesian rows: along which axis the tool goes, by the description, and what its joints do."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.robot.description import description_tree
from fairlead.robot.safety_profile import outside_limits, profile_limits
from fairlead.robot.tool_chain import ToolChain
from fairlead_tools.conformance.plan import Rows
from fairlead_tools.conformance.row import Check, Row
from fairlead_tools.conformance.small_rows import OUT_ROWS
from fairlead_tools.conformance.stage import Run, Stage
from fairlead_tools.measure.driven_robot import Moment
from fairlead_tools.measure.drives import wish_of
from fairlead_tools.record.measured import rotation_vector

AXES = ("x", "y", "z", "rx", "ry", "rz")
HALVES = (slice(0, 3), slice(3, 6))
OFF_RAD = 0.5
SMALLEST = 1e-2
LEFT = 0.1
"""Of an axis that the joints can do alone no more than this is left over."""
LEAST = 0.03
"""Of what was told: a tool that made less did not move."""
SPEED_SLACK = 1.01
FULL_ROWS = 12
FULL_WISHES = 4
SEED = 7
TOOL = Check(
    "command frame", f"the tool goes along the axis that it is told, within {OFF_RAD} rad",
    "robot.yaml: frames; URDF; angle: own choice",
    "deltas and twists are along the axes of frame_id, not of the tool; correct the URDF",
)  # fmt: skip
TOOL_GAIN = Check(
    "tool gain", "its declared share of what is told",
    "robot.yaml: gain, tracking; slack: own choice",
    "deltas are per period, twists per second, in m and rad; correct gain",
)  # fmt: skip
LIMITS = Check(
    "joint limits under cartesian rows", "every joint within its speed (+1 %) and position limits",
    "robot.yaml: joints, tighter_joints, tolerance",
    "slow all joints of the part down together; hal_sim: option joint_speed_guard",
)  # fmt: skip
GAIN_SLACK = 0.5


class ToolCheck:
    """All six axes of one part in one cartesian mode."""

    def __init__(self, stage: Stage, part: str, mode: ControlMode) -> None:
        self._stage, self._part, self._mode = stage, part, mode
        self._of = f"{part} {mode.yaml_name}"
        lag = max(
            stage.profile.measured[name].stop_lag_s or 0.0 for name in stage.robot.part(part).joints
        )
        self._rest = 3 + math.ceil(lag / stage.period_s)
        frame = stage.limits(part, mode).frames[0]
        tree = description_tree(stage.robot)
        self._frame = ToolChain(tree, frame) if frame != tree.root else None
        self.frame = frame

    def rows(self) -> Iterator[Row]:
        """Drive, and say what came."""
        problems, shares, off = list[str](), list[float](), list[float]()
        for axis in self._doable():
            run = self._stage.execute(partial(self._rows, axis), self._rest)
            if not run.acted_all:
                problems.append(f"rows did not act: {run.story}")
                break
            told, moved = self._way(axis, run)
            size, along = float(np.linalg.norm(moved)), float(moved @ told) / float(told @ told)
            shares.append(along)
            angle = math.acos(
                np.clip(along * float(np.linalg.norm(told)) / max(size, 1e-12), -1, 1)
            )
            off.append(angle)
            if size < LEAST * float(np.linalg.norm(told)):
                problems.append(
                    f"{AXES[axis]}: did not move ({size:.2g} of {np.linalg.norm(told):.2g})"
                )
            elif angle > OFF_RAD:
                ways = np.array2string(moved / size, precision=2, suppress_small=True)
                problems.append(f"{AXES[axis]}: {angle:.2f} rad off, along {ways}")
            self._stage.settle()
        frame = replace(TOOL, of=f"{self._of} in {self.frame}")
        if not problems and not off:
            why = "here its joints can do no axis alone"
            yield from (frame.not_checked(why), replace(TOOL_GAIN, of=self._of).not_checked(why))
            return
        yield frame.row(problems, f"{len(off)} axes, at most {max(off, default=0.0):.2f} rad off")
        yield self._gain(problems, shares)

    def _doable(self) -> list[int]:
        """Axes that the part's joints can do alone: all of an arm of six or more."""
        stage = self._stage
        at = stage.named(stage.states.newest.positions)
        names = stage.robot.part(self._part).joints
        jacobian = stage.chains[self._part].jacobian(at, names)
        turn = np.eye(3) if self._frame is None else self._frame.pose(at)[1]
        axes = np.kron(np.eye(2), turn)
        left = axes - jacobian @ np.linalg.pinv(jacobian, rcond=SMALLEST) @ axes
        return [axis for axis in range(6) if np.linalg.norm(left[:, axis]) < LEFT]

    def _gain(self, problems: list[str], shares: list[float]) -> Row:
        gain = getattr(self._stage.limits(self._part, self._mode), "gain", (1.0, 1.0))
        low, high = gain[0] * (1.0 - GAIN_SLACK), gain[1] * (1.0 + GAIN_SLACK)
        expected = f"{gain[0]:g} to {gain[1]:g} of what is told, +- {100 * GAIN_SLACK:g} %"
        check = replace(TOOL_GAIN, of=self._of, expected=expected)
        if problems:
            return check.not_checked("the tool went another way")
        got = f"{min(shares):.2f} to {max(shares):.2f}"
        return check.row([] if low <= min(shares) and max(shares) <= high else [got], got)

    def _rows(self, axis: int, now: Moment) -> Rows:
        maker = self._stage.rows(self._part, self._mode, now)
        found = []
        share = self._stage.share
        for wish, count in ((share, OUT_ROWS), (0.0, self._rest), (-share, OUT_ROWS), (0.0, 2)):
            vector = np.zeros(6)
            vector[axis] = wish
            found += [{self._part: maker.row(vector, now)} for _ in range(count)]
        return found

    def _way(self, axis: int, run: Run) -> tuple[FloatArray, FloatArray]:
        """What the rows out ask for, and what the tool did until it was told to go back.

        Along the root's axes, in the row's unit, of the half that was told.
        """
        stage, first = self._stage, run.sent.first
        half = HALVES[axis // 3]
        start, end = stage.moment(first), stage.moment(first + OUT_ROWS + self._rest)
        place, turn = start.tools[self._part]
        to_place, to_turn = end.tools[self._part]
        moved = np.concatenate([to_place - place, rotation_vector(to_turn @ turn.T)])[half]
        rows = np.array([row[self._part].values for row in run.rows[: OUT_ROWS + self._rest]])
        if self._mode is ControlMode.CARTESIAN_POSE:
            full = 0.577 * stage.share * OUT_ROWS
            limits = stage.limits(self._part, self._mode)
            name = "angular_step_limit_rad" if axis > 2 else "linear_step_limit_m"
            told = np.zeros(3)
            told[axis % 3] = full * getattr(limits, name)
        else:
            told = rows.sum(axis=0)[half]
            if self._mode is ControlMode.CARTESIAN_TWIST:
                told = told * stage.period_s
        if self._frame is not None:
            told = self._frame.pose(stage.named(start.positions))[1] @ told
        return told, moved


def tool_checks(stage: Stage) -> Iterator[Row]:
    """Every part in every cartesian mode whose tool it carries."""
    none = True
    for part, modes in stage.modes.items():
        for mode in modes:
            if not mode.is_tool_mode:
                continue
            none = False
            if part in stage.chains:
                yield from ToolCheck(stage, part, mode).rows()
            else:
                yield replace(TOOL, of=f"{part} {mode.yaml_name}").not_checked(
                    "its tool is another part's, too"
                )
    if none:
        yield TOOL.not_checked("no part has a cartesian mode")
        yield TOOL_GAIN.not_checked("no part has a cartesian mode")


def limit_checks(stage: Stage, is_simulator: bool) -> Iterator[Row]:
    """Full-size rows in four directions each, of simulators only."""
    none = True
    for part, modes in stage.modes.items():
        for mode in modes:
            if mode.is_tool_mode and part in stage.chains:
                none = False
                check = replace(LIMITS, of=f"{part} {mode.yaml_name}")
                if is_simulator:
                    yield _full_size(stage, part, mode, check)
                else:
                    yield check.not_checked("full-size rows are for simulators")
    if none:
        yield LIMITS.not_checked("no part has a cartesian mode")


def _full_size(stage: Stage, part: str, mode: ControlMode, check: Check) -> Row:
    rng = np.random.default_rng(SEED)
    joints, problems, shares = stage.joints_of(part), dict[str, str](), [0.0]
    speeds = np.array([profile_limits(stage.robot.joints[i], stage.profile)[0] for i in joints])
    for _ in range(FULL_WISHES):
        wish = wish_of(rng, 6)

        def make(now: Moment, wish: FloatArray = wish) -> Rows:
            maker = stage.rows(part, mode, now)
            return [{part: maker.row(wish, now)} for _ in range(FULL_ROWS)]

        run = stage.execute(make)
        if not run.acted_all:
            return check.row([f"rows did not act: {run.story}"], "")
        stage.settle()
        for state in stage.states.between(run.sent.first, stage.states.newest_tick):
            share = np.abs(state.velocities[joints]) / speeds
            shares.append(float(share.max()))
            for at in np.flatnonzero(share > SPEED_SLACK):
                name = stage.robot.joint_names[joints[at]]
                problems[name] = f"{name}: {share[at] * speeds[at]:.3g}/s, limit {speeds[at]:g}"
            problems |= _outside(stage, joints, state.positions)
    return check.row(list(problems.values()), f"at most {100 * max(shares):.0f} % of its speed")


def _outside(stage: Stage, joints: list[int], positions: FloatArray) -> dict[str, str]:
    told = [stage.robot.joints[index] for index in joints]
    found = {
        one.name: outside_limits(one, stage.profile, float(at))
        for one, at in zip(told, positions[joints], strict=True)
    }
    return {f"{name} place": text for name, text in found.items() if text}
