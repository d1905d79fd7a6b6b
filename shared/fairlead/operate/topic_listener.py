"""Looking on: what is published on a robot's keys while one listens."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from fairlead.deploy.deployment import Deployment
from fairlead.errors import NoAnswerError
from fairlead.wire.bus import Bus, Sample
from fairlead.wire.session import ZenohBus

ALIVE_TIMEOUT_S = 3.0


@dataclass(frozen=True)
class Heard:
    """One publication; ``at_s`` on this process's monotonic clock."""

    key: str
    payload: bytes
    at_s: float


@contextmanager
def listening_bus(deployment: Deployment) -> Iterator[Bus]:
    """A session with a running deployment.

    Raises:
        NoAnswerError: none of its services is there.
    """
    bus = ZenohBus(deployment.tool_endpoints())
    try:
        _wait_for_anyone(bus, deployment)
        yield bus
    finally:
        bus.close()


def _wait_for_anyone(bus: Bus, deployment: Deployment) -> None:
    seen = threading.Event()
    bus.watch_tokens(deployment.keys.every_alive, lambda key, alive: seen.set() if alive else None)
    if not seen.wait(ALIVE_TIMEOUT_S):
        raise NoAnswerError(
            f"robot {deployment.id}: no service seen within {ALIVE_TIMEOUT_S:g} s; is it "
            "running? see: fairlead ps; start with: fairlead up DEPLOYMENT"
        )


class TopicListener:
    """Everything published on some keys since it was made, in order of arrival."""

    def __init__(self, bus: Bus, key_exprs: Iterable[str]) -> None:
        self._heard: queue.SimpleQueue[Heard] = queue.SimpleQueue()
        for key_expr in key_exprs:
            bus.subscribe(key_expr, self._on_sample)

    def _on_sample(self, sample: Sample) -> None:
        self._heard.put(Heard(sample.key, sample.payload, time.monotonic()))

    def next(self, timeout_s: float) -> Heard | None:
        """The next publication, None if there is none within ``timeout_s``."""
        try:
            return self._heard.get(timeout=max(timeout_s, 0.0))
        except queue.Empty:
            return None

    def for_seconds(self, duration_s: float) -> list[Heard]:
        """Everything heard in the next ``duration_s``."""
        deadline = time.monotonic() + duration_s
        heard = []
        while (one := self.next(deadline - time.monotonic())) is not None:
            heard.append(one)
            if one.at_s > deadline:
                break
        return heard
