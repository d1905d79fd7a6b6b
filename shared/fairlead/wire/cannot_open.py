"""Why a Zenoh session could not be opened, and what to do about it."""

from __future__ import annotations

from collections.abc import Sequence

from fairlead.errors import TransportError


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
    if "Address already in use" in str(error):
        return TransportError(
            f"{', '.join(listen)}: the port is in use by another process; see which: fairlead ps"
        )
    return TransportError(
        f"zenoh session: cannot open with listen={list(listen)} connect={list(connect)}: {error}; "
        "is another process of this robot still running? see: fairlead ps"
    )
