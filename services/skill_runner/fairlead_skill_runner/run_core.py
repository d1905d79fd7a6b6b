"""One goal from its claim to its result: messages and time in, outputs out.

No transport, no clock, no thread, no process: the caller brings messages and its
monotonic time, executes the outputs in order, and reads `RunCore.result`.

Lockstep: the policy is asked only at a tick for which no released row is left, with the
layout, task state and frames of exactly that tick, so every run is the same run.
Realtime: the next observation is taken early enough that the rows last until its chunk
is judged; rows that passed meanwhile are dropped by index by the gate.
"""

from __future__ import annotations

import numpy as np

from fairlead.errors import PolicyError
from fairlead.messages import (
    GoalResult,
    HalStatus,
    Image,
    JointState,
    LayoutState,
    Lease,
    Outcome,
    TaskState,
    Verdict,
    floats,
)
from fairlead.operate.claim_watch import ClaimWatch
from fairlead.policy import Done, Failed
from fairlead_skill_runner import results
from fairlead_skill_runner.candidate import candidate
from fairlead_skill_runner.chunk_tracker import ChunkTracker
from fairlead_skill_runner.fitted_rows import FitCounts, fitted
from fairlead_skill_runner.gate_feedback import GateFeedback
from fairlead_skill_runner.observation_buffer import (
    LayoutWatch,
    ObservationBuffer,
    TimedObservation,
)
from fairlead_skill_runner.observation_schedule import ObservationSchedule
from fairlead_skill_runner.run_outputs import AskPolicy, Output, PolicyAnswer, SendChunk
from fairlead_skill_runner.run_setup import RunSetup

QUIET_S = 0.5  # without released rows for so long, the phase says what is awaited


