"""Keeps what a robot's services say during one run. It only listens."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from typing import TypeVar

from fairlead.keys import Keys
from fairlead.messages import (
    ActionChunk,
    Image,
    JointState,
    Lease,
    Message,
    Outcome,
    SafeChunk,
    TransformBatch,
    Verdict,
    decode,
)
from fairlead.wire.bus import Bus, Sample, Undeclare

M = TypeVar("M", bound=Message)


@dataclass
class Recording:
    """Everything heard, in order of arrival.

    candidate_bytes: the chunks exactly as they were sent, beside ``candidates``.
    verdict_ticks: the newest measured tick when each verdict arrived.
    """

    joints: list[JointState] = field(default_factory=list)
    candidates: list[ActionChunk] = field(default_factory=list)
    candidate_bytes: list[bytes] = field(default_factory=list)
    safes: list[SafeChunk] = field(default_factory=list)
    verdicts: list[Verdict] = field(default_factory=list)
    verdict_ticks: list[int] = field(default_factory=list)
    transforms: list[TransformBatch] = field(default_factory=list)
    images: list[Image] = field(default_factory=list)
    leases: int = 0

    @property
    def newest_tick(self) -> int:
        """The newest tick recorded, 0 before the first."""
        return self.joints[-1].tick if self.joints else 0


def first_outcomes(recording: Recording, source: str) -> dict[tuple[int, int], str]:
    """Outcome of each chunk of ``source``, by claim and sequence number.

    A copy sent again is answered again; the first verdict is the one that counts. Chunks that
    cited no live claim of the source (claim 0: replays, strangers) are not its own.
    """
    return {
        (claim_id, seq): Outcome(verdict.outcome).name.lower()
        for (whose, claim_id, seq), (_, verdict) in first_verdicts(recording).items()
        if whose == source and claim_id
    }


def first_verdicts(recording: Recording) -> dict[tuple[str, int, int], tuple[int, Verdict]]:
    """The first verdict of each chunk and its tick, by source, claim and sequence number."""
    first: dict[tuple[str, int, int], tuple[int, Verdict]] = {}
    for tick, verdict in zip(recording.verdict_ticks, recording.verdicts, strict=True):
        first.setdefault((verdict.source, verdict.claim_id, verdict.seq), (tick, verdict))
    return first


class Recorder:
    """Subscribes to a robot's hot keys and cameras until it is closed.

    Args:
        cameras: names of the cameras to record.
    """

    def __init__(self, bus: Bus, keys: Keys, cameras: Iterable[str] = ()) -> None:
        self.recording = Recording()
        self._lock = threading.Lock()
        handlers: dict[str, Callable[[Sample], None]] = {
            keys.joints: self._on_joints,
            keys.every_candidate: self._on_candidate,
            keys.every_safe: self._on_safe,
            keys.every_verdict: self._on_verdict,
            keys.every_tf: self._on_transforms,
            keys.lease: self._on_lease,
        }
        handlers |= {keys.camera(name): self._on_image for name in cameras}
        self._subscriptions: list[Undeclare] = [
            bus.subscribe(key, handler) for key, handler in handlers.items()
        ]

    def close(self) -> Recording:
        """Stop listening and hand over the recording."""
        for subscription in self._subscriptions:
            subscription.undeclare()
        return self.recording

    def _keep(self, kind: type[M], sample: Sample, into: list[M]) -> None:
        message = decode(kind, sample.payload)
        with self._lock:
            into.append(message)

    def _on_joints(self, sample: Sample) -> None:
        state = decode(JointState, sample.payload)
        with self._lock:
            # While the world waits, the HAL repeats its newest tick.
            if state.tick != self.recording.newest_tick:
                self.recording.joints.append(state)

    def _on_candidate(self, sample: Sample) -> None:
        chunk = decode(ActionChunk, sample.payload)
        with self._lock:
            self.recording.candidates.append(chunk)
            self.recording.candidate_bytes.append(sample.payload)

    def _on_safe(self, sample: Sample) -> None:
        self._keep(SafeChunk, sample, self.recording.safes)

    def _on_verdict(self, sample: Sample) -> None:
        verdict = decode(Verdict, sample.payload)
        with self._lock:
            self.recording.verdicts.append(verdict)
            self.recording.verdict_ticks.append(self.recording.newest_tick)

    def _on_transforms(self, sample: Sample) -> None:
        batch = decode(TransformBatch, sample.payload)
        with self._lock:
            if not batch.is_static:
                self.recording.transforms.append(batch)

    def _on_image(self, sample: Sample) -> None:
        self._keep(Image, sample, self.recording.images)

    def _on_lease(self, sample: Sample) -> None:
        decode(Lease, sample.payload)
        with self._lock:
            self.recording.leases += 1
