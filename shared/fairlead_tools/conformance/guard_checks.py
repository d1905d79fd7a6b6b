"""Rows and leases that must move nothing, each good but for one thing."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import msgspec
import numpy as np

from fairlead.hal.lease_follower import LEASE_LIFE_NS
from fairlead.messages import Acted, GateState, Lease, SafeChunk, floats, pack_floats
from fairlead.modes import ControlMode
from fairlead_tools.conformance.row import Check, Row
from fairlead_tools.conformance.stage import Stage, hold_name
from fairlead_tools.conformance.stand_in_gate import FOR_EVER, SOURCE

ROWS = 3
OTHER = 0x5EED
SECOND_GATE_S = 0.4
CONTRACT = "docs/design.md: one tick"
HOST = "let the shipped host (fairlead.hal.process) decide which row acts"
OBEYED = Check(
    "released rows act", "each in its tick, and the state names it", CONTRACT,
    "apply() each row in its tick; `acted` is what was done in the tick before",
)  # fmt: skip
SECOND_GATE = Check(
    "a second gate is noticed", "a stop of the HAL's own", "docs/hosts.md: a stolen name", HOST
)


@dataclass(frozen=True)
class Forgery:
    """A chunk that only a broken gate, or none, would send.

    change: makes it of a good one. granted: to the end of its rows. past: it begins before the
    newest tick. on_key: of which source.
    """

    name: str
    change: Callable[[SafeChunk], SafeChunk] = lambda chunk: chunk
    granted: bool = True
    past: bool = False
    on_key: str = SOURCE


def obeyed(stage: Stage) -> Row:
    """The control of all that follows: the same rows, rightly released, act."""
    run = stage.execute(stage.moving_rows(ROWS))
    stage.settle()
    return OBEYED.row([] if run.acted_all else [run.story], f"{ROWS} of {ROWS} rows")


def forged_rows(stage: Stage) -> Iterator[Row]:
    """Each must be left alone, whole."""
    left = stage.gate.plan.epoch
    stage.gate.arm()
    for forgery in _forgeries(stage, left):
        yield _forged(stage, forgery)


def _forgeries(stage: Stage, left: int) -> list[Forgery]:
    part = next(iter(stage.first_modes()))
    own = stage.robot.part(part).control_modes
    other = next(
        m for m in (ControlMode.GRIPPER_BINARY, ControlMode.CARTESIAN_TWIST) if m not in own
    )
    zeros = bytes(8 * other.width(stage.robot.n_dof) * ROWS)
    return [
        Forgery("row of another session", lambda c: _with(c, session=c.session ^ OTHER)),
        Forgery("row of another epoch", lambda c: _with(c, epoch=c.epoch ^ OTHER)),
        Forgery("row of an earlier epoch", lambda c: _with(c, epoch=left)),
        Forgery("row of a claim without grant", lambda c: _with(c, claim_id=c.claim_id ^ OTHER)),
        Forgery("row beyond its grant", granted=False),
        Forgery("row of a chunk that began in the past", past=True),
        Forgery("row that continues what was not done", _continuing),
        Forgery("row on another source's key", on_key="hal_check_other"),
        Forgery("row of a wrong width", lambda c: _first(c, values=c.parts[0].values[8:])),
        Forgery("row of an unknown mode", lambda c: _first(c, mode=99)),
        Forgery(
            "row of a mode the part has not",
            lambda c: _first(c, mode=int(other), values=zeros, active=()),
        ),
        Forgery("row of a part that is not there", lambda c: _first(c, part=200)),
        Forgery("row that is not finite", _not_finite),
    ]


def _with(chunk: SafeChunk, **fields: Any) -> SafeChunk:
    return msgspec.structs.replace(chunk, **fields)


def _first(chunk: SafeChunk, **fields: Any) -> SafeChunk:
    first = msgspec.structs.replace(chunk.parts[0], **fields)
    return msgspec.structs.replace(chunk, parts=(first, *chunk.parts[1:]))


def _continuing(chunk: SafeChunk) -> SafeChunk:
    return _with(chunk, after=Acted(hold=0, verdict_id=chunk.verdict_id - 1, row=7))


def _not_finite(chunk: SafeChunk) -> SafeChunk:
    values = floats(chunk.parts[0].values).copy()
    told = list(chunk.parts[0].active) or [0]
    values[told[0]] = np.nan
    return _first(chunk, values=pack_floats(values))


def _forged(stage: Stage, forgery: Forgery) -> Row:
    check = Check(forgery.name, "nothing acts, nothing moves", CONTRACT, HOST)
    gate, states = stage.gate, stage.states
    until = FOR_EVER if forgery.granted else states.newest_tick
    gate.take_claim(until, waits=True)
    start = states.newest
    count, first = ROWS, None
    if forgery.past:
        count, first = 3 * ROWS, start.tick - 1
    rows = stage.moving_rows(count)(stage.moment(start.tick))
    sent = gate.release(rows, first, forgery.on_key, forgery.change)
    stage.reaches(sent.end + 2)
    return check.row(*_seen(stage, start.tick))


def _seen(stage: Stage, since: int) -> tuple[list[str], str]:
    """What acted or moved since a tick, and how it held; the HAL's own stops are reset."""
    gate, states = stage.gate, stage.states
    heard = states.between(since, states.newest_tick + 1)
    problems, holds = list[str](), set[str]()
    for state in heard[1:]:
        for part, acted in zip(stage.robot.part_names, state.acted, strict=True):
            if acted.hold == 0:
                problems.append(f"{part} acted in tick {state.tick - 1}")
            else:
                holds.add(hold_name(acted.hold))
    problems += stage.strayed(heard[0], heard[1:])
    own = gate.clear_stops() if gate.heard_stops else []
    text = ", ".join(sorted(holds)) or "the world waited"
    if own:
        text += f"; it stopped: {own[0].reason}"
    if problems:
        stage.settle()
    return problems, text


