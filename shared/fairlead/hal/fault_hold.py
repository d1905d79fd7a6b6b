"""After a backend fault: the hold is still commanded, every period, whatever the driver says."""

from __future__ import annotations

import logging

from fairlead.hal.backend import Backend

_LOG = logging.getLogger("hal.fault")


class FaultHold:
    """Commands every part's hold law to a backend that has failed.

    A driver that raised once (a bus that recovered) may well carry out a hold, and the
    robot must not be left with its last command.

    Attributes:
        commanded: holds the backend has taken.
        failed: holds the backend has refused.
    """

    def __init__(self, backend: Backend) -> None:
        self._backend = backend
        self._failing = False
        self.commanded = 0
        self.failed = 0

    @property
    def detail(self) -> str:
        """What the last attempt came to, for the status."""
        if self._failing:
            return "the hold cannot be commanded"
        return "held" if self.commanded else "hold not yet commanded"

    def command(self) -> None:
        """One attempt; never raises, and says only what changed."""
        try:
            self._backend.apply({})
        except Exception as error:  # noqa: BLE001 - a driver may raise anything; try again
            self.failed += 1
            if not self._failing:
                _LOG.error("the hold cannot be commanded: %s: %s", type(error).__name__, error)
            self._failing = True
            return
        self.commanded += 1
        if self._failing:
            _LOG.warning("the hold is commanded again, after %d failures", self.failed)
        self._failing = False
