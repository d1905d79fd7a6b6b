"""What fails on the bus, in words: sessions that do not open, refusals, unreadable messages."""

from __future__ import annotations

import logging
import re
import time
from collections.abc import Callable, Sequence

from fairlead.errors import FairleadError, MessageError, NoAnswerError, RefusedError, TransportError
from fairlead.messages import Refusal, decode
from fairlead.wire.bus import Sample, SampleHandler, no_answer
from fairlead.wire.printable import printable, printable_lines


def no_router(connect: Sequence[str], host: str, patience_s: float) -> TransportError:
    """The error of a client.

    Args:
        connect: its router's endpoints.
        host: where that runs, "" if unknown.
        patience_s: how long it was looked for.
    """
    where = f" on host {host}" if host else ""
    certified = any(one.startswith("tls/") for one in connect)
    also = (
        "; do the certificates fit? compare here and there: fairlead certs show"
        if certified
        else ""
    )
    return TransportError(
        f"router {', '.join(connect)}: not reached within {patience_s:g} s; "
        f"does it run{where}, and is the network up? there: fairlead up or fairlead router{also}"
    )


def no_session(listen: Sequence[str], connect: Sequence[str], error: Exception) -> TransportError:
    """The error of a peer or a router, from Zenoh's own."""
    if "Address already in use" in str(error) or "Unable to acquire lock: EAGAIN" in str(error):
        return TransportError(
            f"{', '.join(listen)}: in use by another process; see which: fairlead ps"
        )
    return TransportError(
        f"zenoh session: cannot open with listen={list(listen)} connect={list(connect)}: {error}; "
        "is another process of this robot still running? see: fairlead ps"
    )


_QUERY_LOG = logging.getLogger("query")
_TIMED_OUT = b"Timeout"
"""Zenoh's own reply to a query that somebody took and did not answer in time."""


def refusal_of(who: str, error: Exception) -> Refusal:
    """The refusal that says what went wrong; a bug is answered too, and its traceback logged."""
    if isinstance(error, RefusedError):
        return Refusal(who=who, reason=error.reason, fix=error.fix)
    if isinstance(error, FairleadError):
        return Refusal(who=who, reason=str(error), fix="")
    _QUERY_LOG.error("%s: a query failed", who, exc_info=error)
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


_BUS_LOG = logging.getLogger("bus")
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
                _BUS_LOG.warning("%s: dropped: %s", printable(sample.key), printable(str(error)))

    return take
