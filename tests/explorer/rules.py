"""What must hold for every history, whatever the channel did."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from fairlead.messages import Acted, SafeChunk, floats
from tests.explorer.channel import MS
from tests.explorer.hal_actor import Tick
from tests.explorer.world import World

LEASE_LIFE_NS = 75 * MS
GRANTED_TICKS = 2
"""Beyond the newest state, in realtime at 50 ms."""


def check_history(world: World) -> None:
    """Nothing unjudged, out of order, twice, or beside what was really executed ever ran."""
    ticks = [tick.tick for tick in world.history]
    assert ticks == list(range(1, len(ticks) + 1)), "ticks out of order"
    seen: set[tuple[int, int]] = set()
    before = Acted(hold=1, verdict_id=0, row=0)
    for tick in world.history:
        if not tick.acted.hold:
            name = (tick.acted.verdict_id, tick.acted.row)
            assert name not in seen, f"row {name} ran twice"
            seen.add(name)
            _check_row(world, tick, before)
        before = tick.acted


def _check_row(world: World, tick: Tick, before: Acted) -> None:
    acted = tick.acted
    assert acted.verdict_id in world.emitted, "a row that no SafeChunk released ran"
    chunk = world.emitted[acted.verdict_id]
    assert chunk.first_tick + acted.row == tick.tick, "a row ran in another tick than its own"
    assert acted.row < chunk.horizon
    assert tick.command is not None
    np.testing.assert_array_equal(tick.command, _rows(chunk)[acted.row])
    if acted.row == 0:
        same = bool(chunk.after.hold and before.hold) or chunk.after == before
        assert same, f"tick {tick.tick} continued {before}, judged after {chunk.after}"
    else:
        assert before == Acted(hold=0, verdict_id=acted.verdict_id, row=acted.row - 1)
    replaced = _replaced_from(world, chunk)
    assert replaced is None or tick.tick <= replaced + GRANTED_TICKS, (
        f"tick {tick.tick}: verdict {chunk.verdict_id} ran on, replaced from tick {replaced}"
    )
    assert _was_proposed(world, chunk, tick), "the gate released what nobody proposed"
    assert _was_granted(world, chunk, tick), "no fresh lease granted the row"


def check_stops(world: World) -> None:
    """From a stop's arrival on, only an epoch armed afterwards moves the robot again."""
    for stop_tick, stop in world.hal.stops:
        later = [tick for tick in world.history if tick.tick >= stop_tick and not tick.acted.hold]
        before = {
            world.emitted[tick.acted.verdict_id].epoch
            for tick in world.history
            if tick.tick < stop_tick and not tick.acted.hold
        }
        for tick in later:
            assert world.emitted[tick.acted.verdict_id].epoch not in before, f"moved after {stop}"


def _was_granted(world: World, chunk: SafeChunk, tick: Tick) -> bool:
    """Some lease that grants the row arrived at most its life ago (lockstep: whenever)."""
    leases = world.hal.leases
    oldest_ns = tick.time_ns - LEASE_LIFE_NS if world.pacing == "realtime" else 0
    newest = bisect_right(leases, tick.time_ns, key=lambda entry: entry[0])
    for received_ns, lease in reversed(leases[max(0, newest - 1000) : newest]):
        if received_ns < oldest_ns:
            return False
        if lease.epoch == chunk.epoch and any(
            grant.claim_id == chunk.claim_id and grant.until_tick >= tick.tick
            for grant in lease.grants
        ):
            return True
    return False


def _replaced_from(world: World, chunk: SafeChunk) -> int | None:
    """The first tick of the claim's next release, None if there is none: it alone is certified
    anew from then on."""
    later = bisect_right(world.verdicts_of[chunk.claim_id], chunk.verdict_id)
    if later == len(world.verdicts_of[chunk.claim_id]):
        return None
    return world.emitted[world.verdicts_of[chunk.claim_id][later]].first_tick


def _was_proposed(world: World, chunk: SafeChunk, tick: Tick) -> bool:
    assert tick.command is not None
    sent_before = bisect_right(world.runner.sent, tick.tick, key=lambda sent: sent.start_tick)
    for sent in reversed(world.runner.sent[:sent_before]):
        row = tick.tick - sent.start_tick
        if (sent.epoch, sent.claim_id) == (chunk.epoch, chunk.claim_id) and 0 <= row < sent.horizon:
            values = floats(sent.parts[0].values, len(tick.command))[row]
            if np.array_equal(values, tick.command):
                return True
    return False


def _rows(chunk: SafeChunk) -> np.ndarray[tuple[int, ...], np.dtype[np.float64]]:
    return floats(chunk.parts[0].values, len(chunk.parts[0].values) // 8 // chunk.horizon)


def moves(history: list[Tick]) -> int:
    """Ticks in which a released row ran."""
    return sum(1 for tick in history if not tick.acted.hold)


def trajectory(history: list[Tick]) -> list[tuple[int, bool, bytes]]:
    """What is compared between runs: tick, held or not, and the bits of the positions."""
    return [(tick.tick, bool(tick.acted.hold), tick.positions.tobytes()) for tick in history]