class RunCore:
    """The loop of one goal."""

    def __init__(self, setup: RunSetup, now_s: float) -> None:
        self.setup = setup
        self.result: GoalResult | None = None
        self.tick = 0
        self.first_tick = 0
        self.inferences = 0
        self.starved = 0
        self.last_refusal = ""
        self.phase = "running"
        rate_hz = setup.skill.rate_hz * setup.periods
        self._chunks = ChunkTracker(1.0 / rate_hz, setup.first_seq)
        self._watch = ClaimWatch(setup.source, setup.claim_id, setup.epoch, setup.session)
        self._inputs = ObservationBuffer(
            setup.skill, setup.prompt, setup.camera_periods, exact=setup.lockstep,
            has_task=setup.has_task, periods=setup.periods,
        )  # fmt: skip
        self._asked: TimedObservation | None = None
        self._asked_s = 0.0
        self._progress_s = now_s
        self._schedule = ObservationSchedule(setup.skill.execute_steps * setup.periods)
        self._layouts = LayoutWatch(lockstep=setup.lockstep, rate_hz=rate_hz)
        self._feedback = GateFeedback(setup.routes, setup.periods)
        self._fits = FitCounts(setup.routes)
        self._positions = np.zeros(0)  # of the measured joints in the newest tick
        self._is_starved = False  # the newest tick had no row
        self._anchor_tick = 0  # the first before which its parts held, or an offered claim

    def is_over(self) -> bool:
        """True once there is a result."""
        return self.result is not None

    @property
    def queue_depth(self) -> int:
        """Released rows after the newest tick."""
        return max(0, self._chunks.released_last - self.tick)

    @property
    def next_seq(self) -> int:
        """Of the chunk to be sent next."""
        return self._chunks.next_seq

    # --- messages ------------------------------------------------------------------

    def on_joints(self, joints: JointState, now_s: float) -> list[Output]:
        """The clock: a new tick, or in lockstep the same one again."""
        # Another session is another HAL: the gate says whether it follows that, and ends the claim.
        if self.result or joints.session != self.setup.session or joints.tick < self.tick:
            return []
        repeated = joints.tick == self.tick
        self.tick, self._positions = joints.tick, floats(joints.positions)
        self._feedback.on_joints(joints)
        if not self._anchor_tick and (self.setup.handed_over or self._feedback.all_held(self.tick)):
            self._anchor_tick = self.tick
        silent = self._layouts.silent_ticks(self.tick)
        if silent:
            return self._end(results.layout_missing(silent, self.tick))
        # In lockstep the world waits for the picture, and the goal ends by its stall timeout.
        blind = "" if self.setup.lockstep or not self.first_tick else self._inputs.blind(self.tick)
        if blind:
            return self._end(results.camera_lost(blind))
        if not repeated and self.tick <= self._chunks.released_last:
            self._progress_s = now_s  # released rows act
        if not repeated and not self.setup.lockstep:
            self._count_starved()
        again = self._chunks.due_again(self.tick, repeated)
        outputs: list[Output] = [] if again is None else [SendChunk(again)]
        return outputs + self._advance(now_s)

    def on_layout(self, layout: LayoutState, now_s: float) -> list[Output]:
        """A state vector, or a fault of which several in a row end the goal.

        Another skill's is ignored: another runner may run one that ours offers too.
        """
        ours = (self.setup.session, self.setup.skill.id)
        if self.result or (layout.session, layout.skill) != ours:
            return []
        problem = results.wrong_layout(self.setup.skill, layout)
        if problem:
            return self._end(problem)
        if layout.fault is not None:
            if self._layouts.is_last_fault(layout.tick):
                return self._end(results.layout_fault(layout.tick, layout.fault))
            return []
        self._layouts.good(layout.tick)
        self._inputs.add_layout(layout)
        return self._advance(now_s)

    def on_task(self, task: TaskState, now_s: float) -> list[Output]:
        """The task's own check; a success ends the goal at the next decision."""
        if self.result or not self.setup.has_task or task.session != self.setup.session:
            return []
        self._inputs.add_task(task)
        return self._advance(now_s)

    def on_image(self, image: Image, now_s: float) -> list[Output]:
        """A picture from a camera of this skill."""
        if self.result or image.session != self.setup.session:
            return []
        self._inputs.add_image(image)
        return self._advance(now_s)

    def on_lease(self, lease: Lease) -> list[Output]:
        """The goal ends with its claim."""
        lost = "" if self.result else self._watch.lost(lease)
        return self._end(results.claim_lost(lost)) if lost else []

    def on_hal_status(self, status: HalStatus) -> list[Output]:
        """The goal ends when the HAL reports a fault."""
        if self.result or status.state != "fault":
            return []
        return self._end(results.hal_fault(status.detail))

    def on_verdict(self, verdict: Verdict, now_s: float) -> list[Output]:
        """The gate's answer to a chunk; those of others' claims are ignored."""
        setup = self.setup
        about = (verdict.session, verdict.epoch, verdict.claim_id)
        ours = about == (setup.session, setup.epoch, setup.claim_id)
        if self.result or not ours or not self._chunks.judged(verdict):
            return []
        if verdict.outcome != Outcome.REFUSED:
            self._progress_s = now_s
            self.phase = self._moving()
        if verdict.outcome != Outcome.RELEASED:
            self.last_refusal = self._chunks.words(verdict)
        answer_tick = self._chunks.obs_tick(verdict.seq)
        if answer_tick is not None:
            self._feedback.on_verdict(verdict, answer_tick)
        newest = self._chunks.newest
        if newest is not None and verdict.seq == newest.seq:
            self._schedule.judged(newest, verdict)
        return self._advance(now_s)

    def on_policy(self, call: int, answer: PolicyAnswer, now_s: float) -> list[Output]:
        """The answer to `AskPolicy`; one that is not awaited is ignored."""
        asked = self._asked
        if self.result or asked is None or call != self.inferences:
            return []
        self._asked = None
        took_s = now_s - self._asked_s
        self._progress_s += took_s  # the policy's own time is no stall
        if isinstance(answer, PolicyError):
            return self._end(results.policy_error(answer))
        if isinstance(answer, Done | Failed):
            return self._end(results.by_policy(answer))
        sent = fitted(self.setup.routes, answer)
        self._fits.add(answer, sent)
        seq, before = self._chunks.next_seq, self._chunks.released_rows()
        chunk = candidate(
            self.setup, seq, asked, sent, self.tick, self._positions, before,
            self.setup.handed_over and not self._feedback.all_held(self.tick),
        )  # fmt: skip
        self._chunks.sent(chunk, took_s)
        self._feedback.on_answer(chunk.obs_tick, answer, chunk.horizon)
        self._schedule.sent(chunk, self.tick)
        return [SendChunk(chunk.payload), *self._advance(now_s)]

    def on_time(self, now_s: float) -> list[Output]:
        """Call a few times a second."""
        if self.result or self._asked:
            return []
        quiet_s = now_s - self._progress_s
        awaited = self._awaited()
        if quiet_s > self.setup.stall_timeout_s:
            return self._end(results.stalled(quiet_s, awaited, self.tick, self.last_refusal))
        self.phase = f"waiting for {awaited}" if quiet_s > QUIET_S else self._moving()
        return []

    def cancel(self, by: str) -> list[Output]:
        """End the goal now, unless it has ended."""
        return [] if self.result else self._end(results.cancelled(by))

    # --- decisions -----------------------------------------------------------------

    def _advance(self, now_s: float) -> list[Output]:
        if self.result or not self._anchor_tick:
            return []
        if self.setup.lockstep:
            return self._advance_lockstep(now_s)
        ended = self._ended()
        if ended:
            return self._end(ended)
        wanted = self._wanted_tick()
        if self._asked or self.tick < wanted or self._inputs.missing(wanted):
            return []
        if self._inputs.is_ahead_of(self.tick):  # what acted before it is still under way
            return []
        return self._ask(now_s)

    def _advance_lockstep(self, now_s: float) -> list[Output]:
        chunks, tick = self._chunks, self.tick
        undecided = (
            chunks.is_settled(tick) and max(chunks.released_last, chunks.last_obs_tick) < tick
        )
        if self._asked or not undecided or self._inputs.missing(tick):
            return []
        ended = self._ended()
        return self._end(ended) if ended else self._ask(now_s)

    def _ended(self) -> GoalResult | None:
        task = self._inputs.task
        if task is not None and task.success:
            return results.success() if self.inferences else results.solved_before()
        deadline = self.setup.deadline_ticks
        if deadline and self.first_tick and self.tick - self.first_tick >= deadline:
            return results.deadline(deadline, self._chunks.refusals)
        return None

    def _ask(self, now_s: float) -> list[Output]:
        try:
            gathered = self._inputs.gather()
        except PolicyError as error:
            return self._end(results.policy_error(error))
        self._asked, self._asked_s = gathered, now_s
        self.inferences += 1
        seen = self._feedback.added_to(gathered.observation, self._schedule.delay_ticks)
        self.first_tick = self.first_tick or seen.tick
        return [AskPolicy(self.inferences, seen)]

    def _count_starved(self) -> None:
        if self._chunks.released_last:
            was, self._is_starved = self._is_starved, self._feedback.lacked_row(self.tick)
            self.starved += self._is_starved
            if was != self._is_starved:
                self.phase = self._moving()

    def _moving(self) -> str:
        """The phase of a goal whose policy and gate do their work."""
        return "starved" if self._is_starved else "running"

    def _awaited(self) -> str:
        if self.tick == 0:
            return "a joint state"
        if not self._anchor_tick:
            return "its parts to hold"
        if not self._chunks.answered:
            return "the gate's verdict"
        # A tick's own inputs come after it: in realtime they may just be under way.
        wanted = self.tick if self.setup.lockstep else min(self.tick, self._wanted_tick())
        return self._inputs.missing(wanted) or "released rows"

    def _wanted_tick(self) -> int:
        """The earliest that is observed next, in realtime."""
        return max(self._schedule.next_tick, self._chunks.last_obs_tick + 1, self._anchor_tick)

    def _end(self, ended: GoalResult) -> list[Output]:
        self.result = results.at_ticks(ended, self.first_tick, self.tick, self._fits.words())
        self.phase = "ended"
        return []
