"""Each joint of each joint mode alone, a little to and fro: which moved, which way, how far."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_tools.conformance.heard_states import Heard
from fairlead_tools.conformance.plan import Rows
from fairlead_tools.conformance.row import Check, Row
from fairlead_tools.conformance.small_rows import OUT_ROWS
from fairlead_tools.conformance.stage import Run, Stage
from fairlead_tools.measure.driven_robot import Moment
from fairlead_tools.measure.rows import TARGETS

JOINT_MODES = (*TARGETS, ControlMode.JOINT_VELOCITY)
MOST_ROWS = 64
OTHERS = 0.5
"""Another joint that moves by more than this share of the commanded one was moved, too."""
LEAST = 0.2
"""Of what was told: a joint that made less did not move."""
GAIN_SLACK = 0.35
BEGUN = 0.1
"""Of a row's step: a joint that made more has begun to move."""
VELOCITY_FACTOR = 2.0
MAP = "map joints by name in apply() and read()"
ORDER = Check(
    "joint order", "the joint that is told moves, the others by less than half of that",
    "robot.yaml: parts; half: own choice", f"{MAP}, and command SI units",
)  # fmt: skip
SIGN = Check(
    "joint sign", "told to grow, a joint grows", "robot.yaml, URDF axes",
    "turn the sign in apply() and in read()",
)  # fmt: skip
GAIN = Check(
    "joint gain", "its declared share of what is told",
    "robot.yaml: gain, tracking_limits; slack: own choice",
    "command SI units; correct gain and tracking_limits by: fairlead robot measure",
)  # fmt: skip
LAG = Check(
    "command round trip", "a row moves its joint within its declared lag",
    "robot.yaml: stop_lag_s, dead_band_per_tick",
    "apply() the row in its own tick; correct stop_lag_s",
)  # fmt: skip
VELOCITY = Check(
    "SI velocities", f"as positions change, within {VELOCITY_FACTOR:g} times",
    "shared/fairlead/hal/backend.py: Measurement; factor: own choice",
    "read() returns velocities in rad/s and m/s",
)  # fmt: skip


@dataclass(frozen=True)
class Stroke:
    """One joint's way out, and half of that back. told: how far it was sent.

    moved: by every commanded joint, shape ``[n_dof]``. travelled: as `travelled` says. lag: ticks
    until it moved; None: it never did.
    """

    joint: int
    told: float
    moved: FloatArray
    travelled: float
    lag: int | None


def travelled(states: Sequence[Heard], index: int, period_s: float) -> float:
    """What a joint's velocities add up to [rad or m] on the way from the first state to the last.

    A late tick is one period long in a simulator and as long as the clock says on hardware: of the
    two sums this is the one that is nearer to how far its position went.
    """
    velocities = np.array([one.velocities[index] for one in states[1:]])
    went = states[-1].positions[index] - states[0].positions[index]
    measured_s = 1e-9 * np.diff([one.stamp_ns for one in states])
    sums = float(period_s * velocities.sum()), float(measured_s @ velocities)
    return min(sums, key=lambda one: abs(one - float(went)))


