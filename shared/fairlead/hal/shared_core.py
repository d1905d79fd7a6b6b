"""The HAL's core for several threads: the tick thread decides, the transport's threads fill it."""

from __future__ import annotations

from collections.abc import Callable
from threading import Condition
from typing import TypeVar

from fairlead.hal.core import HalCore, TickPlan, Wait

T = TypeVar("T")


class SharedCore:
    """A `HalCore` behind a lock that is taken here and nowhere else.

    What is passed in runs under the lock: it is short, waits for nothing, and uses no
    `SharedCore`.
    """

    def __init__(self, core: HalCore) -> None:
        self._core = core
        self._changed = Condition()

    def read(self, question: Callable[[HalCore], T]) -> T:
        """What the core says."""
        with self._changed:
            return question(self._core)

    def change(self, step: Callable[[HalCore], T]) -> T:
        """Tell the core something; who waits in `decide` looks again."""
        with self._changed:
            try:
                return step(self._core)
            finally:
                self._changed.notify_all()

    def decide(self, step: Callable[[HalCore], TickPlan | Wait], wait_s: float) -> TickPlan | Wait:
        """A decision; after `Wait` it returns once something has changed, or ``wait_s`` is over."""
        with self._changed:
            decided = step(self._core)
            if isinstance(decided, Wait):
                self._changed.wait(wait_s)
            return decided
