"""One HAL that is checked: its robot, small rows for it, and what came of them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fairlead.deploy.deployment import Deployment
from fairlead.messages import FloatArray, Hold
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.profile_limits import profile_limits
from fairlead_tools.conformance.control import Control
from fairlead_tools.conformance.heard_states import Heard
from fairlead_tools.conformance.stand_in_gate import Released, Rows, StandInGate
from fairlead_tools.measure.driven_robot import Moment, tool_chains
from fairlead_tools.measure.rows import TARGETS, FullScaleRows

TRIES = 3
MOST_TRIES = 12
LATE_S = 0.015
"""A machine that wakes a sleeper later loses leases: such a try does not count."""
WAIT_S = 0.25
"""In lockstep a world that did not step for so long waits for a decision."""
STILL_TICKS = 3
OUT_ROWS = 5
"""Rows of each way of an axis."""
CLEAR = 2.0
"""A row's step, in dead bands, where those are larger than the share of full scale."""
CARTESIAN = (
    ControlMode.CARTESIAN_DELTA,
    ControlMode.CARTESIAN_TWIST,
    ControlMode.CARTESIAN_POSE,
)
GRIPPERS = (ControlMode.GRIPPER_POSITION, ControlMode.GRIPPER_BINARY)


@dataclass(frozen=True)
class Run:
    """Rows that were sent, and whether all of them acted. parts: indices that they command."""

    sent: Released
    parts: tuple[int, ...]
    rows: Rows
    acted_all: bool
    story: str


