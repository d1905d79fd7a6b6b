"""A SafeChunk leaves in one piece with the lease that permits it: one Zenoh batch, sent at once."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence

import pytest
import zenoh

from bench.equipment.gate_scene import SOURCE, Scene
from bench.equipment.mailbox import Mailbox
from bench.faults.proxy import Delivery, FaultProxy, forward
from fairlead.messages import Verdict
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

pytestmark = pytest.mark.processes

CHUNKS = 40
SAID = [b"fairlead.SafeChunk", b"fairlead.Lease"]
"""Encodings that stand in every message, in the order in which they are sent."""


def _answers(verdict: Verdict) -> Callable[[Verdict], bool]:
    return lambda heard: heard.seq == verdict.seq


def _drive(scene: Scene, heard: Mailbox[Verdict]) -> None:
    scene.ready_to_move()
    for _ in range(CHUNKS):
        verdict = scene.send(scene.chunk())
        heard.wait_for(_answers(verdict))
        scene.acted_on(verdict, 0)


def test_a_safe_chunk_shares_its_batch_with_the_lease(scene: Scene) -> None:
    # As the HAL does, this session hears no verdict; one of its own says when to go on.
    batches: list[bytes] = []

    def keep(batch: bytes) -> Sequence[Delivery]:
        batches.append(batch)
        return forward(batch)

    with FaultProxy(scene.gate.port) as proxy:
        proxy.set("down", keep)
        hal = ZenohBus(Endpoints(connect=[f"tcp/127.0.0.1:{proxy.port}"]))
        runner = ZenohBus(Endpoints(connect=[f"tcp/127.0.0.1:{scene.gate.port}"]))
        try:
            for key in (scene.keys.safe(SOURCE), scene.keys.lease):
                hal.subscribe(key, lambda sample: None)
            _drive(scene, Mailbox(runner, scene.keys.verdict(SOURCE), Verdict))
        finally:
            hal.close()
            runner.close()
    # A sender that is awake may take the first one before the next is there: not every time.
    places = [[batch.find(name) for name in SAID] for batch in batches]
    whole = [place for place in places if min(place) >= 0]
    assert len(whole) >= CHUNKS // 4, places
    assert all(place == sorted(place) for place in whole)


def test_leases_and_verdicts_leave_at_once(scene: Scene) -> None:
    # A message that is not express may wait for a timer. Only a SafeChunk is none, since the lease
    # that follows it goes wherever it goes. Verdicts go elsewhere: nothing may count on them.
    express: dict[str, set[bool]] = {}
    keys = {
        "safe": scene.keys.safe(SOURCE),
        "lease": scene.keys.lease,
        "verdict": scene.keys.verdict(SOURCE),
    }

    def note(name: str) -> Callable[[zenoh.Sample], None]:
        return lambda sample: express.setdefault(name, set()).add(sample.express)

    endpoints = Endpoints(connect=[f"tcp/127.0.0.1:{scene.gate.port}"])
    runner = ZenohBus(endpoints)
    try:
        with zenoh.open(zenoh.Config.from_json5(json.dumps(endpoints.config()))) as session:
            for name, key in keys.items():
                session.declare_subscriber(key, note(name))
            _drive(scene, Mailbox(runner, keys["verdict"], Verdict))
    finally:
        runner.close()
    assert express == {"safe": {False}, "lease": {True}, "verdict": {True}}
