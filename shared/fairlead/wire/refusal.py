"""What a service answers when a query's handler raised, and what who asked makes of it."""

from __future__ import annotations

import logging
import re

from fairlead.errors import FairleadError, MessageError, NoAnswerError, RefusedError
from fairlead.messages import Refusal, decode
from fairlead.wire.bus import no_answer
from fairlead.wire.printable import printable, printable_lines

_LOG = logging.getLogger("query")
_TIMED_OUT = b"Timeout"
"""Zenoh's own reply to a query that somebody took and did not answer in time."""


def refusal_of(who: str, error: Exception) -> Refusal:
    """The refusal that says what went wrong; a bug is answered too, and its traceback logged."""
    if isinstance(error, RefusedError):
        return Refusal(who=who, reason=error.reason, fix=error.fix)
    if isinstance(error, FairleadError):
        return Refusal(who=who, reason=str(error), fix="")
    _LOG.error("%s: a query failed", who, exc_info=error)
    reason = f"internal error, {type(error).__name__}: {error}"
    return Refusal(who=who, reason=reason, fix=f"fairlead logs {who}")


def error_of(refusal: Refusal) -> RefusedError:
    """What to raise for a refusal from elsewhere; its further lines look like none of ours."""
    reason = re.sub(r"\n(?! )", "\n  ", printable_lines(refusal.reason))
    return RefusedError(printable(refusal.who), reason, printable(refusal.fix))


def error_from(key: str, payload: bytes, timeout_s: float) -> FairleadError:
    """What to raise for an error reply; one that is no `Refusal` is the transport's own."""
    try:
        return error_of(decode(Refusal, payload))
    except MessageError:
        if payload == _TIMED_OUT:
            return no_answer(key, timeout_s)
        return NoAnswerError(f"{key}: {printable(payload.decode(errors='replace'))}")
