"""The real gate core on the bus of a HAL, with its leases in our hands.

Unlike the gate's own process it can fall silent at a moment that the test knows exactly.
"""

from __future__ import annotations

import threading
import time
from queue import Queue

from bench.equipment.gate_port import EventKind, GateOutput
from bench.equipment.real_gate import RealGate
from fairlead.keys import Keys
from fairlead.messages import (
    Arm,
    ArmReply,
    Claim,
    ClaimReply,
    GateStatus,
    HalStatus,
    Heartbeat,
    Lease,
    Message,
    Refusal,
    Reset,
    SafeChunk,
    StatusQuery,
    decode,
    encode,
)
from fairlead.wire.bus import Bus, Qos, Sample

TIMER_S = 0.005
READY_TIMEOUT_S = 10.0


class LiveGate:
    """Answers states with leases until silenced; commands are plain method calls."""

    def __init__(self, bus: Bus, keys: Keys) -> None:
        self._gate = RealGate(seed=1)
        self._lock = threading.Lock()
        self._lease = bus.publisher(keys.lease, Lease, Qos.HOT)
        self._safe = bus.publisher(keys.safe("runner"), SafeChunk, Qos.HOT)
        self._silent = threading.Event()
        self._claim_id = 0
        self.last_lease_ns = 0
        self._feed("hal_status", encode(_ready_status(bus, keys)))
        self._subscriptions = [
            bus.subscribe(keys.joints, lambda sample: self._on("joint_state", sample)),
            bus.subscribe(keys.hal_status, lambda sample: self._on("hal_status", sample)),
            bus.subscribe(keys.stop, lambda sample: self._on("stop_level", sample)),
        ]
        self._timer = threading.Thread(target=self._run_timer, daemon=True)
        self._timer.start()

    @property
    def newest_tick(self) -> int:
        """Tick of the newest joint state the gate has taken."""
        return decode(GateStatus, self.ask("status", StatusQuery())).state_tick

    def arm(self) -> ArmReply:
        return decode(ArmReply, self.ask("arm", Arm(by="test")))

    def reset(self, stop_id: int) -> None:
        self._feed("reset", encode(Reset(by="test", id=stop_id)))

    def ask(self, kind: EventKind, request: Message) -> bytes:
        """The gate's reply; a refusal fails the test with the gate's words."""
        answers = {out.kind: out.payload for out in self._feed(kind, encode(request))}
        assert "reply" in answers, decode(Refusal, answers["refusal"]).reason
        return answers["reply"]

    def claim(self, request: Claim) -> ClaimReply:
        """Take a claim, and beat for it as its runner would."""
        reply = decode(ClaimReply, self.ask("claim", request))
        self._claim_id = reply.claim_id
        return reply

    def offer(self, chunk: Message) -> None:
        self._feed("candidate", encode(chunk), source="runner")

    def silence(self) -> int:
        """Say nothing from now on, as a dead gate would; the time of the last lease."""
        with self._lock:
            self._silent.set()
            return self.last_lease_ns

    def close(self) -> None:
        self._silent.set()
        self._timer.join()
        for subscription in self._subscriptions:
            subscription.undeclare()
        with self._lock:  # a message under way is the last one
            self._gate.close()

    def _on(self, kind: EventKind, sample: Sample) -> None:
        self._feed(kind, sample.payload)

    def _run_timer(self) -> None:
        while not self._silent.wait(TIMER_S):
            self._feed("timer", b"")
            if self._claim_id:
                heartbeat = Heartbeat(claim_id=self._claim_id)
                self._feed("heartbeat", encode(heartbeat), source="runner")

    def _feed(self, kind: EventKind, payload: bytes, source: str = "") -> list[GateOutput]:
        with self._lock:
            if self._silent.is_set():
                return []
            outputs = self._gate.step(time.monotonic_ns(), kind, source, payload)
            for output in outputs:
                if output.kind == "safe_chunk":
                    self._safe.put_bytes(output.payload)
                elif output.kind == "lease":
                    self.last_lease_ns = time.monotonic_ns()
                    self._lease.put_bytes(output.payload)
        return outputs


def _ready_status(bus: Bus, keys: Keys) -> HalStatus:
    """The HAL's status once it has begun to tick: no gate arms before."""
    heard: Queue[bytes] = Queue()
    listening = bus.subscribe(keys.hal_status, lambda sample: heard.put(sample.payload))
    heard.put(bus.query(keys.hal_status, StatusQuery(), READY_TIMEOUT_S))
    while (status := decode(HalStatus, heard.get(timeout=READY_TIMEOUT_S))).state != "ready":
        pass
    listening.undeclare()
    return status
