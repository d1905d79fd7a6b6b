"""Messages that a subscriber cannot read: dropped, and said once a key and hour."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable

from fairlead.errors import MessageError
from fairlead.wire.bus import Sample, SampleHandler
from fairlead.wire.printable import printable

_LOG = logging.getLogger("bus")
MOST_KEYS = 64
"""Of one subscriber: whoever sends junk may make up keys."""
REPEAT_NS = 3600 * 10**9


def dropping(handler: SampleHandler, clock: Callable[[], int] = time.monotonic_ns) -> SampleHandler:
    """``handler``, but a `MessageError` that it raises ends in the log.

    Args:
        clock: monotonic nanoseconds.
    """
    said: set[str] = set()
    began_ns = clock()

    def take(sample: Sample) -> None:
        nonlocal began_ns
        try:
            handler(sample)
        except MessageError as error:
            if clock() - began_ns >= REPEAT_NS:
                said.clear()
                began_ns = clock()
            if sample.key not in said and len(said) < MOST_KEYS:
                said.add(sample.key)
                _LOG.warning("%s: dropped: %s", printable(sample.key), printable(str(error)))

    return take
