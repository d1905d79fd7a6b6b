"""A claim held by a tool instead of a runner: taken, kept alive, given back."""

from __future__ import annotations

import threading
from collections.abc import Iterator
from contextlib import contextmanager

from fairlead.messages import Claim, ClaimReply, Heartbeat
from fairlead.operate.client import RobotClient
from fairlead.robot.manifest import RobotManifest
from fairlead.skill.manifest import SkillManifest
from fairlead.wire.bus import Qos

HEARTBEAT_S = 0.05


@contextmanager
def own_claim(
    client: RobotClient,
    source: str,
    robot: RobotManifest,
    skill: SkillManifest,
    parts: tuple[str, ...],
) -> Iterator[ClaimReply]:
    """Claim ``parts`` as ``source`` under the conditions of ``skill``, with heartbeats.

    Given back at the end, unless the gate has ended it before.

    Raises:
        RefusedError: the gate does not grant the claim.
    """
    request = Claim(
        source=source,
        skill=skill.id,
        skill_hash=skill.skill_hash,
        robot_hash=robot.robot_hash,
        period_ns=robot.tick_period_ns,
        parts=parts,
        chunk_rate_hz=skill.rate_hz,
        horizon_max=skill.horizon,
        age_max_ticks=skill.age_max_ticks,
        limits=(),
    )
    with held_claim(client, request) as reply:
        yield reply


@contextmanager
def held_claim(client: RobotClient, request: Claim) -> Iterator[ClaimReply]:
    """A claim with heartbeats, given back at the end, also by an error in the block.

    Raises:
        RefusedError: the gate does not grant the claim.
    """
    reply = client.claim(request)
    done = threading.Event()
    beating = threading.Thread(
        target=_beat, args=(client, request.source, reply.claim_id, done), daemon=True
    )
    beating.start()
    try:
        yield reply
    finally:
        if any(claim.claim_id == reply.claim_id for claim in client.gate_status().claims):
            client.release(request.source, reply.claim_id)
        done.set()
        beating.join()


def _beat(client: RobotClient, source: str, claim_id: int, done: threading.Event) -> None:
    publisher = client.bus.publisher(client.keys.heartbeat(source), Heartbeat, Qos.HOT)
    while not done.is_set():
        publisher.put(Heartbeat(claim_id=claim_id))
        done.wait(HEARTBEAT_S)
