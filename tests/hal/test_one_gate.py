"""Which released rows one gate cannot have sent."""

from __future__ import annotations

import pytest

from fairlead.hal.claims import ClaimTable, decode_released
from fairlead.hal.lease_follower import LeaseFollower, OneGate
from fairlead.messages import SafeChunk
from tests.hal.gate_messages import CLAIM, EPOCH, N_DOF, PARTS, SESSION, chunk, lease


@pytest.fixture
def gate() -> OneGate:
    """Followed through the end of an epoch at tick 6; rows of verdict 20, judged at tick 9."""
    leases, claims = LeaseFollower(SESSION), ClaimTable()
    for one in (lease(5, 4, epoch=EPOCH - 1), lease(1, 6)):
        leases.offer(one, now_ns=0)
    gate = OneGate(SESSION, leases, claims)
    first = chunk(20, first_tick=10)
    assert not gate.cannot_send(first)
    claims.store(decode_released(first, PARTS, N_DOF), {CLAIM})
    return gate


@pytest.mark.parametrize(
    ("sent", "is_forged"),
    [
        (chunk(20, first_tick=10), False),  # once more
        (chunk(20, first_tick=10, horizon=5), True),
        (chunk(21, first_tick=10), False),
        (chunk(21, first_tick=9), True),  # a later verdict by an earlier tick
        (chunk(19, first_tick=10), False),  # late
        (chunk(19, first_tick=11), True),
        (chunk(21, first_tick=12, session=SESSION + 1), True),
        (chunk(21, first_tick=12, epoch=EPOCH + 1), True),  # of a claim that has another
        (chunk(21, first_tick=12, epoch=EPOCH + 1, claim=CLAIM + 1), False),  # its lease is late
        (chunk(8, first_tick=7, epoch=EPOCH - 1, claim=CLAIM + 1), False),
        (chunk(8, first_tick=8, epoch=EPOCH - 1, claim=CLAIM + 1), True),
    ],
)
def test_rows_contradict_what_came_before_or_may_be_late(
    gate: OneGate, sent: SafeChunk, is_forged: bool
) -> None:
    assert gate.cannot_send(sent) is is_forged


def test_before_the_first_lease_nothing_is_known_of_any_gate() -> None:
    gate = OneGate(SESSION, LeaseFollower(SESSION), ClaimTable())
    assert not gate.cannot_send(chunk(20, first_tick=1, session=SESSION + 1))


def test_verdicts_of_a_new_epoch_may_count_from_anywhere() -> None:
    leases = LeaseFollower(SESSION)
    leases.offer(lease(1, 6), now_ns=0)
    gate = OneGate(SESSION, leases, ClaimTable())
    assert not gate.cannot_send(chunk(20, first_tick=10))
    leases.offer(lease(1, 12, epoch=EPOCH + 1), now_ns=0)
    assert not gate.cannot_send(chunk(3, first_tick=13, epoch=EPOCH + 1))