def forged_leases(stage: Stage) -> Iterator[Row]:
    """Good rows under a lease that grants nothing."""
    gate = stage.gate
    gate.take_claim()
    old = gate.lease()
    gate.arm()
    gate.take_claim()
    stage.reaches(stage.states.newest_tick + 1)
    shapes: list[tuple[str, Callable[[Lease], Lease | None], int]] = [
        ("no lease", lambda lease: None, 0),
        ("lease of another session", lambda one: _lease(one, session=one.session ^ OTHER), 0),
        ("lease sent before", _repeated(gate.lease()), 0),
        ("lease that was sent in an earlier epoch", lambda lease: old, old.epoch),
        ("lease of an earlier epoch", lambda one: _lease(one, epoch=old.epoch), old.epoch),
        ("lease of a gate that is not armed", lambda one: _lease(one, state=GateState.DISARMED), 0),
    ]
    for name, shape, epoch in shapes:
        yield _under(stage, name, shape, epoch)
    yield _second_gate(stage, old.epoch)


def _lease(lease: Lease, **fields: Any) -> Lease:
    return msgspec.structs.replace(lease, **fields)


def _repeated(lease: Lease) -> Callable[[Lease], Lease | None]:
    """The same lease as before, though it grants whatever is asked now."""
    return lambda now: _lease(lease, grants=now.grants, state_tick=now.state_tick)


def _under(stage: Stage, name: str, shape: Callable[[Lease], Lease | None], epoch: int) -> Row:
    """Rows after the last good lease has run out, while others come."""
    check = Check(f"rows under: {name}", "nothing acts, nothing moves", CONTRACT, HOST)
    gate, states = stage.gate, stage.states
    gate.silence()
    stage.reaches(states.newest_tick + 2 + -(-LEASE_LIFE_NS // stage.hal.period_ns))
    gate.speak(shape)
    gate.take_claim(waits=True)
    start = states.newest.tick
    rows = stage.moving_rows(ROWS)(stage.moment(start))
    sent = gate.release(rows, change=lambda one: _with(one, epoch=epoch or one.epoch))
    stage.reaches(sent.end + 2)
    gate.drop_claims()
    gate.speak()  # before a stop of the HAL's own is reset: it has to hear that
    return check.row(*_seen(stage, start))


def _second_gate(stage: Stage, left: int) -> Row:
    """New leases of an epoch that was left a while ago."""
    gate = stage.gate
    gate.pause(SECOND_GATE_S)
    gate.speak(lambda one: _lease(one, epoch=left, lease_seq=one.lease_seq + (1 << 40)))
    stage.states.wait_for(lambda: bool(gate.heard_stops), SECOND_GATE_S)
    gate.speak()
    gate.pause(SECOND_GATE_S / 2)
    own = gate.clear_stops()
    reason = own[0].reason if own else "none within 0.6 s"
    return SECOND_GATE.row([] if own else [reason], reason)
