"""The check in the gate's place: leases and rows, right and wrong, for one HAL."""

from __future__ import annotations

import secrets
import threading
import time
from collections.abc import Callable, Sequence

from fairlead.errors import MessageError, RefusedError
from fairlead.hal.identity import gate_limits
from fairlead.keys import Keys
from fairlead.messages import (
    HELD,
    Decision,
    GateState,
    Grant,
    HalStatus,
    Lease,
    SafeChunk,
    StatusQuery,
    StopLevel,
    decode,
)
from fairlead.robot.manifest import RobotManifest
from fairlead.wire.bus import Bus, Qos, Sample
from fairlead_tools.conformance.heard_states import HeardStates
from fairlead_tools.conformance.plan import Plan, Released, Rows, action_parts

SOURCE = "hal_check"
LEASE_S = 0.015
"""Between two leases: well within the 25 ms that a gate promises."""
LEAD_S = 0.06
"""How long a chunk may be under way."""
ANSWER_S = 5.0
FOR_EVER = 1 << 62
SAID_S = 0.1
"""What was repeated for so long in leases has been heard."""


class StandInGate:
    """Sends a lease on every state, at least every 30 ms, from the first `arm` until `close`.

    Raises (from whatever waits):
        SilentHalError: the HAL goes no further.
        RefusedError: a real gate is alive.

    Args:
        profile: safety profile whose gate file its leases name.
    """

    def __init__(
        self, bus: Bus, keys: Keys, robot: RobotManifest, profile: str, hal: HalStatus
    ) -> None:
        self._limits = gate_limits(robot, profile)
        self._bus, self._keys, self._robot, self.hal = bus, keys, robot, hal
        self._lock = threading.Lock()
        self._ended = threading.Event()
        self.plan, self._epochs = Plan(), set[int]()
        self._verdict = secrets.randbits(40) + 1
        self.last_lease_ns = 0
        self.heard_stops: dict[int, StopLevel] = {}
        self.stop_times_ns: dict[int, list[int]] = {}
        self._known_stops: set[int] = set()
        self._leases = bus.publisher(keys.lease, Lease, Qos.HOT)
        self._stop = bus.publisher(keys.stop, StopLevel, Qos.HOT)
        self._safe = {SOURCE: bus.publisher(keys.safe(SOURCE), SafeChunk, Qos.HOT)}
        self._intruder = 0
        self.states = HeardStates(bus, keys, robot, hal, self._on_state)
        self._subscriptions = [
            bus.subscribe(keys.lease, self._on_lease),
            bus.subscribe(keys.stop, self._on_stop),
        ]
        self._timer = threading.Thread(target=self._run_timer, name="leases", daemon=True)
        self._timer.start()

    # --- leases ----------------------------------------------------------------------

    def arm(self) -> None:
        """A new epoch, as after an operator's arm."""
        with self._lock:
            self._begin_epoch()
            self.plan.state = GateState.ARMED
        self._send_lease()

    def _begin_epoch(self) -> None:
        shape = self.plan.shape
        self.plan = Plan(epoch=secrets.randbits(63) + 1, shape=shape)
        self._epochs.add(self.plan.epoch)

    def say(self, state: GateState, stop_ids: Sequence[int] = ()) -> None:
        """State and stops of the present epoch; returns once the HAL has had time to hear it."""
        with self._lock:
            self.plan.state, self.plan.stop_ids = state, tuple(stop_ids)
        self.pause(SAID_S)

    def silence(self) -> int:
        """No more leases; when the last was sent."""
        with self._lock:
            self.plan.shape = lambda lease: None
            return self.last_lease_ns

    def speak(self, shape: Callable[[Lease], Lease | None] | None = None) -> None:
        """Leases again, each changed by ``shape``."""
        with self._lock:
            self.plan.shape = shape

    def take_claim(self, until_tick: int = FOR_EVER, waits: bool = False) -> int:
        """A claim of its own for what is released next; ends those before.

        Args:
            waits: a world in lockstep makes no step before something is released.
        """
        claim = secrets.randbits(63) + 1
        with self._lock:
            self.plan.claims, self.plan.released = {claim: until_tick}, {}
            self.plan.waits = waits and self.hal.pacing == "lockstep"
        self._send_lease()
        return claim

    def drop_claims(self) -> None:
        """Nobody has a claim: a world in lockstep stands still."""
        with self._lock:
            self.plan.claims, self.plan.released, self.plan.waits = {}, {}, False

    def lease(self) -> Lease:
        """As it would be sent next."""
        plan, tick = self.plan, self.states.newest_tick
        return Lease(
            session=self.hal.session,
            epoch=plan.epoch,
            lease_seq=plan.seq,
            config_hash=self._limits,
            state=plan.state,
            state_tick=tick,
            grants=()
            if plan.waits
            else tuple(self._grant(one, until, tick) for one, until in plan.claims.items()),
            stop_ids=plan.stop_ids,
        )

    def _grant(self, claim: int, until: int, tick: int) -> Grant:
        acting = [
            one.verdict for one in self.plan.released.get(claim, ()) if one.first <= tick < one.end
        ]
        decision = Decision.ROW if acting else Decision.HOLD
        verdict = max(acting, default=0)
        return Grant(
            source=SOURCE, claim_id=claim, until_tick=until, decision=decision, verdict_id=verdict
        )

    def _send_lease(self) -> None:
        with self._lock:
            if self.plan.epoch == 0:
                return
            self.plan.seq += 1
            made = self.lease()
            lease = made if self.plan.shape is None else self.plan.shape(made)
            if lease is None:
                return
            self._epochs.add(lease.epoch)
            self._leases.put(lease)
            self.last_lease_ns = time.monotonic_ns()

    def _run_timer(self) -> None:
        while not self._ended.wait(LEASE_S):
            if time.monotonic_ns() - self.last_lease_ns > LEASE_S * 1e9:
                self._send_lease()

    def _on_state(self) -> None:
        self._send_lease()

    def _on_lease(self, sample: Sample) -> None:
        try:
            lease = decode(Lease, sample.payload)
        except MessageError:
            return  # the HAL's inbox counts it; it is not this check's
        if lease.epoch not in self._epochs:
            self._intruder += 1

    # --- released rows ----------------------------------------------------------------

    def release(
        self,
        rows: Rows,
        first: int | None = None,
        on_key: str = SOURCE,
        change: Callable[[SafeChunk], SafeChunk] | None = None,
    ) -> Released:
        """Send rows of the newest claim, from a tick that is still to come.

        Args:
            change: makes something else of the chunk.
        """
        lead = max(2, -(-int(LEAD_S * 1e9) // self.hal.period_ns) + 1)
        begin = self.states.newest_tick + lead if first is None else first
        with self._lock:
            self._verdict += 1
            claim = next(iter(self.plan.claims), 0)
            sent = Released(self._verdict, begin, len(rows), time.monotonic_ns())
            self.plan.released.setdefault(claim, []).append(sent)
            self.plan.waits = False
            chunk = SafeChunk(
                session=self.hal.session,
                epoch=self.plan.epoch,
                claim_id=claim,
                source=SOURCE,
                verdict_id=sent.verdict,
                judged_tick=self.states.newest_tick,
                first_tick=begin,
                horizon=len(rows),
                after=HELD,
                parts=action_parts(self._robot, rows),
            )
        self._put(chunk if change is None else change(chunk), on_key)
        return sent

    def _put(self, chunk: SafeChunk, on_key: str) -> None:
        if on_key not in self._safe:
            key = self._keys.safe(on_key)
            self._safe[on_key] = self._bus.publisher(key, SafeChunk, Qos.HOT)
        self._safe[on_key].put(chunk)

    # --- stops -------------------------------------------------------------------------

    def raise_stop(self, reason: str) -> StopLevel:
        """A stop under an id of its own."""
        stop = StopLevel(stop_id=secrets.randbits(63) + 1, by=SOURCE, reason=reason)
        self._known_stops.add(stop.stop_id)
        self.send_stop(stop)
        return stop

    def send_stop(self, stop: StopLevel) -> None:
        """These very bytes, also again."""
        self._stop.put(stop)

    def clear_stops(self) -> list[StopLevel]:
        """As a gate whose operator resets every stop; those that the HAL had raised by itself."""
        held = dict(self.heard_stops)
        own = [stop for one, stop in held.items() if one not in self._known_stops]
        self.say(GateState.STOPPED, list(held)[:16])
        self.say(GateState.DISARMED)
        self._known_stops.update(held)
        self.heard_stops.clear()
        self.arm()
        return own

    def _on_stop(self, sample: Sample) -> None:
        try:
            stop = decode(StopLevel, sample.payload)
        except MessageError:
            return
        self.stop_times_ns.setdefault(stop.stop_id, []).append(time.monotonic_ns())
        if stop.by != SOURCE or stop.stop_id in self._known_stops:
            self.heard_stops[stop.stop_id] = stop

    # --- waiting -----------------------------------------------------------------------

    def wait_tick(self, tick: int) -> None:
        """Until the state of a tick is there."""
        self.states.wait_tick(tick)
        self.refuse_intruder()

    def refuse_intruder(self) -> None:
        """Raises RefusedError where another writes leases."""
        if self._intruder:
            why = "a gate is alive on this robot's bus, and the check has to take its place"
            raise RefusedError("hal check", why, "fairlead up NAME --without safety")

    def pause(self, seconds: float) -> None:
        """Let time pass, unless this has ended."""
        self._ended.wait(seconds)

    def hal_state(self) -> str:
        """What the HAL's status says now; NoAnswerError after 5 s."""
        reply = self._bus.query(self._keys.hal_status, StatusQuery(), ANSWER_S)
        return decode(HalStatus, reply).state

    def close(self) -> None:
        """Leave the robot held: no claim, nothing granted, then no more leases."""
        self.speak()
        self.drop_claims()
        if self.plan.epoch:
            self.say(GateState.DISARMED)
        self._ended.set()
        self._timer.join()
        self.states.close()
        for one in self._subscriptions:
            one.undeclare()