class JointCheck:
    """All joints of one part in one joint mode."""

    def __init__(self, stage: Stage, part: str, mode: ControlMode) -> None:
        self._stage, self._part, self._mode = stage, part, mode
        self._of = f"{part} {mode.yaml_name}"
        self._joints = stage.joints_of(part)
        declared = max(
            stage.profile.measured[stage.robot.joint_names[one]].stop_lag_s or 0.0
            for one in self._joints
        )
        lag = math.ceil(declared / stage.period_s)
        self._rest = 4 + lag
        unfelt = max(
            stage.dead[index] / (stage.pace(part, mode, axis) * stage.full_step(part, mode, axis))
            for axis, index in enumerate(self._joints)
        )
        self._lag = 2 + lag + math.ceil(unfelt)
        self.strokes: list[Stroke] = []
        self.lost = ""

    def drive(self) -> None:
        """To and fro, as many joints in a chunk as fit."""
        each = 2 * (OUT_ROWS + self._rest)
        fit = max(1, MOST_ROWS // each)
        for at in range(0, len(self._joints), fit):
            axes = list(range(len(self._joints)))[at : at + fit]
            run = self._stage.execute(partial(self._rows, axes), self._rest)
            if not run.acted_all:
                self.lost = run.story
                return
            for place, axis in enumerate(axes):
                self.strokes.append(self._stroke(axis, run, place * each))
            self._stage.settle()

    def _way(self, axis: int, now: Moment) -> float:
        index = self._joints[axis]
        return self._stage.mid_way(index, float(now.positions[index]))

    def _rows(self, axes: Sequence[int], now: Moment) -> Rows:
        maker = self._stage.rows(self._part, self._mode, now)
        found = []
        for axis in axes:
            pace = self._stage.pace(self._part, self._mode, axis) * self._way(axis, now)
            for wish, count in (
                (pace, OUT_ROWS), (0.0, self._rest), (-pace, OUT_ROWS), (0.0, self._rest)
            ):  # fmt: skip
                vector = np.zeros(maker.axes)
                vector[axis] = wish
                found += [{self._part: maker.row(vector, now)} for _ in range(count)]
        return found

    def _stroke(self, axis: int, run: Run, at: int) -> Stroke:
        """Of one axis, whose rows begin at row ``at``."""
        stage, index, first = self._stage, self._joints[axis], run.sent.first + at
        start, count = stage.states.by_tick[first], OUT_ROWS + self._rest
        heard = stage.states.between(first + 1, first + count + 1)
        rows = [row[self._part].values[index] for row in run.rows[at : at + count]]
        told = rows[-1] - start.positions[index] if self._mode in TARGETS else sum(rows)
        told = float(told * (1.0 if self._mode in TARGETS else stage.period_s))
        ways = np.array([one.positions - start.positions for one in heard])
        begun = max(BEGUN * abs(told) / OUT_ROWS, 1.5 * float(stage.encoder[index]))
        away = np.abs(ways[:, index]) > begun
        return Stroke(
            joint=index,
            told=told,
            moved=ways[-1, : stage.robot.n_dof],
            travelled=travelled([start, *heard], index, stage.period_s),
            lag=int(np.argmax(away)) if away.any() else None,
        )

    def rows(self) -> Iterator[Row]:
        """A joint that is not the one told counts in no further row."""
        if self.lost:
            for check in (ORDER, SIGN, GAIN, LAG, VELOCITY):
                yield replace(check, of=self._of).row([f"rows did not act: {self.lost}"], "")
            return
        lost = {one.joint: text for one in self.strokes if (text := self._order(one))}
        yield self._row(ORDER, list(lost.values()), f"{len(self.strokes)} joints")
        right = [one for one in self.strokes if one.joint not in lost]
        turned = {
            one.joint: f"{self._name(one.joint)}: told {one.told:+.3g}, "
            f"moved {one.moved[one.joint]:+.3g}"
            for one in right
            if one.told * one.moved[one.joint] < 0.0
        }
        right_way = [one for one in right if one.joint not in turned]
        yield self._row(SIGN, list(turned.values()), f"{len(right)} joints", right)
        yield self._gain(right_way)
        yield self._lags(right_way)
        yield self._speeds(right)

    def _row(self, check: Check, problems: list[str], got: str, of: object = True) -> Row:
        check = replace(check, of=self._of)
        return (
            check.row(problems, got) if of else check.not_checked("no joint moved as it was told")
        )

    def _name(self, joint: int) -> str:
        return self._stage.robot.joint_names[joint]

    def _order(self, one: Stroke) -> str:
        size, name = abs(float(one.moved[one.joint])), self._name(one.joint)
        others = np.abs(one.moved)
        others[one.joint] = 0.0
        others[others <= 2.0 * self._stage.encoder[: len(others)]] = 0.0
        most = int(np.argmax(others))
        if size < LEAST * self._least_gain() * abs(one.told):
            moved = f"{name}: told {one.told:+.3g}, moved {one.moved[one.joint]:+.3g}"
            is_other = others[most] > size
            other = f"{self._name(most)} moved {one.moved[most]:+.3g}" if is_other else "no other"
            return f"{moved}; {other}"
        if others[most] > OTHERS * size:
            moved = f"{self._name(most)} {one.moved[most]:+.3g}"
            return f"{name}: moved {one.moved[one.joint]:+.3g}, and {moved} with it"
        return ""

    def _least_gain(self) -> float:
        return max(0.25, self._gains()[0])

    def _gains(self) -> tuple[float, float]:
        limits = self._stage.limits(self._part, self._mode)
        gain: tuple[float, float] = getattr(limits, "gain", (1.0, 1.0))
        return gain

    def _gain(self, right: list[Stroke]) -> Row:
        least, most = self._gains()
        low, high = least - GAIN_SLACK, most + GAIN_SLACK
        tracking = self._stage.limits(self._part, self._mode).tracking_limits
        problems, shares = list[str](), list[float]()
        for one in right:
            share = float(one.moved[one.joint]) / one.told
            shares.append(share)
            error = abs(one.told - float(one.moved[one.joint]))
            limit = tracking[self._joints.index(one.joint)]
            slack = 2.0 * max(self._stage.dead[one.joint], self._stage.encoder[one.joint])
            name = self._name(one.joint)
            if not low - slack / abs(one.told) <= share <= high + slack / abs(one.told):
                problems.append(f"{name}: {share:.3g} of what it was told")
            elif self._mode in TARGETS and error > limit:
                problems.append(f"{name}: {error:.3g} from its target (tracking_limits: {limit:g})")
        check = replace(GAIN, expected=f"{least:g} to {most:g} of what is told, +- {GAIN_SLACK:g}")
        got = f"{min(shares):.2f} to {max(shares):.2f}" if shares else ""
        return self._row(check, problems, got, right)

    def _lags(self, right: list[Stroke]) -> Row:
        check = replace(LAG, expected=f"a row moves its joint within {self._lag} ticks")
        late = [
            f"{self._name(one.joint)}: {'never' if one.lag is None else f'{one.lag + 1} ticks'}"
            for one in right
            if one.lag is None or one.lag + 1 > self._lag
        ]
        most = max((one.lag or 0 for one in right), default=0)
        return self._row(check, late, f"{most + 1} tick(s) at most", right)

    def _speeds(self, right: list[Stroke]) -> Row:
        problems, shares = list[str](), list[float]()
        for one in right:
            share = one.travelled / float(one.moved[one.joint])
            shares.append(share)
            if not 1.0 / VELOCITY_FACTOR <= share <= VELOCITY_FACTOR:
                problems.append(f"{self._name(one.joint)}: {share:.3g} of what its position says")
        got = f"{min(shares):.2f} to {max(shares):.2f}" if shares else ""
        return self._row(VELOCITY, problems, got, right)


def joint_checks(stage: Stage) -> Iterator[Row]:
    """Every part in every joint mode that both the HAL and its robot have."""
    none = True
    for part, modes in stage.modes.items():
        for mode in modes:
            if mode in JOINT_MODES:
                none = False
                one = JointCheck(stage, part, mode)
                one.drive()
                yield from one.rows()
    if none:
        for check in (ORDER, SIGN, GAIN, LAG, VELOCITY):
            yield check.not_checked("no part has a joint mode")
