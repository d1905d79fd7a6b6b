"""Two ends of one bus that know all that each has declared."""

from __future__ import annotations

import socket
import threading
from dataclasses import dataclass

from fairlead.wire.bus import Bus

DEADLINE_S = 20.0


def free_endpoint() -> str:
    """A loopback endpoint that nobody listens on now."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return f"tcp/127.0.0.1:{probe.getsockname()[1]}"


@dataclass
class Pair:
    """Two ends of one bus; on the in-memory transport both are the same object."""

    near: Bus
    far: Bus
    _syncs: int = 0

    def settle(self) -> None:
        """Return when all that ``near`` declared so far is known to ``far``, and vice versa.

        Declarations travel in order on one link, so a token declared last arrives last.
        """
        for here, there in ((self.near, self.far), (self.far, self.near)):
            self._syncs += 1
            arrived = threading.Event()
            key = f"sync/{self._syncs}"
            watch = there.watch_tokens(key, lambda _key, _alive, event=arrived: event.set())  # type: ignore[misc]
            token = here.declare_token(key)
            assert arrived.wait(DEADLINE_S)
            watch.undeclare()
            token.undeclare()
