"""What a gate would send, for a robot of two parts with two joints each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from fairlead.messages import (
    NO_HASH,
    Acted,
    ActionPart,
    Decision,
    GateState,
    Grant,
    Hold,
    Lease,
    SafeChunk,
    StopLevel,
    pack_floats,
)
from fairlead.modes import ControlMode

SESSION = 7001
EPOCH = 41
CLAIM = 501
N_DOF = 4
PARTS = 2
MS = 1_000_000
PERIOD_NS = 50 * MS
HELD = Acted(hold=Hold.NO_ROW, verdict_id=0, row=0)


def executed(verdict_id: int, row: int) -> Acted:
    return Acted(hold=0, verdict_id=verdict_id, row=row)


def chunk(
    verdict_id: int,
    first_tick: int,
    horizon: int = 4,
    *,
    after: Acted = HELD,
    parts: Sequence[int] = (0,),
    claim: int = CLAIM,
    epoch: int = EPOCH,
    session: int = SESSION,
) -> SafeChunk:
    """Rows whose composite value is their tick / 1000, so that a test sees which row ran."""
    values = np.array([[(first_tick + row) / 1000] for row in range(horizon)])
    return SafeChunk(
        session=session,
        epoch=epoch,
        claim_id=claim,
        source="runner",
        verdict_id=verdict_id,
        judged_tick=first_tick - 1,
        first_tick=first_tick,
        horizon=horizon,
        after=after,
        parts=tuple(
            ActionPart(
                part=part,
                mode=ControlMode.COMPOSITE_MODE,
                frame_id="",
                values=pack_floats(values),
                active=(),
            )
            for part in parts
        ),
    )


def grant(
    until_tick: int,
    decision: Decision = Decision.ROW,
    verdict_id: int = 0,
    claim: int = CLAIM,
) -> Grant:
    return Grant(
        source="runner",
        claim_id=claim,
        until_tick=until_tick,
        decision=decision,
        verdict_id=verdict_id,
    )


def lease(
    seq: int,
    state_tick: int,
    grants: Sequence[Grant] = (),
    *,
    epoch: int = EPOCH,
    session: int = SESSION,
    state: GateState = GateState.ARMED,
    stops: Sequence[int] = (),
) -> Lease:
    return Lease(
        session=session,
        epoch=epoch,
        lease_seq=seq,
        config_hash=NO_HASH,
        state=state,
        state_tick=state_tick,
        grants=tuple(grants),
        stop_ids=tuple(stops),
    )


def stop(stop_id: int) -> StopLevel:
    return StopLevel(stop_id=stop_id, by="operator", reason="test")
