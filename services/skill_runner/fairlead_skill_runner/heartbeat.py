"""The claim's heartbeat, from a thread of its own: nothing else may delay it."""

from __future__ import annotations

import threading

from fairlead.messages import Heartbeat
from fairlead.wire.bus import Publisher

INTERVAL_S = 0.05


class HeartbeatThread:
    """Publishes a heartbeat every 50 ms while there is a claim."""

    def __init__(self, publisher: Publisher) -> None:
        self._publisher = publisher
        self._claim_id = 0
        self._stopping = threading.Event()
        self._thread = threading.Thread(target=self._run, name="heartbeat", daemon=True)
        self._thread.start()

    def keep(self, claim_id: int) -> None:
        """Beat for this claim from now on; 0: for none."""
        self._claim_id = claim_id
        if claim_id:
            self._publisher.put(Heartbeat(claim_id=claim_id))

    def close(self) -> None:
        """Beat no more; the gate ends a claim that is still held."""
        self._stopping.set()
        self._thread.join()

    def _run(self) -> None:
        while not self._stopping.wait(INTERVAL_S):
            claim_id = self._claim_id
            if claim_id:
                self._publisher.put(Heartbeat(claim_id=claim_id))
