"""Parts of a robot held by a program of one's own, which sends chunks for them to the gate."""

from __future__ import annotations

import hashlib
import threading
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from fairlead.errors import NoAnswerError, RefusedError, ServiceError
from fairlead.messages import (
    NO_TRACE,
    ActionChunk,
    ActionPart,
    Claim,
    ClaimReply,
    JointState,
    Lease,
    Outcome,
    Verdict,
    decode,
    encode,
)
from fairlead.modes import ControlMode
from fairlead.operate.claim_watch import ClaimWatch
from fairlead.operate.client import RobotClient
from fairlead.operate.own_claim import held_claim
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Qos, Sample
from fairlead.wire.verdict_text import describe

ANSWER_TIMEOUT_S = 3.0
RESEND_S = 0.1
FLOAT_BYTES = 8


class PartClaim:
    """One live claim: what the robot measures, and a way to command it through the gate.

    In lockstep the world waits for each tick's rows; in realtime the parts hold once the rows
    of the newest chunk are used up.
    """

    def __init__(
        self, client: RobotClient, source: str, robot: RobotManifest, claim: ClaimReply
    ) -> None:
        self._source, self._robot, self._claim = source, robot, claim
        self._changed = threading.Condition()
        self._watch = ClaimWatch(source, claim.claim_id, claim.epoch, claim.session)
        self._lost = ""
        self._state: JointState | None = None
        self._told = 0
        self._seq = 0
        self._payload = b""
        self._verdict: Verdict | None = None
        bus, keys = client.bus, client.keys
        self._candidate = bus.publisher(keys.candidate(source), ActionChunk, Qos.HOT)
        self._heard = [
            bus.subscribe(keys.joints, self._on_joints),
            bus.subscribe(keys.verdict(source), self._on_verdict),
            bus.subscribe(keys.lease, self._on_lease),
        ]

    def next_state(self, timeout_s: float = ANSWER_TIMEOUT_S) -> JointState:
        """What was measured at a tick after the one told last, as soon as there is one.

        Raises:
            ServiceError: the claim is lost.
            NoAnswerError: no new tick in time.
        """
        self._wait(lambda: self._newest_tick > self._told, "joint state", timeout_s)
        assert self._state is not None
        self._told = self._state.tick
        return self._state

    def send(self, tick: int, parts: Sequence[ActionPart]) -> Verdict:
        """Propose rows computed from the state of ``tick``, the first one for that tick.

        Rows released before are replaced from there on. Rows whose tick has passed are dropped.

        Returns:
            The gate's verdict: released, or truncated after the rows that may act.

        Raises:
            RefusedError: the gate refused the rows; the ones released before still act.
            ServiceError: the claim is lost.
            NoAnswerError: no verdict in time.
        """
        width = ControlMode(parts[0].mode).width(self._robot.n_dof)
        with self._changed:
            self._seq += 1
            self._verdict = None
            self._payload = encode(
                ActionChunk(
                    robot_hash=self._robot.robot_hash,
                    session=self._claim.session,
                    epoch=self._claim.epoch,
                    claim_id=self._claim.claim_id,
                    source=self._source,
                    seq=self._seq,
                    goal_id=0,
                    obs_tick=tick,
                    oldest_tick=tick,
                    start_tick=tick,
                    horizon=len(parts[0].values) // (FLOAT_BYTES * width),
                    parts=tuple(parts),
                    trace=NO_TRACE,
                )
            )
        self._candidate.put_bytes(self._payload)
        self._wait(lambda: self._verdict is not None, "verdict", ANSWER_TIMEOUT_S)
        assert self._verdict is not None
        if self._verdict.outcome == Outcome.REFUSED:
            raise RefusedError("safety", describe(self._verdict), "fairlead why")
        return self._verdict

    def close(self) -> None:
        """Listen no longer."""
        for subscription in self._heard:
            subscription.undeclare()

    @property
    def _newest_tick(self) -> int:
        return self._state.tick if self._state is not None else 0

    def _wait(self, condition: Callable[[], bool], what: str, timeout_s: float) -> None:
        with self._changed:
            self._changed.wait_for(lambda: condition() or bool(self._lost), timeout_s)
            if self._lost:
                raise ServiceError(self._lost)
            if not condition():
                raise NoAnswerError(f"{self._source}: no {what} within {timeout_s:g} s")

    def _on_joints(self, sample: Sample) -> None:
        """A tick that comes again, or a verdict that does not: a message may be lost."""
        state = decode(JointState, sample.payload)
        with self._changed:
            again = self._payload and (state.tick == self._newest_tick or self._verdict is None)
            self._state = state
            self._changed.notify_all()
        if again:
            self._candidate.put_bytes(self._payload)

    def _on_verdict(self, sample: Sample) -> None:
        verdict = decode(Verdict, sample.payload)
        with self._changed:
            if (verdict.claim_id, verdict.seq) == (self._claim.claim_id, self._seq):
                self._verdict = verdict
                self._changed.notify_all()

    def _on_lease(self, sample: Sample) -> None:
        lease = decode(Lease, sample.payload)
        with self._changed:
            self._lost = self._lost or self._watch.lost(lease)
            if self._lost:
                self._changed.notify_all()


@contextmanager
def claim_parts(
    client: RobotClient, source: str, robot: RobotManifest, parts: Sequence[str], task: str = ""
) -> Iterator[PartClaim]:
    """Hold ``parts`` as ``source``, with heartbeats, until the block ends; then they hold still.

    The gate has to be armed. Another source's claims are not touched.

    Args:
        source: a name of one's own, not that of a runner: it stands in keys and verdicts.
        task: what for, as ``fairlead status`` shows it; "": ``source``.

    Raises:
        RefusedError: the gate does not grant the claim, for example of a part that is held.
    """
    protocol = robot.profile(client.deployment.profile).protocol
    request = Claim(
        source=source,
        skill=task or source,
        skill_hash=hashlib.sha256((task or source).encode()).digest(),
        robot_hash=robot.robot_hash,
        period_ns=robot.tick_period_ns,
        parts=robot.claimed_parts(parts),
        chunk_rate_hz=1e9 / robot.tick_period_ns,
        horizon_max=protocol.horizon_max,
        age_max_ticks=protocol.age_max_ticks,
        limits=(),
    )
    with held_claim(client, request) as reply:
        claim = PartClaim(client, source, robot, reply)
        try:
            yield claim
        finally:
            claim.close()
