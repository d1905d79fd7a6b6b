"""Keeps what the gate's decision log does not: pictures, and chunks byte for byte."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field

from fairlead.keys import Keys
from fairlead.messages import Image, decode
from fairlead.wire.bus import Bus, Sample, Undeclare


@dataclass
class Recording:
    """What was heard, in order of arrival. candidate_bytes: chunks as they were sent."""

    candidate_bytes: list[bytes] = field(default_factory=list)
    images: list[Image] = field(default_factory=list)


class Recorder:
    """Subscribes until it is closed. It only listens.

    Args:
        cameras: names of the cameras to record.
    """

    def __init__(self, bus: Bus, keys: Keys, cameras: Iterable[str] = ()) -> None:
        self.recording = Recording()
        handlers: dict[str, Callable[[Sample], None]] = {
            keys.every_candidate: self._on_candidate,
            **{keys.camera(name): self._on_image for name in cameras},
        }
        self._subscriptions: list[Undeclare] = [
            bus.subscribe(key, handler) for key, handler in handlers.items()
        ]

    def close(self) -> Recording:
        """Stop listening and hand over the recording."""
        for subscription in self._subscriptions:
            subscription.undeclare()
        return self.recording

    def _on_candidate(self, sample: Sample) -> None:
        self.recording.candidate_bytes.append(sample.payload)

    def _on_image(self, sample: Sample) -> None:
        self.recording.images.append(decode(Image, sample.payload))
