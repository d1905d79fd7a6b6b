"""A runner in virtual time: one policy, one claim, re-sends instead of answering twice."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from fairlead.messages import (
    NO_TRACE,
    ActionChunk,
    ActionPart,
    ClaimReply,
    FloatArray,
    Heartbeat,
    JointState,
    Verdict,
    encode,
    floats,
    pack_floats,
)
from fairlead.modes import ControlMode
from tests.explorer.channel import MS, Schedule
from tests.explorer.hal_actor import BASE

HORIZON = 8
HEARTBEAT_NS = 50 * MS


def policy(positions: FloatArray, tick: int) -> FloatArray:
    """Base velocities ``[HORIZON, 3]`` that depend on what was measured; sometimes too fast.

    The others are slow enough for the gate wherever the arm is: faster, a base that is stopped
    could push links together that are as near as hand and forearm are here (G032).
    """
    ahead = 0.3 * (tick + np.arange(HORIZON, dtype=np.float64))
    rows: FloatArray = 0.2 * np.sin(ahead[:, None] + positions[None, :3])
    if tick % 5 == 3:
        rows[3, 0] = 1.4  # truncated before row 3
    if tick % 7 == 2:
        rows[0, 1] = -1.4  # refused
    return rows


class RunnerActor:
    """Infers when no released row is left, or (realtime) when few are; remembers its answers.

    Attributes:
        source: under which it sends; another one after a hand-over.
    """

    def __init__(
        self, schedule: Schedule, lockstep: bool, publish: Callable[[str, bytes], None]
    ) -> None:
        self._schedule = schedule
        self._lockstep = lockstep
        self._publish = publish
        self._claim: ClaimReply | None = None
        self.source = "runner"
        self._robot_hash = b""
        self._seq = 0
        self._newest_tick = 0
        self._chunk: ActionChunk | None = None
        self._frame = b""
        self._verdict: Verdict | None = None
        self.sent: list[ActionChunk] = []

    def start(self) -> None:
        self._beat()

    def take_claim(self, claim: ClaimReply, robot_hash: bytes) -> None:
        self._claim, self._robot_hash = claim, robot_hash
        self._seq, self._chunk, self._verdict = 0, None, None

    def go_on_as(self, source: str) -> None:
        """The claim is handed over: a source's numbers rise, what it has heard is forgotten."""
        self._seq = self._seq if source == self.source else 0
        self.source, self._chunk, self._verdict = source, None, None

    def drop_claim(self) -> None:
        self._claim = None

    def on_state(self, state: JointState) -> None:
        if self._claim is None or state.tick < self._newest_tick:
            return
        is_repeat = state.tick == self._newest_tick
        self._newest_tick = state.tick
        chunk = self._chunk
        if chunk is not None and self._verdict is None:
            if self._lockstep or (state.tick <= chunk.obs_tick + 3 and not is_repeat):
                self._publish("candidate", self._frame)
                return
        elif chunk is not None and chunk.obs_tick == state.tick:
            self._publish("candidate", self._frame)
            return
        if self._rows_left(state) == 0:
            self._answer(state)

    def on_verdict(self, source: str, verdict: Verdict) -> None:
        if source != self.source:  # another key
            return
        chunk = self._chunk
        if chunk and (verdict.claim_id, verdict.seq) == (chunk.claim_id, chunk.seq):
            self._verdict = self._verdict or verdict

    def _rows_left(self, state: JointState) -> int:
        """Released rows from this tick on (realtime: 0 also shortly before the last one)."""
        if self._chunk is None or self._verdict is None:
            return 0
        margin = 0 if self._lockstep else 3
        return max(0, self._verdict.released_last - margin - state.tick + 1)

    def _answer(self, state: JointState) -> None:
        assert self._claim is not None
        self._seq += 1
        values = np.zeros((HORIZON, 11))
        values[:, :3] = policy(floats(state.positions), state.tick)
        part = ActionPart(
            part=BASE,
            mode=ControlMode.JOINT_VELOCITY,
            frame_id="",
            values=pack_floats(values),
            active=(0, 1, 2),
        )
        self._chunk = ActionChunk(
            robot_hash=self._robot_hash,
            session=self._claim.session,
            epoch=self._claim.epoch,
            claim_id=self._claim.claim_id,
            source=self.source,
            seq=self._seq,
            goal_id=1,
            obs_tick=state.tick,
            oldest_tick=state.tick,
            start_tick=state.tick,
            horizon=HORIZON,
            parts=(part,),
            trace=NO_TRACE,
        )
        self._verdict = None
        self._frame = encode(self._chunk)
        self.sent.append(self._chunk)
        self._publish("candidate", self._frame)

    def _beat(self) -> None:
        if self._claim is not None:
            self._publish("heartbeat", encode(Heartbeat(claim_id=self._claim.claim_id)))
        self._schedule.at(self._schedule.now_ns + HEARTBEAT_NS, self._beat)