class Stage:
    """Drives the parts of one HAL with rows of its own, without any gate that would judge them.

    Args:
        share: of full scale, for what is no full-size row.
        modes: by part, those that both the robot's file and the HAL have.
    """

    def __init__(
        self,
        gate: StandInGate,
        robot: RobotManifest,
        deployment: Deployment,
        share: float,
        modes: Mapping[str, Sequence[ControlMode]],
    ) -> None:
        self.gate, self.robot, self.profile_name = gate, robot, deployment.profile
        self.hal, self.states, self.share, self.modes = gate.hal, gate.states, share, modes
        self.profile = robot.profile(deployment.profile)
        self.period_s = robot.tick_period_ns * 1e-9
        self.lockstep = gate.hal.pacing == "lockstep"
        self.chains = tool_chains(robot)
        names = robot.measured_joint_names
        measured = [self.profile.measured[name] for name in names]
        self.standstill = np.array([one.standstill_per_s for one in measured])
        self.dead = np.array([one.dead_band_per_tick or 0.0 for one in measured])
        self.encoder = np.array([one.encoder_step or 0.0 for one in measured])
        self.stop_ticks = math.ceil(self.profile.protocol.stop_ramp_ms * 1e-3 / self.period_s)
        self._way = 1.0
        self.control = Control()

    # --- the robot ---------------------------------------------------------------------

    def joints_of(self, part: str) -> list[int]:
        """Wire indices of a part's joints."""
        return [self.robot.joint_names.index(name) for name in self.robot.part(part).joints]

    def limits(self, part: str, mode: ControlMode) -> Any:
        """What the profile declares of a mode."""
        return getattr(self.profile.parts[part], mode.yaml_name)

    @property
    def watched(self) -> list[int]:
        """Measured joints that a hold keeps still: a gripper may go on to its target."""
        going = {
            name for part in self.robot.parts if part.hold == "keep_command" for name in part.joints
        }
        driven = {one for name in going for one in self.robot.simulator_joints(name)}
        names = self.robot.measured_joint_names
        fingers = {
            name
            for name in names
            if name in going or driven & set(self.robot.simulator_joints(name))
        }
        return [index for index, name in enumerate(names) if name not in fingers]

    def named(self, positions: FloatArray) -> dict[str, float]:
        """Positions of all measured joints by name."""
        return dict(zip(self.robot.measured_joint_names, positions.tolist(), strict=True))

    def moment(self, tick: int) -> Moment:
        """What was measured at the start of a tick, with the tools by the description."""
        found = self.states.by_tick[tick]
        at = self.named(found.positions)
        tools = {part: chain.pose(at) for part, chain in self.chains.items()}
        base = self.states.bases.get(tick, np.zeros(3))
        return Moment(found.positions, found.velocities, found.efforts, tools, base)

    # --- rows --------------------------------------------------------------------------

    def rows(self, part: str, mode: ControlMode, now: Moment) -> FullScaleRows:
        """Rows from rest; targets from where the joints are."""
        rows = FullScaleRows(self.robot, part, mode, turns_back=False, profile=self.profile_name)
        rows.go_on_after(now.positions[: self.robot.n_dof] if mode in TARGETS else None)
        return rows

    def pace(self, part: str, mode: ControlMode, axis: int) -> float:
        """The share of full scale that an axis gets: more than its joints do not notice."""
        if not mode.is_joint_mode:
            return self.share
        index = self.joints_of(part)[axis]
        full = self.full_step(part, mode, axis)
        most, wanted = 1.0, self.share
        if mode in TARGETS:
            most = min(1.0, self._speed(index) * self.period_s / full)
            wanted = max(wanted, CLEAR * 2 * self.dead[index] / (OUT_ROWS * full))
        else:
            wanted = max(wanted, CLEAR * self.dead[index] / full)
        return float(min(most, wanted))

    def full_step(self, part: str, mode: ControlMode, axis: int) -> float:
        """What a joint is told most in one period [rad or m]."""
        if mode in TARGETS:
            return float(self.limits(part, mode).step_limits[axis])
        return self._speed(self.joints_of(part)[axis]) * self.period_s

    def _speed(self, index: int) -> float:
        return profile_limits(self.robot.joints[index], self.profile)[0]

    def mid_way(self, index: int, position: float) -> float:
        """The way to the middle of a joint's range; forth and back where there is none."""
        joint = self.robot.joints[index]
        if not joint.has_bounds:
            return 1.0
        return 1.0 if position < 0.5 * (joint.lower + joint.upper) else -1.0

    def first_modes(self) -> dict[str, ControlMode]:
        """For each part whose hold stands still, the first mode that moves it."""
        found: dict[str, ControlMode] = {}
        for part in self.robot.parts:
            moving = [m for m in self.modes[part.name] if m is not ControlMode.COMPOSITE_MODE]
            if part.joints and part.hold != "keep_command" and moving:
                gentle = [m for m in moving if m not in GRIPPERS]
                found[part.name] = (gentle or moving)[0]
        return found

    def moving_rows(self, count: int) -> Callable[[Moment], Rows]:
        """Every part that a hold stops on its way, each call the other way."""
        self._way = -self._way
        way = self._way

        def make(now: Moment) -> Rows:
            makers, wishes = {}, {}
            for part, mode in self.first_modes().items():
                makers[part] = self.rows(part, mode, now)
                wishes[part] = self._wish(part, mode, now, makers[part].axes, way)
            return [
                {part: one.row(wishes[part], now) for part, one in makers.items()}
                for _ in range(count)
            ]

        return make

    def _wish(self, part: str, mode: ControlMode, now: Moment, axes: int, way: float) -> FloatArray:
        wish = np.zeros(axes)
        if mode.is_joint_mode:
            for axis, index in enumerate(self.joints_of(part)):
                inwards = self.mid_way(index, float(now.positions[index]))
                bounded = mode in TARGETS and self.robot.joints[index].has_bounds
                wish[axis] = self.pace(part, mode, axis) * (inwards if bounded else way)
        elif mode is ControlMode.BODY_TWIST:
            wish[0] = self.share * way
        else:
            wish[2] = self.share * way
        return wish

    # --- what comes of them --------------------------------------------------------------

    def execute(self, make: Callable[[Moment], Rows], tail: int = 2) -> Run:
        """Send rows under a claim of their own and wait for ``tail`` ticks after them.

        A lost lease or chunk is no fault: it is tried three times, not counting those in which
        this machine was late itself.
        """
        counted = 0
        for _ in range(MOST_TRIES):
            began_ns = time.monotonic_ns()
            self.gate.take_claim()
            self.gate.wait_tick(self.states.newest_tick + 1)
            rows = make(self.moment(self.states.newest_tick))
            sent = self.gate.release(rows)
            self.gate.wait_tick(sent.end + tail)
            run = self.judged(sent, rows)
            counted += self.control.since(began_ns).most_s < LATE_S
            if run.acted_all or counted == TRIES:
                break
            self.settle()
        return run

    def begin(self, count: int, moving: int) -> Released | str:
        """Rows that go on acting, ``moving`` of them already; or why they do not act."""
        for _ in range(MOST_TRIES):
            self.settle()
            self.gate.take_claim()
            self.gate.wait_tick(self.states.newest_tick + 1)
            rows = self.moving_rows(count)(self.moment(self.states.newest_tick))
            sent = self.gate.release(rows)
            self.gate.wait_tick(sent.first + moving)
            acted = self.states.acted(self.states.newest_tick - 1) or ()
            if any(one.hold == 0 for one in acted):
                return sent
        return f"rows never act: {', '.join(sorted({hold_name(one.hold) for one in acted}))}"

    def judged(self, sent: Released, rows: Rows) -> Run:
        """Whether what was sent acted, by the HAL's own word."""
        parts = tuple(self.robot.part_names.index(name) for name in rows[0])
        for row in range(sent.horizon):
            acted = self.states.acted(sent.first + row)
            if acted is None:
                return Run(sent, parts, rows, False, f"tick {sent.first + row + 1} did not come")
            for part in parts:
                told = acted[part]
                if (told.hold, told.verdict_id, told.row) != (0, sent.verdict, row):
                    what = hold_name(told.hold) if told.hold else f"row {told.row} of another"
                    where = self.robot.part_names[part]
                    story = f"row {row} of {sent.horizon}: {where} says {what}"
                    return Run(sent, parts, rows, False, story)
        return Run(sent, parts, rows, True, "")

    def first_still(self, first: int, most: int) -> int | None:
        """The first of three ticks from ``first`` on in which all watched joints stand still."""
        still = 0
        for tick in range(first, first + most + STILL_TICKS):
            if not self.reaches(tick):
                newest = self.states.newest_tick
                return newest if self.is_still(newest) else None
            still = still + 1 if self.is_still(tick) else 0
            if still == STILL_TICKS:
                return tick - STILL_TICKS + 1
        return None

    def is_still(self, tick: int) -> bool:
        """Whether all watched joints are below their standstill speed, by both measures."""
        now, before = self.states.by_tick.get(tick), self.states.by_tick.get(tick - 1)
        if now is None:
            return False
        speeds = np.abs(now.velocities)
        if before is not None:
            moved = np.abs(now.positions - before.positions) / self.period_s
            speeds = np.maximum(speeds, moved)
        return bool(np.all((speeds < self.standstill)[self.watched]))

    def reaches(self, tick: int) -> bool:
        """Wait for a tick; a world in lockstep may well stand still instead."""
        if not self.lockstep:
            self.gate.wait_tick(tick)
            return True
        self.gate.refuse_intruder()
        return self.states.wait_for(lambda: self.states.newest_tick >= tick, WAIT_S)

    def settle(self) -> None:
        """Until the robot stands still, or for as long as a stop may take."""
        self.first_still(self.states.newest_tick + 1, self.stop_ticks)

    def drift_bound(self) -> FloatArray:
        """How far a held joint may be from where it stood: what counts as no motion."""
        slow = self.standstill * self.period_s
        return np.asarray(np.where(self.dead > 0, np.maximum(self.dead, 2 * self.encoder), slow))

    def strayed(self, start: Heard, states: Sequence[Heard]) -> list[str]:
        """Watched joints that did not keep their place."""
        if not states:
            return []
        away = np.max([np.abs(one.positions - start.positions) for one in states], axis=0)
        bound, names = self.drift_bound(), self.robot.measured_joint_names
        return [
            f"{names[i]} moved by {away[i]:.3g} {self.robot.joint(names[i]).unit} "
            f"(at most {bound[i]:.3g})"
            for i in self.watched
            if away[i] > bound[i]
        ]


def hold_name(hold: int) -> str:
    """As people read it: ``held: no_row``."""
    known = hold in set(Hold)
    return f"held: {Hold(hold).name.lower()}" if known else f"hold {hold}, which is none"
