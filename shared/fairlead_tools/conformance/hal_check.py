"""All checks of one running HAL, in an order in which each relies on those before it."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field

from fairlead.deploy.deployment import Deployment
from fairlead.errors import NoAnswerError, RefusedError
from fairlead.messages import HalStatus, StatusQuery, decode
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.wire.bus import Bus
from fairlead.wire.session import ZenohBus
from fairlead_tools.conformance import (
    gripper_and_base_checks,
    guard_checks,
    hold_checks,
    identity_checks,
    motion_checks,
    pause_check,
    tool_checks,
)
from fairlead_tools.conformance.row import GROUPS, Check, Row, SilentHalError
from fairlead_tools.conformance.stage import Stage
from fairlead_tools.conformance.stand_in_gate import StandInGate

ANSWER_S = 5.0
LISTEN_S = 1.0
"""A gate that lives says something well within."""
SPEAKS = Check(
    "the HAL goes on", "a joint state in every period", "docs/time-and-pacing.md",
    "read its log: fairlead logs hal",
)  # fmt: skip
OWN_STOPS = Check(
    "no stop of its own", "none beyond those that a check asks for",
    "shared/fairlead/hal/backend.py: apply", "its reason is in the HAL's log",
)  # fmt: skip


BASIS = {
    one.name
    for one in (
        hold_checks.DRIFT,
        guard_checks.OBEYED,
        hold_checks.ROWS_END,
        hold_checks.LEASES_END,
        hold_checks.STOP,
        motion_checks.ORDER,
        motion_checks.SIGN,
    )
}
"""A robot that fails one of these is not moved any further."""


@dataclass(frozen=True)
class CheckOptions:
    """What a person chose.

    share: of full scale. hold_s: how long a hold is watched. pid: of the HAL's process; None: not
    known, ``why_no_pid`` says why. is_simulator: full-size rows hurt nobody. only: of `GROUPS`;
    () for all.
    """

    share: float
    hold_s: float
    pid: int | None
    why_no_pid: str
    is_simulator: bool
    only: tuple[str, ...] = ()


@dataclass
class HalCheck:
    """The rows of one HAL."""

    deployment: Deployment
    hal: HalStatus
    rows: list[Row] = field(default_factory=list)

    @property
    def is_good(self) -> bool:
        """Whether no check failed."""
        return not any(row.outcome == "fail" for row in self.rows)


def ask_hal(deployment: Deployment) -> HalStatus:
    """The status of the HAL that runs, without any gate.

    Raises:
        RefusedError: a gate answers: this check has to take its place.
        NoAnswerError: no HAL answers.
        MessageError: what answers is no status.
    """
    with closing(ZenohBus(deployment.tool_endpoints())) as bus:
        try:
            asked = bus.query(deployment.keys.hal_status, StatusQuery(), ANSWER_S)
        except NoAnswerError:
            what = f"no HAL of robot {deployment.id} answers"
            start = f"fairlead up NAME --without {deployment.only('safety')}"
            raise NoAnswerError(f"{what}; start it without its gate: {start}") from None
        status = decode(HalStatus, asked)
        _refuse_gate(bus, deployment)
    return status


def _refuse_gate(bus: Bus, deployment: Deployment) -> None:
    """A gate that lives sends a lease every 25 ms, as soon as there is a link to it."""
    heard = threading.Event()
    leases = bus.subscribe(deployment.keys.lease, lambda sample: heard.set())
    alive = heard.wait(LISTEN_S)
    leases.undeclare()
    if alive:
        gate = deployment.only("safety")
        why = "a gate is alive on this robot's bus, and the check has to take its place"
        start = f"fairlead down {deployment.id}; fairlead up NAME --without {gate}"
        raise RefusedError("hal check", why, start)


def check_hal(
    bus: Bus, deployment: Deployment, hal: HalStatus, wish: CheckOptions, say: Callable[[str], None]
) -> HalCheck:
    """Make every check; the robot is left held, whatever happens.

    Args:
        hal: what `ask_hal` said.
        say: told what comes next.

    Raises:
        RefusedError: a gate comes alive meanwhile.
    """
    robot = load_robot(deployment.robot)
    found = HalCheck(deployment, hal)
    found.rows.append(identity_checks.description(robot, hal, deployment.id))
    if not found.is_good:
        found.rows.append(SPEAKS.not_checked("a HAL of another robot is not moved"))
        return found
    found.rows += identity_checks.modes_and_ranges(robot, deployment.profile, hal)
    with _gate(bus, deployment, robot, hal) as gate:
        modes = identity_checks.described_modes(robot, hal)
        stage = Stage(gate, robot, deployment, wish.share, modes)
        try:
            for row in _moving(stage, wish, say):
                found.rows.append(row)
            found.rows.append(SPEAKS.row([], f"{len(stage.states.order)} states"))
        except (SilentHalError, NoAnswerError) as error:
            stops = [f"stop by {one.by}: {one.reason}" for one in stage.gate.heard_stops.values()]
            found.rows.append(SPEAKS.row(["; ".join([str(error), *stops])], ""))
        finally:
            stage.control.close()
        found.rows += _of_all_states(stage)
    return found


@contextmanager
def _gate(
    bus: Bus, deployment: Deployment, robot: RobotManifest, hal: HalStatus
) -> Iterator[StandInGate]:
    gate = StandInGate(bus, deployment.keys, robot, deployment.profile, hal)
    try:
        yield gate
    finally:
        gate.close()


def _of_all_states(stage: Stage) -> Iterable[Row]:
    if not stage.states.order:
        return [identity_checks.STATES.row(stage.states.unfit or ["none came"], "")]
    turns = identity_checks.turns(stage.robot, stage.states.every())
    return [identity_checks.joint_states(stage), identity_checks.si_positions(stage), *turns]


def _moving(stage: Stage, wish: CheckOptions, say: Callable[[str], None]) -> Iterator[Row]:
    say("the first states")
    stage.gate.wait_tick(1)  # a world that waits repeats its tick; it may have come already
    stage.gate.arm()
    if not stage.first_modes():
        yield guard_checks.OBEYED.not_checked("no part that a hold keeps still can be moved")
        return
    say(f"a hold of {wish.hold_s:g} s, tick rate and jitter")
    drift, heard = hold_checks.drift(stage, wish.hold_s)
    control = stage.control.since(heard[0].came_ns)
    yield from identity_checks.ticking(stage, heard, control)
    yield drift
    steps = _steps(stage, wish)
    broken, own = drift if drift.outcome == "fail" else None, list[str]()
    for what, make in steps.items():
        if broken is not None:
            why = f"{broken.check}: failed, so the robot is not moved any further"
            yield Check(what, "", "", "").not_checked(why)
            continue
        if what in GROUPS and wish.only and what not in wish.only:
            yield Check(what, "", "", "").not_checked(f"asked for: {', '.join(wish.only)}")
            continue
        say(what)
        for row in make():
            yield row
            if row.outcome == "fail" and row.check in BASIS:
                broken = row
        if stage.gate.heard_stops:
            own += [stop.reason for stop in stage.gate.clear_stops()]
    if broken is not None:
        stage.gate.raise_stop(f"fairlead hal check: {broken.check}: {broken.got}")
    yield OWN_STOPS.row(own, "none")


Step = Callable[[], Iterable[Row]]


def _steps(stage: Stage, wish: CheckOptions) -> dict[str, Step]:
    """First that motion begins and ends as it has to, then what it is."""
    return {
        "released rows": lambda: [guard_checks.obeyed(stage)],
        "rows that end": lambda: [hold_checks.rows_end(stage)],
        "leases that stop": lambda: [hold_checks.leases_end(stage)],
        "a stop": lambda: hold_checks.stops(stage),
        "joints": lambda: motion_checks.joint_checks(stage),
        "grippers": lambda: gripper_and_base_checks.gripper_checks(stage),
        "tools": lambda: tool_checks.tool_checks(stage),
        "base": lambda: gripper_and_base_checks.base_checks(stage),
        "forged rows": lambda: guard_checks.forged_rows(stage),
        "forged leases": lambda: guard_checks.forged_leases(stage),
        "limits": lambda: tool_checks.limit_checks(stage, wish.is_simulator),
        "pause": lambda: [pause_check.resume(stage, wish.pid, wish.why_no_pid)],
    }
