"""The real gate core, the real HAL core and a simulator in one process, in either pacing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Generic, Protocol, TypeVar

import numpy as np

from bench.equipment.case import Case, Chunk, Measured, Pacing
from bench.equipment.core_gate import SESSION, SOURCE, CoreGate
from bench.equipment.gate_port import GateOutput
from bench.soundness.chunk_rows import Row, chunk_of
from fairlead.errors import ConfigError
from fairlead.hal.backend import PartCommand
from fairlead.hal.core import HalCore, TickPlan
from fairlead.messages import Decision, Hold, Lease, SafeChunk, Verdict, decode
from fairlead.paths import gate_config
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.measure.driven_robot import Moment, Tick


class Stepped(Protocol):
    """A robot that goes on by a period when it is told to: a `DrivenRobot`, or a model of one."""

    @property
    def robot(self) -> RobotManifest:
        """Which."""

    def reset(self, seed: int) -> Moment:
        """A new episode."""

    def step(self, kind: str, before: Moment, commands: Mapping[str, PartCommand]) -> Tick:
        """One period with these commands."""


R = TypeVar("R", bound=Stepped)


class GateLoop(Generic[R]):
    """One robot whose every tick the gate decides.

    In realtime a tick begins before the gate has said anything of its state: the word for it is
    that of the tick before, or of an earlier one where states are lost.

    Args:
        config: the gate's file; None: the robot's own.

    Attributes:
        now: what is measured at the start of the present tick.
        tick: its number; the first is 1.
        file: the gate's.
        undecided: claims, by source, which this tick waits for.
    """

    def __init__(self, driven: R, config: Path | None = None) -> None:
        self.driven = driven
        self._gate = CoreGate(config or gate_config(driven.robot.id, "sim"))
        self.file = self._gate.file
        self.undecided: tuple[str, ...] = ()
        self.begin(0)

    def close(self) -> None:
        """End the gate's process."""
        self._gate.close()

    def begin(
        self,
        seed: int,
        claims: Mapping[str, tuple[str, ...]] | None = None,
        pacing: Pacing = "lockstep",
    ) -> None:
        """A new episode, a new gate, armed.

        claims: parts by source; by default one has everything.
        """
        self._pacing: Pacing = pacing
        self._on_the_way: list[GateOutput] = []
        robot, self.tick, self.hal_refused = self.driven.robot, 1, False
        self._cut: list[Verdict] = []
        self._heard = 1
        self.now: Moment = self.driven.reset(seed)
        # A gripper that still settles, for example: the gate arms at standstill.
        still = _measured(self.now, 1)
        still.velocities[:] = 0.0
        self._hal = HalCore(SESSION, pacing, len(robot.parts), robot.n_dof, robot.tick_period_ns)
        self._gate.start(pacing, still)
        for source, parts in (claims or {SOURCE: robot.part_names}).items():
            self._gate.claim(Case(robot.id, pacing, still, Chunk(1, 1, ())), source, parts)
        self.undecided = tuple(claims or (SOURCE,))

    def propose(self, rows: Sequence[Row], source: str = SOURCE) -> Verdict:
        """Ask for these rows, from the present tick on; in realtime that has begun.

        They are told to be of the newest state that the gate has heard.
        """
        first = self.tick + (self._pacing == "realtime")
        chunk = chunk_of(self.driven.robot, first, rows)
        answer = self._gate.send(chunk, self._heard, source)
        self._take(answer.outputs)
        return answer.verdict

    def advance(self, kind: str, *, is_heard: bool = True) -> Tick | None:
        """Carry the tick out as decided; None while its decision is missing.

        is_heard: whether the gate gets the state after it, which only in realtime it may not.
        """
        if self.hal_refused:
            return None
        plan = self._hal.decide(self.tick, self._gate.now_ns, is_still=True)
        if not isinstance(plan, TickPlan):
            return None
        names = self.driven.robot.part_names
        commands = {names[part]: command for part, command in plan.commands.items()}
        try:
            done = self.driven.step(kind, self.now, commands)
        except ConfigError:
            # What the host does: the tick holds, and only an operator's reset goes on.
            self.hal_refused = True
            self._hal.void(Hold.STOPPED)
            done = self.driven.step(kind, self.now, {})
        self._next(done, is_heard)
        return done

    def take_cut(self) -> list[Verdict]:
        """Why released rows were cut off before they acted, since this was asked last."""
        found, self._cut = self._cut, []
        return found

    def hold(self, kind: str) -> Tick:
        """What the HAL does after a stop, until the robot stands still: one more held tick."""
        done = self.driven.step(kind, self.now, {})
        self._hal.void(Hold.STOPPED)
        self._next(done)
        return done

    def _next(self, done: Tick, is_heard: bool = True) -> None:
        self.tick, self.now = self.tick + 1, done.after
        arrived, self._on_the_way = self._on_the_way, []
        self._take(arrived)
        if is_heard:
            self._heard = self.tick
            reply = self._gate.state_reply(_measured(self.now, self.tick), self._hal.acted)
        else:
            reply = self._gate.pass_time()
        if self._pacing == "realtime":
            self._on_the_way = reply.outputs
        else:
            self._take(reply.outputs)
        for output in reply.outputs:
            if output.kind == "verdict":
                self._cut.append(decode(Verdict, output.payload))

    @property
    def stop_cause(self) -> str:
        """Why the gate or the HAL stopped, "" if neither has."""
        if self.hal_refused:
            return "the HAL cannot do what was released"
        return self._gate.status().cause if self._gate.has_stopped else ""

    def _take(self, outputs: Sequence[GateOutput]) -> None:
        for output in outputs:
            if output.kind == "lease":
                lease = decode(Lease, output.payload)
                waiting = (one for one in lease.grants if one.decision == Decision.UNDECIDED)
                self.undecided = tuple(one.source for one in waiting)
                self._hal.on_lease(lease, self._gate.now_ns)
            elif output.kind == "safe_chunk":
                self._hal.on_safe_chunk(decode(SafeChunk, output.payload))


def _measured(now: Moment, tick: int) -> Measured:
    return Measured(tick, now.positions.copy(), now.velocities.copy(), np.array(now.efforts))
