"""Floods of candidates: what cites no live claim, and copies, take nobody's turn."""

from __future__ import annotations

from pathlib import Path

import pytest

from bench.equipment.gate_scene import SOURCE, Scene
from bench.equipment.mailbox import Mailbox
from fairlead.messages import Outcome, Verdict, encode
from fairlead.wire.bus import Qos
from fairlead.wire.endpoints import Endpoints
from fairlead.wire.session import ZenohBus

pytestmark = pytest.mark.processes

FLOOD = 3000
JUNK_BYTES = 20_000


def folder_bytes(folder: Path) -> int:
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file())


def flood(scene: Scene, payload: bytes, source: str = SOURCE) -> Mailbox[Verdict]:
    """As a stranger, on a session of its own. Returns all verdicts told to the source."""
    told = Mailbox(scene.bus, scene.keys.verdict(source), Verdict)
    bus = ZenohBus(Endpoints(connect=[f"tcp/127.0.0.1:{scene.gate.port}"]))
    stranger = bus.publisher(scene.keys.candidate(source), Verdict, Qos.STATUS)
    for _ in range(FLOOD):
        stranger.put_bytes(payload)
    scene.gate.wait_line("candidates left out unread")
    bus.close()
    return told


def test_junk_on_a_claims_key_neither_ends_the_claim_nor_fills_the_log(scene: Scene) -> None:
    scene.ready_to_move()
    told = flood(scene, bytes(JUNK_BYTES))
    assert scene.send(scene.chunk()).outcome == Outcome.RELEASED
    assert 0 < len([v for v in told.unread() if v.code == 1]) < 300
    assert len(scene.status().claims) == 1
    assert folder_bytes(scene.state_dir) < FLOOD * JUNK_BYTES / 10


def test_copies_of_a_chunk_are_answered_a_few_times_only(scene: Scene) -> None:
    scene.ready_to_move()
    chunk = scene.chunk()
    scene.send(chunk)
    told = flood(scene, encode(chunk))
    assert len(told.unread()) < FLOOD / 4
    scene.next_tick(scene.hal.held())
    assert scene.send(scene.chunk()).outcome == Outcome.RELEASED


def test_a_gate_serves_more_sources_than_it_remembers(scene: Scene) -> None:
    scene.meet_hal()
    scene.arm()
    for i in range(70):
        reply = scene.claim("gripper", source=f"runner-{i}")
        scene.release_of(f"runner-{i}", reply.claim_id)
    scene.take_claim()
    assert scene.send(scene.chunk()).outcome == Outcome.RELEASED
