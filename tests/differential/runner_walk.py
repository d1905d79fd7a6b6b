"""A runner that goes wrong at random, against the real core and the reference at once."""

from __future__ import annotations

from collections import Counter

import msgspec
import numpy as np

from bench.equipment.case import Case, Chunk, Measured, Pacing, PartRows, still
from bench.equipment.core_gate import SESSION, SOURCE, CoreGate, CoreReply
from fairlead.messages import ActionChunk, Verdict, encode
from tests.differential.fault import Fault
from tests.differential.plain_mobile import COMPOSITE, COMPOSITE_PART, REST
from tests.differential.protocol import Protocol, Reply
from tests.differential.reference import open_tick

FIRST_TICK = 100
NOTHING = Fault(0, -1, "", "")
SOUND = ("session", "hash", "epoch", "claim", "source", "key", "seq", "obs", "oldest", "start")
SPOILED_SHARE = 0.5
NEXT = "next"
NOT_A_FRAME = b"\xc1"


class RunnerWalk:
    """One run: states, good chunks, spoiled ones, copies, claims given back or handed over."""

    def __init__(self, core: CoreGate, pacing: Pacing, seed: int) -> None:
        self._core = core
        self._rng = np.random.default_rng(seed)
        self._pacing: Pacing = pacing
        self._tick = FIRST_TICK
        self._sent: list[tuple[str, bytes, ActionChunk]] = []
        self._verdicts: list[Verdict] = []
        self._old_claims = [1]
        self._old_epochs = [1]
        self.log: list[str] = []
        self.codes: Counter[int] = Counter()
        self._far_share = float(self._rng.choice([0.0, 0.0, 0.3]))
        self.reference = self._begin()

    def run(self, moves: int) -> str:
        """Up to so many moves; the first disagreement in words, or nothing."""
        for _ in range(moves):
            if self.reference.waiting is not None and self._rng.random() < 0.7:
                found = self._state()
            else:
                found = self._move()
            if found:
                return found
            if self._core.has_stopped:
                break
        return ""

    def _begin(self) -> Protocol:
        self._core.start(self._pacing, self._measured())
        file = self._core.file
        reference = Protocol(
            pacing=self._pacing,
            tick=self._tick,
            session=SESSION,
            robot_hash=bytes.fromhex(file["robot_hash"]),
            source=SOURCE,
            age_max_ticks=file["protocol"]["age_max_ticks"],
            chunk_rate_hz=file["protocol"]["chunk_rate_max_hz"],
            period_s=file["period_ns"] / 1e9,
        )
        claim = self._core.claim(self._case())
        reference.on_claim(claim.epoch, claim.claim_id)
        return reference

    def _measured(self) -> Measured:
        return still(self._tick, REST)

    def _case(self) -> Case:
        return Case("panda_mobile", self._pacing, self._measured(), Chunk(self._tick, 1, ()))

    def _move(self) -> str:
        kinds = ["state", "chunk", "copy", "frame", "claim", "arm", "hand over"]
        kind = str(self._rng.choice(kinds, p=[0.3, 0.43, 0.12, 0.06, 0.04, 0.02, 0.03]))
        if self._rng.random() < self._far_share:
            key, _, chunk = self._chunk()
            chunk = msgspec.structs.replace(chunk, obs_tick=self._tick + 2)
            return self._send(key, encode(chunk), chunk)
        if kind == "state":
            return self._state()
        if kind == "frame":
            return self._no_frame(cites_claim=bool(self._rng.random() < 0.7))
        if kind == "hand over" and self.reference.claim_id:
            return self._hand_over()
        if kind in ("claim", "arm", "hand over"):
            return self._claim_again(with_arming=kind == "arm")
        if kind == "copy" and self._sent:
            back = min(len(self._sent), int(self._rng.choice([1, 1, 1, 2, 3])))
            return self._send(*self._sent[-back])
        return self._send(*self._chunk())

    def _no_frame(self, *, cites_claim: bool) -> str:
        """Bytes that are no chunk, or begin as one of the claim does."""
        self.log.append(f"at {self._tick}, no frame, cites the claim: {cites_claim}")
        rows = PartRows(COMPOSITE_PART, COMPOSITE, np.zeros((1, 1)))
        source = self.reference.source
        own = encode(self._core.message(Chunk(self._tick, 1, (rows,)), self._tick, source))
        expected = self.reference.on_bad_frame(cites_claim=cites_claim)
        return self._compare(
            expected, self._core.send_bytes(own[:-1] if cites_claim else NOT_A_FRAME, source)
        )

    def _state(self) -> str:
        self._tick += 1
        self.log.append(f"state {self._tick}")
        waiting = self.reference.waiting
        expected = self.reference.on_state(self._tick)
        got = self._core.state_reply(self._measured())
        if waiting is None or expected is None:
            return ""
        found = [verdict for verdict in got.verdicts if verdict.seq == waiting[1].seq]
        return self._compare(expected, CoreReply(found[-1:], got.stopped))

    def _claim_again(self, with_arming: bool) -> str:
        """Give the claim back, or disarm and arm, and claim anew."""
        self._old_claims.append(self.reference.claim_id)
        self._old_epochs.append(self.reference.epoch)
        if with_arming:
            self._core.arm_again()
        elif self.reference.claim_id:
            self._core.release(self.reference.source)
        claim = self._core.claim(self._case(), self.reference.source)
        self.reference.on_claim(claim.epoch, claim.claim_id)
        self.log.append("armed again" if with_arming else "claimed again")
        return ""

    def _hand_over(self) -> str:
        """To one of two sources."""
        former, source = self.reference.source, str(self._rng.choice([SOURCE, NEXT]))
        self._core.release(former, offered_to=source)
        claim = self._core.claim(self._case(), source)
        self.log.append(f"handed over to {source}")
        if claim.claim_id != self.reference.claim_id:
            return self._told(f"reference {self.reference.claim_id:x}, gate {claim.claim_id:x}")
        self.reference.on_hand_over(source)
        return ""

    def _chunk(self) -> tuple[str, bytes, ActionChunk]:
        """The next good chunk, or one of which one or two fields are not."""
        reference = self.reference
        start = open_tick(self._pacing, self._tick)
        rows = PartRows(COMPOSITE_PART, COMPOSITE, np.zeros((2, 1)))
        key = reference.source
        chunk = self._core.message(Chunk(start, 2, (rows,)), self._tick, key)
        chunk = msgspec.structs.replace(
            chunk, seq=reference.seq + 1, goal_id=int(self._rng.integers(1, 2**40))
        )
        if self._rng.random() < SPOILED_SHARE:
            for name in self._rng.choice(SOUND, size=int(self._rng.integers(1, 3)), replace=False):
                key, chunk = self._spoiled(str(name), key, chunk)
        return key, encode(chunk), chunk

    def _spoiled(self, name: str, key: str, chunk: ActionChunk) -> tuple[str, ActionChunk]:
        seq, tick, start = self.reference.seq, self._tick, chunk.start_tick
        sequences = [0, max(0, seq - 1), seq, seq + 1000, seq + 1001, 2**64 - 1]
        observed = [tick + 1, tick + 1, tick + 2, tick + 50, tick - 3, 2**63]
        if name == "key":
            return "other", chunk
        fields: dict[str, object] = {
            "session": {"session": SESSION + 1},
            "hash": {"robot_hash": bytes(32)},
            "epoch": {"epoch": self._pick([0, *self._old_epochs])},
            "claim": {"claim_id": self._pick([0, *self._old_claims])},
            "source": {"source": "other"},
            "seq": {"seq": self._pick(sequences)},
            "obs": {"obs_tick": self._pick(observed)},
            "oldest": {"oldest_tick": self._pick([tick - 10, tick - 11, tick + 1, tick - 1, 0])},
            "start": {"start_tick": self._pick([start - 1, start + 1, start + 2, 2**64 - 1])},
        }[name]  # type: ignore[assignment]
        return key, msgspec.structs.replace(chunk, **fields)

    def _pick(self, values: list[int]) -> int:
        return values[int(self._rng.integers(len(values)))]

    def _send(self, key: str, frame: bytes, chunk: ActionChunk) -> str:
        self.log.append(
            f"at {self._tick}, key {key}: session {chunk.session:x} epoch {chunk.epoch:x} claim "
            f"{chunk.claim_id:x} source {chunk.source} seq {chunk.seq} obs {chunk.obs_tick} "
            f"oldest {chunk.oldest_tick} start {chunk.start_tick}"
        )
        self._sent.append((key, frame, chunk))
        expected = self.reference.on_candidate(key, frame, chunk)
        return self._compare(expected, self._core.send_bytes(frame, key))

    def _compare(self, expected: Reply, got: CoreReply) -> str:
        """In words how they differ, with all that led there."""
        if len(got.verdicts) != int(expected.verdict):
            return self._told(f"reference {expected}, gate {got.verdicts}")
        if not expected.verdict:
            return ""
        (verdict,) = got.verdicts
        if expected.copy_of:
            same = msgspec.structs.replace(verdict, latency_ns=0)
            first = msgspec.structs.replace(self._verdicts[expected.copy_of - 1], latency_ns=0)
            return "" if same == first else self._told(f"copy: first {first}, then {same}")
        self._verdicts.append(verdict)
        fault = expected.fault or NOTHING
        self.codes[fault.code] += 1
        wanted = (fault.code, fault.axis, float(fault.value), float(fault.limit))
        found = (verdict.code, verdict.axis, verdict.value, verdict.limit)
        is_named = verdict.claim_id != 0
        if (wanted, expected.names_claim, expected.stops) == (found, is_named, got.stopped):
            return ""
        return self._told(
            f"reference {wanted}, claim named: {expected.names_claim}, stop: {expected.stops}; "
            f"gate {found}, claim named: {is_named}, stop: {got.stopped}"
        )

    def _told(self, difference: str) -> str:
        return "\n  ".join([difference, *self.log[-30:]])
