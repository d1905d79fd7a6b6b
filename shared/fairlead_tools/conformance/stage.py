"""One HAL that is checked: its robot, small rows for it, and what came of them."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from fairlead.deploy.deployment import Deployment
from fairlead.messages import FloatArray, Hold
from fairlead.modes import ControlMode
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.conformance.control import Control
from fairlead_tools.conformance.heard_states import Heard
from fairlead_tools.conformance.plan import Released, Rows
from fairlead_tools.conformance.small_rows import SmallRows
from fairlead_tools.conformance.stand_in_gate import StandInGate
from fairlead_tools.measure.driven_robot import Moment, tool_chains

TRIES = 3
MOST_TRIES = 12
LATE_S = 0.015
"""A machine that wakes a sleeper later loses leases: such a try does not count."""
WAIT_S = 0.25
"""In lockstep a world that did not step for so long waits for a decision."""
STILL_TICKS = 3


@dataclass(frozen=True)
class Run:
    """Rows that were sent, and whether all of them acted. parts: indices that they command."""

    sent: Released
    parts: tuple[int, ...]
    rows: Rows
    acted_all: bool
    story: str


class Stage(SmallRows):
    """Drives the parts of one HAL with rows of its own, without any gate that would judge them.

    The arguments are those of `SmallRows`.
    """

    def __init__(
        self,
        gate: StandInGate,
        robot: RobotManifest,
        deployment: Deployment,
        share: float,
        modes: Mapping[str, Sequence[ControlMode]],
    ) -> None:
        super().__init__(robot, deployment.profile, share, modes)
        self.gate, self.hal, self.states = gate, gate.hal, gate.states
        self.lockstep = gate.hal.pacing == "lockstep"
        self.chains = tool_chains(robot)
        names = robot.measured_joint_names
        measured = [self.profile.measured[name] for name in names]
        self.standstill = np.array([one.standstill_per_s for one in measured])
        self.encoder = np.array([one.encoder_step or 0.0 for one in measured])
        self.stop_ticks = math.ceil(self.profile.protocol.stop_ramp_ms * 1e-3 / self.period_s)
        self.control = Control()

    # --- the robot ---------------------------------------------------------------------

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
        """What was measured when a tick began, or last before it, and where tools are by that."""
        found = self.states.last_until(tick)
        at = self.named(found.positions)
        tools = {part: chain.pose(at) for part, chain in self.chains.items()}
        base = self.states.bases.get(found.tick, np.zeros(3))
        return Moment(found.positions, found.velocities, found.efforts, tools, base)

    # --- what comes of them --------------------------------------------------------------

    def execute(self, make: Callable[[Moment], Rows], tail: int = 2) -> Run:
        """Send rows under a claim of their own and wait for ``tail`` ticks after them.

        A lost lease or chunk is no fault: it is tried three times, not counting those in which
        this machine was late itself.
        """
        counted = 0
        for _ in range(MOST_TRIES):
            began_ns = time.monotonic_ns()
            self.take_claim()
            rows = make(self.moment(self.states.newest_tick))
            sent = self.gate.release(rows)
            self.gate.wait_tick(sent.end + tail)
            run = self.judged(sent, rows)
            counted += self.control.since(began_ns).most_s < LATE_S
            if run.acted_all or counted == TRIES:
                break
            self.settle()
        return run

    def take_claim(self) -> None:
        """A new claim for rows that come next; a world in lockstep stands still by then."""
        if not self.lockstep:
            self.gate.take_claim()
            self.gate.wait_tick(self.states.newest_tick + 1)
            return
        self.gate.drop_claims()
        while self.reaches(self.states.newest_tick + 1):
            pass
        self.gate.take_claim(waits=True)

    def begin(self, count: int, moving: int) -> Released | str:
        """Rows that go on acting, ``moving`` of them already; or why they do not act."""
        for _ in range(MOST_TRIES):
            self.settle()
            self.take_claim()
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
