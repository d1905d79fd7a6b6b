"""What the gate says in one step leaves in one piece: one Zenoh batch."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from fairlead.messages import Verdict
from fairlead.wire.session import Endpoints, ZenohBus
from tests.faults.proxy import Delivery, FaultProxy, forward
from tests.gate.mailbox import Mailbox
from tests.gate.scene import SOURCE, Scene

CHUNKS = 40
SAID = [b"fairlead.SafeChunk", b"fairlead.Lease", b"fairlead.Verdict"]
"""Encodings that stand in every message, in the order in which they are sent."""


def _answers(verdict: Verdict) -> Callable[[Verdict], bool]:
    return lambda heard: heard.seq == verdict.seq


def test_safe_chunk_lease_and_verdict_share_a_batch(scene: Scene) -> None:
    batches: list[bytes] = []

    def keep(batch: bytes) -> Sequence[Delivery]:
        batches.append(batch)
        return forward(batch)

    with FaultProxy(scene.gate.port) as proxy:
        proxy.set("down", keep)
        bus = ZenohBus(Endpoints(connect=[f"tcp/127.0.0.1:{proxy.port}"]))
        try:
            for key in (scene.keys.safe(SOURCE), scene.keys.lease):
                bus.subscribe(key, lambda sample: None)
            verdicts = Mailbox(bus, scene.keys.verdict(SOURCE), Verdict)
            scene.ready_to_move()
            for _ in range(CHUNKS):
                verdict = scene.send(scene.chunk())
                verdicts.wait_for(_answers(verdict))
                scene.acted_on(verdict, 0)
        finally:
            bus.close()
    # A sender that is awake may take the first one before the next is there: not every time.
    places = [[batch.find(name) for name in SAID] for batch in batches]
    whole = [place for place in places if min(place) >= 0]
    assert len(whole) >= CHUNKS // 4, places
    assert all(place == sorted(place) for place in whole)
