"""Messages that a subscriber cannot read: dropped, and said once a key."""

from __future__ import annotations

import logging

from fairlead.errors import MessageError
from fairlead.wire.bus import Sample, SampleHandler
from fairlead.wire.printable import printable

_LOG = logging.getLogger("bus")
MOST_KEYS = 64
"""Of one subscriber: whoever sends junk may make up keys."""


def dropping(handler: SampleHandler) -> SampleHandler:
    """``handler``, but a `MessageError` that it raises ends in the log."""
    said: set[str] = set()

    def take(sample: Sample) -> None:
        try:
            handler(sample)
        except MessageError as error:
            if sample.key not in said and len(said) < MOST_KEYS:
                said.add(sample.key)
                _LOG.warning("%s: dropped: %s", printable(sample.key), printable(str(error)))

    return take
