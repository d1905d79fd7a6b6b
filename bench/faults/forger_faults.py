"""Who has stolen a certificate speaks in its name beside its owner, while the robot moves.

What HAL and gate know by themselves gives the forger away: the robot holds, status and log say why.
"""

from __future__ import annotations

import dataclasses
import time
from collections.abc import Callable
from contextlib import closing
from functools import partial
from typing import TypeVar

from msgspec.structs import replace

from bench.equipment.live_robot import wait_for
from bench.equipment.mailbox import Mailbox
from bench.equipment.motion_log import TICK_MS
from bench.faults.live_stage import LiveStage
from bench.faults.row import Row, Shot
from fairlead.deploy.access import OPERATOR
from fairlead.messages import Acted, GateState, JointState, Lease, Message, SafeChunk, StopLevel
from fairlead.wire.bus import Qos
from fairlead.wire.session import ZenohBus

M = TypeVar("M", bound=Message)

BOUND_MS = 150.0
LEAD_TICKS = 3
FORGED_TICKS = 2


@dataclasses.dataclass(frozen=True)
class Forgery:
    """What the owner of a name would not say: its key and message; what HAL and gate say of it."""

    owner: str
    make: Callable[[LiveStage], tuple[str, Message]]
    hal: str
    gate: str


def newest(robot: LiveStage, key: str, kind: type[M]) -> M:
    """The next message on a key."""
    with closing(Mailbox(robot.client.bus, key, kind)) as mailbox:
        return mailbox.wait_for()


def forged_lease(robot: LiveStage) -> tuple[str, Message]:
    """Far ahead of the gate's own, and granting for ever."""
    key = robot.client.keys.lease
    lease = newest(robot, key, Lease)
    grants = tuple(replace(one, until_tick=2**40) for one in lease.grants)
    return key, replace(lease, lease_seq=lease.lease_seq + 2**40, grants=grants)


def forged_epoch(robot: LiveStage) -> tuple[str, Message]:
    """As a gate that took over would send it."""
    key = robot.client.keys.lease
    lease = newest(robot, key, Lease)
    return key, replace(lease, epoch=lease.epoch + 1, lease_seq=1)


def forged_rows(robot: LiveStage) -> tuple[str, Message]:
    """Of a later verdict than the gate's, going on from the row that acts then."""
    rows = newest(robot, robot.client.keys.every_safe, SafeChunk)
    after = Acted(hold=0, verdict_id=rows.verdict_id, row=LEAD_TICKS - 1)
    ahead = {"verdict_id": rows.verdict_id + 1000, "first_tick": rows.first_tick + LEAD_TICKS}
    return robot.client.keys.safe(rows.source), replace(rows, after=after, **ahead)


def forged_state(robot: LiveStage) -> tuple[str, Message]:
    """Of the tick that comes next."""
    key = robot.client.keys.joints
    state = newest(robot, key, JointState)
    return key, replace(state, tick=state.tick + 1, stamp_ns=state.stamp_ns + 1)


def forged_stop(robot: LiveStage) -> tuple[str, Message]:
    """By nobody known; a stop of an id that was reset once would be taken for a copy."""
    stop_id = time.monotonic_ns()
    said = StopLevel(stop_id=stop_id, by="mallory@lab (program)", reason="now")
    return robot.client.keys.stop, said


def forge(robot: LiveStage, bus: ZenohBus, forgery: Forgery) -> Shot:
    """Say it while the robot moves: it holds, and all who should say why do.

    Args:
        bus: a session in the owner's name.
    """
    robot.start_moving()
    key, message = forgery.make(robot)
    publisher = bus.publisher(key, type(message), Qos.HOT)
    injected_ns = time.monotonic_ns()
    publisher.put(message)
    shot = robot.hold_shot(injected_ns)
    gate, hal = robot.client.gate_status(), robot.client.hal_status()
    assert gate.state in (GateState.STOPPED, GateState.LATCHED), gate
    assert forgery.gate in gate.cause, gate.cause
    assert forgery.hal in hal.detail, hal.detail
    wait_for(lambda: forgery.gate in _log_of(robot, "safety"), "the gate's log has it")
    if forgery.hal.startswith("two "):
        wait_for(lambda: forgery.hal in _log_of(robot, "hal"), "the HAL's log has it")
    if isinstance(message, SafeChunk):
        lines = robot.motion.since(injected_ns)
        acted = sum(message.verdict_id in line.verdicts for line in lines)
        assert acted <= FORGED_TICKS, f"forged rows acted in {acted} ticks"
    return dataclasses.replace(shot, note=f"gate: {gate.cause}; HAL: {hal.detail or hal.state}")


def _log_of(robot: LiveStage, service: str) -> str:
    return (robot.robot.scratch.state_dir / "logs" / f"{service}.log").read_text(encoding="utf-8")


def behind_router(robot: LiveStage, forgery: Forgery) -> Shot:
    """With the certificate of the owner."""
    with closing(ZenohBus(robot.client.deployment.tool_endpoints(forgery.owner))) as bus:
        return forge(robot, bus, forgery)


def _row(fault: str, bound_ms: float, forgery: Forgery) -> Row:
    return Row(
        49, f"whoever stole {fault}", "hold; status and logs report two", bound_ms,
        "certified", partial(behind_router, forgery=forgery),
    )  # fmt: skip


ROWS = (
    _row("the gate's certificate sends a lease", BOUND_MS,
         Forgery("safety", forged_lease, "", "two gates serve this robot: lease ")),
    _row(f"the gate's certificate sends rows that begin {LEAD_TICKS} ticks later",
         BOUND_MS + (LEAD_TICKS + 1) * TICK_MS,
         Forgery("safety", forged_rows, "", "two gates")),  # the HAL may say it first
    _row("the HAL's certificate sends a state", BOUND_MS,
         Forgery("hal", forged_state, "two HALs: ", "two HALs")),
    Row(49, "whoever stole an operator's certificate sends a stop in another's name",
        "stops, under the name that it gives", BOUND_MS, "certified",
        partial(behind_router, forgery=Forgery(
            OPERATOR, forged_stop, "(now)", "stopped: by mallory@lab (program): now"))),
)  # fmt: skip
