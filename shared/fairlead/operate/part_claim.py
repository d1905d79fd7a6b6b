"""Parts of a robot held by a program of one's own, which sends chunks for them to the gate."""

from __future__ import annotations

import asyncio
import math
import time
from collections.abc import Callable
from contextlib import suppress

import numpy.typing as npt

from fairlead.errors import (
    ChunkRefusedError,
    ClaimLostError,
    ConfigError,
    FairleadError,
    NoAnswerError,
    RefusedError,
    expected,
)
from fairlead.messages import (
    NO_TRACE,
    ActionChunk,
    ActionPart,
    Claim,
    ClaimReply,
    Done,
    Heartbeat,
    JointState,
    Lease,
    Outcome,
    Release,
    TransformBatch,
    Verdict,
    encode,
)
from fairlead.modes import ControlMode
from fairlead.operate.changes import Changes, unbroken
from fairlead.operate.claim_watch import ClaimWatch
from fairlead.operate.heartbeat import beat
from fairlead.operate.rows import Offered, common_horizon, offered_modes, part_rows
from fairlead.operate.services import ANSWER_TIMEOUT_S, Services
from fairlead.operate.subscription import watch
from fairlead.operate.tick import Tick, TickBuilder
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Qos
from fairlead.wire.verdict_text import describe, why_not_armed

LEASE_SILENCE_S = 2.0  # leases come at least every 25 ms
RESUME_S = 0.5


class PartClaim:
    """Parts to hold while its block lasts: ``async with robot.claim(["base"], ...) as claim``.

    Heartbeats keep the claim alive from a task of this event loop: a loop that hangs loses it
    (after 300 ms in realtime, 2 s in lockstep). Leaving the block, also by an error or because
    the task is cancelled, gives the parts back; they hold still.

    In lockstep the world waits where a tick has no row yet; in realtime the parts hold once the
    rows of the newest chunk are used up.

    Attributes:
        reply: the gate's: the claim's id, its epoch and the HAL's session.
    """

    reply: ClaimReply

    def __init__(self, services: Services, robot: RobotManifest, request: Claim) -> None:
        self._services, self._robot, self._request = services, robot, request
        self._source = request.source
        self._changes = Changes()
        self._taking: asyncio.Future[ClaimReply] | None = None  # until the gate has answered
        self._beating: asyncio.Future[None] | None = None  # while its parts are held
        self._seq, self._is_sending = 0, False
        self._offered: Offered | None = None  # before the HAL is asked

    # --- its block --------------------------------------------------------------------

    async def __aenter__(self) -> PartClaim:
        """Take it. `RefusedError` says why the gate does not grant it, and who holds a part."""
        if self._beating is not None:
            raise ConfigError(f"claim of {self._source}: held already; make another")
        await self._services.wait_alive(self._services.gate)
        self._offered = offered_modes(await self._services.hal_status())
        self._taking = asyncio.ensure_future(self._take())
        try:
            self.reply = await asyncio.shield(self._taking)
            if self._taking is None:
                raise ClaimLostError(f"claim of {self._source} lost: given back while it was taken")
        except asyncio.CancelledError:
            await self.release()
            raise
        finally:
            self._taking = None
        self._begin()
        return self

    async def __aexit__(self, _kind: object, error: BaseException | None, _trace: object) -> None:
        try:
            await unbroken(self.release())
        except FairleadError:
            if error is None:
                raise

    async def release(self) -> None:
        """Give the parts back before the block ends; of a claim that is lost nothing is left."""
        if self._taking is not None:  # what the gate grants meanwhile is given back
            taking, self._taking = self._taking, None
            with suppress(FairleadError):
                self.reply = await taking
                await self._release()
        if self._beating is None:
            return
        beating, self._beating = self._beating, None
        try:
            if not self._lost:
                await self._release()
        finally:
            beating.cancel()
            for mailbox in self._heard:
                mailbox.close()

    async def _take(self) -> ClaimReply:
        key = self._services.command(self._services.keys.claim(self._source))
        return await self._services.ask(self._services.gate, key, self._request, ClaimReply)

    async def _release(self) -> None:
        key = self._services.keys.release(self._source)
        request = Release(source=self._source, claim_id=self.reply.claim_id)
        with suppress(RefusedError):  # the gate has ended it a moment before
            await self._services.ask(self._services.gate, key, request, Done)

    def _begin(self) -> None:
        bus, keys = self._services.bus, self._services.keys
        reply = self.reply
        self._watch = ClaimWatch(self._source, reply.claim_id, reply.epoch, reply.session)
        self._ticks = TickBuilder(reply.session)
        self._lost, self._is_explained = "", False
        self._tick: Tick | None = None
        self._told = 0
        self._payload = b""
        self._verdict: Verdict | None = None
        self._lease_s = time.monotonic()
        self._candidate = bus.publisher(keys.candidate(self._source), ActionChunk, Qos.HOT)
        self._heard = [
            watch(bus, keys.tf(self._services.hal), TransformBatch, self._ticks.on_transforms),
            watch(bus, keys.joints, JointState, self._on_joints),
            watch(bus, keys.verdict(self._source), Verdict, self._on_verdict),
            watch(bus, keys.lease, Lease, self._on_lease),
        ]
        hearts = bus.publisher(keys.heartbeat(self._source), Heartbeat, Qos.HOT)
        self._beating = asyncio.ensure_future(beat(hearts, reply.claim_id))

    # --- for the program that holds it --------------------------------------------------

    async def next_tick(self, timeout_s: float = ANSWER_TIMEOUT_S) -> Tick:
        """What was measured at a tick after the one told last, as soon as there is one.

        Raises:
            ClaimLostError: the claim is lost.
            NoAnswerError: no new tick in time.
            ConfigError: the timeout is no number of seconds.
        """
        self._check_held()
        if not isinstance(timeout_s, int | float) or not 0.0 <= timeout_s < math.inf:
            raise ConfigError(expected(self._source, "a timeout in seconds", repr(timeout_s)))
        await self._wait(lambda: self._newest > self._told, "joint state", timeout_s)
        assert self._tick is not None
        self._told = self._tick.number
        return self._tick

    def rows(
        self,
        part: str,
        mode: ControlMode,
        rows: npt.ArrayLike,
        *,
        frame: str = "",
        joints: tuple[str, ...] = (),
    ) -> ActionPart:
        """Rows ``[H, width]`` for one part, SI, one a tick: as `part_rows`."""
        offered = self._offered
        return part_rows(self._robot, part, mode, rows, frame=frame, joints=joints, offered=offered)

    async def send(self, tick: int, *parts: ActionPart) -> Verdict:
        """Propose rows computed from what was measured at ``tick``, the first one for that tick.

        Rows released before are replaced from there on. Rows whose tick has passed are dropped.

        Returns:
            The gate's verdict: released, or truncated after the rows that may act.

        Raises:
            ChunkRefusedError: the gate refused the rows; the ones released before still act.
            ClaimLostError: the claim is lost.
            NoAnswerError: no verdict in time.
            ConfigError: no tick, no parts made by `rows`, too many rows, different horizons, or the
                verdict of another chunk is awaited.
        """
        self._check_held()
        if self._is_sending:
            what = "one chunk after the other, with all that acts together in one `send`"
            raise ConfigError(expected(self._source, what, "a second before the first's verdict"))
        if type(tick) is not int or not 0 <= tick < 2**64:
            raise ConfigError(expected(self._source, "the number of a tick", repr(tick)[:40]))
        most = self._request.horizon_max
        horizon = common_horizon(self._source, self._robot.n_dof, parts, most)
        self._seq += 1
        self._verdict = None
        self._payload = encode(
            ActionChunk(
                robot_hash=self._robot.robot_hash,
                session=self.reply.session,
                epoch=self.reply.epoch,
                claim_id=self.reply.claim_id,
                source=self._source,
                seq=self._seq,
                goal_id=0,
                obs_tick=tick,
                oldest_tick=tick,
                start_tick=tick,
                horizon=horizon,
                parts=parts,
                trace=NO_TRACE,
            )
        )
        self._is_sending = True
        try:
            self._candidate.put_bytes(self._payload)
            await self._wait(lambda: self._verdict is not None, "verdict", ANSWER_TIMEOUT_S)
        finally:
            self._is_sending = False
        assert self._verdict is not None
        if self._verdict.outcome == Outcome.REFUSED:
            raise ChunkRefusedError(describe(self._verdict), self._verdict)
        return self._verdict

    def _check_held(self) -> None:
        if self._beating is None:
            raise ClaimLostError(
                f"claim of {self._source}: not held: its block has not begun, or has ended; use it "
                "in `async with`, or `with`"
            )

    @property
    def _newest(self) -> int:
        return self._tick.number if self._tick is not None else 0

    async def _wait(self, condition: Callable[[], bool], what: str, timeout_s: float) -> None:
        await asyncio.sleep(0)  # let in what came while the program was busy
        await self._changes.wait_for(lambda: condition() or bool(self._lost), timeout_s)
        if self._is_silent():  # the gate, or this program was paused: a lease comes soon
            await self._changes.wait_for(lambda: not self._is_silent(), RESUME_S)
        if not self._lost and self._is_silent():
            self._lost = (
                f"claim of {self._source} lost: no lease for {LEASE_SILENCE_S:g} s; is the gate "
                "running? see: fairlead ps"
            )
        elif self._lost:
            await self._ask_why()
        if self._lost:
            raise ClaimLostError(self._lost)
        if not condition():
            raise NoAnswerError(f"{self._source}: no {what} within {timeout_s:g} s")

    def _is_silent(self) -> bool:
        return time.monotonic() - self._lease_s > LEASE_SILENCE_S

    async def _ask_why(self) -> None:
        """Once: a lease does not say why the gate is not armed any more."""
        if self._is_explained:
            return
        with suppress(FairleadError):
            why = why_not_armed(await self._services.gate_status())
            self._lost += f" ({why})" if why else ""
        self._is_explained = True

    # --- what is heard ------------------------------------------------------------------

    def _on_joints(self, state: JointState) -> None:
        """A tick that comes again, or a verdict that does not: a message may be lost."""
        tick = self._ticks.on_joints(state)
        if self._payload and (state.tick == self._newest or self._verdict is None):
            self._candidate.put_bytes(self._payload)
        if tick is not None:
            self._tick = tick
            self._changes.announce()

    def _on_verdict(self, verdict: Verdict) -> None:
        if (verdict.claim_id, verdict.seq) == (self.reply.claim_id, self._seq):
            self._verdict = verdict
            self._changes.announce()

    def _on_lease(self, lease: Lease) -> None:
        was_silent, self._lease_s = self._is_silent(), time.monotonic()
        self._lost = self._lost or self._watch.lost(lease)
        if self._lost or was_silent:
            self._changes.announce()
