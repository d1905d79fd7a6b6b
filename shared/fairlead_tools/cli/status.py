"""``fairlead status``: what the robot, the gate and the runners are doing."""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, NoReturn

import msgspec
import typer

from fairlead.deploy.access_warnings import access_warnings
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError, NoAnswerError
from fairlead.log_stamp import utc_stamp
from fairlead.messages import GateState, GateStatus, GoalFeedback, HalStatus, floats
from fairlead.operate.client import RobotClient
from fairlead.operate.connection import choose_file
from fairlead.robot.manifest import load_robot
from fairlead.robot.safety_profile import outside_limits
from fairlead.wire.gate_checks import CHECKS
from fairlead.wire.printable import printable
from fairlead_tools.cli.console import echo, has_cursor, hex_id, print_json
from fairlead_tools.cli.options import DeploymentOption, JsonOption, example, naming
from fairlead_tools.cli.running_deployments import entries_of, starting_services

_STATE_S = 0.5
"""A HAL that lives says its joints again within this time, though its world stands still."""
_LEAD_BACK = "rows must lead it back (G011); or the HAL has another unit or zero"


@dataclass(frozen=True)
class _Seen:
    """What there is to tell at one moment; None for one that does not answer."""

    gate: GateStatus | None
    hal: HalStatus | None
    runners: list[GoalFeedback]
    alive: list[str]
    missing: list[str]
    starting: list[str]
    access: str
    warnings: list[str]


@example("fairlead status --watch")
def status_command(
    deployment: DeploymentOption = None,
    again: Annotated[
        bool, typer.Option("--watch", "-w", help="show it again every second, until Ctrl-C")
    ] = False,
    as_json: JsonOption = False,
) -> None:
    """Show the gate's state and cause, the robot's, and who is alive; exit 1 if one is not."""
    if again and as_json:
        raise ConfigError("status: --json prints one document, so it cannot --watch")
    file = choose_file(deployment)
    with RobotClient(load_deployment(file)) as client:
        seen = _look(client, file)
        if again:
            watch(lambda: _lines(_look(client, file, patiently=False), file))
    if as_json:
        print_json(_document(seen))
    else:
        echo("\n".join(_lines(seen, file)))
    if seen.missing or seen.starting:
        raise typer.Exit(1)


def _look(client: RobotClient, file: Path, patiently: bool = True) -> _Seen:
    """Ask everybody. ``patiently``: `NoAnswerError` if after a while nobody is there."""
    services, starting = client.deployment.services, starting_services(file)
    if patiently:
        try:
            client.wait_alive(*services)
        except NoAnswerError:
            if not client.alive and not starting:
                raise
    status = client.status(timeout_s=0.0)
    starting = [name for name in starting if name not in status.alive]
    missing = [name for name in status.missing if name not in starting]
    runners, alive = list(status.runners), list(status.alive)
    access, warnings = client.deployment.access, access_warnings(client.deployment)
    warnings += [text for entry in entries_of(file) if (text := full_disk(Path(entry.state_dir)))]
    if status.hal is not None:
        warnings += outside_warnings(client)
    return _Seen(status.gate, status.hal, runners, alive, missing, starting, access, warnings)


def full_disk(folder: Path, least_bytes: int = 100_000_000) -> str:
    """A warning where a folder's disk has less left than that, "" elsewhere."""
    try:
        free = shutil.disk_usage(folder).free
    except OSError:  # it has been deleted since
        return ""
    if free >= least_bytes:
        return ""
    return f"{folder}: {free / 1e6:.0f} MB left on its disk; logs and decisions will be lost"


def outside_warnings(client: RobotClient) -> list[str]:
    """Joints measured outside their limits: another unit or zero than the robot's file has."""
    try:
        robot = load_robot(client.deployment.robot)
        profile = robot.profile(client.deployment.profile)
    except ConfigError as error:  # spoiled meanwhile: no reason to say nothing else
        return [str(error)]
    with client.joint_states() as states:
        state = states.next(_STATE_S)
    joints = (*robot.joints, *robot.passive_joints)
    if state is None or len(positions := floats(state.positions)) != len(joints):
        return []
    found = (
        outside_limits(joint, profile, float(at))
        for joint, at in zip(joints, positions, strict=True)
    )
    return [f"measured outside its limits: {one}; {_LEAD_BACK}" for one in found if one]


def _document(seen: _Seen) -> dict[str, Any]:
    return {
        "alive": seen.alive,
        "missing": seen.missing,
        "starting": seen.starting,
        "access": seen.access,
        "warnings": seen.warnings,
        "gate": seen.gate and gate_document(seen.gate),
        "hal": seen.hal and hal_document(seen.hal),
        "runners": [runner_document(one) for one in seen.runners],
    }


def _lines(seen: _Seen, file: Path) -> list[str]:
    which = naming(file)
    silent = "is starting" if seen.starting else "does not answer"
    lines = [f"gate   {silent}"] if seen.gate is None else gate_lines(seen.gate, which)
    lines.append(f"robot  the HAL {silent}" if seen.hal is None else robot_line(seen.hal))
    lines += [f"goal   {one.source}: {goal_line(one)}" for one in seen.runners]
    lines.append(f"alive  {', '.join(seen.alive) or 'none yet'}")
    lines += [f"WARNING {warning}" for warning in seen.warnings]
    if seen.starting:
        lines.append(f"starting {', '.join(seen.starting)}; ask again in a moment")
    if seen.missing:
        names = ", ".join(seen.missing)
        lines.append(f"missing {names}; see: fairlead ps, fairlead logs {seen.missing[0]}")
    return lines


def robot_line(hal: HalStatus) -> str:
    """The robot's state, pacing and tick, and what its HAL says besides."""
    detail = f" ({printable(hal.detail)})" if hal.detail else ""
    return (
        f"robot  {hal.robot}: {hal.state}, {hal.pacing} at {1e9 / hal.period_ns:g} Hz, "
        f"tick {hal.tick}, overruns {hal.overruns}" + detail
    )


def goal_line(goal: GoalFeedback) -> str:
    """A runner's newest goal in a line: none yet, how it goes, or how it ended."""
    if not goal.goal_id:
        return "none yet"
    if goal.result is None:
        return f"{goal.skill} is {goal.phase}, tick {goal.tick}"
    ended = goal.result
    detail = " ".join(ended.detail.replace("\n  try: ", "; try: ").split())
    why = f": {printable(detail)}" if detail else ""
    return f"{goal.skill} {ended.outcome} (decided by the {ended.decided_by}){why}"


def gate_lines(gate: GateStatus, which: str = "") -> list[str]:
    """The gate's state, its cause, what to do, its claims and what it counted.

    which: the option that names the deployment, where several run.
    """
    lines = [f"gate   {state_and_cause(gate)}"]
    if gate.fix:
        lines.append(f"       try: {gate.fix}{which}")
    lines += [f"       stop {hex_id(stop_id)}" for stop_id in gate.stop_ids]
    if gate.latch_id:
        lines.append(f"       latch {hex_id(gate.latch_id)}")
    for claim in gate.claims:
        lines.append(f"claim  {claim.source} runs {claim.skill} on {', '.join(claim.parts)}")
    return lines + _counted(gate)


def _counted(gate: GateStatus) -> list[str]:
    """Chunks by outcome, then each check's finds in words: chunks, and other messages too."""
    found = {name: count for name, count in gate.counters if count}
    codes = {f"G{code:03d}": check.title for code, check in CHECKS.items()}
    outcomes = [f"{name} {count}" for name, count in found.items() if name not in codes]
    lines = [f"judged {', '.join(outcomes) or 'nothing yet'}"]
    for name, what in codes.items():
        if name in found:
            lines.append(f"       {name} {found[name]} times: {what}")
    return lines


def state_and_cause(gate: GateStatus) -> str:
    """``stopped: operator`` and the like; a cause may name the state itself."""
    state = GateState(gate.state).name.lower()
    if not gate.cause or gate.cause.startswith(state):
        return gate.cause or state
    return f"{state}: {gate.cause}"


def gate_document(gate: GateStatus) -> dict[str, Any]:
    """The gate's status as JSON; ids and hashes in hex."""
    return {
        "state": GateState(gate.state).name.lower(),
        "cause": gate.cause,
        "fix": gate.fix,
        "profile": gate.profile,
        "epoch": hex_id(gate.epoch),
        "session": hex_id(gate.session),
        "latch_id": hex_id(gate.latch_id),
        "stop_ids": [hex_id(stop_id) for stop_id in gate.stop_ids],
        "claims": [
            {"source": c.source, "skill": c.skill, "parts": list(c.parts)} for c in gate.claims
        ],
        "counters": dict(gate.counters),
        "state_tick": gate.state_tick,
        "config_hash": gate.config_hash.hex(),
        "robot_hash": gate.robot_hash.hex(),
    }


def runner_document(goal: GoalFeedback) -> dict[str, Any]:
    """A runner's newest goal as JSON; ``goal_id`` is null before the first."""
    return {
        "runner": goal.source,
        "goal_id": hex_id(goal.goal_id) if goal.goal_id else None,
        "skill": goal.skill,
        "phase": goal.phase,
        "tick": goal.tick,
        "result": goal.result and msgspec.structs.asdict(goal.result),
    }


def hal_document(hal: HalStatus) -> dict[str, Any]:
    """The HAL's status as JSON; ids and hashes in hex."""
    return {
        "robot": hal.robot,
        "state": hal.state,
        "detail": hal.detail,
        "pacing": hal.pacing,
        "period_ms": hal.period_ns / 1e6,
        "tick": hal.tick,
        "episode_tick": hal.episode_tick,
        "session": hex_id(hal.session),
        "robot_hash": hal.robot_hash.hex(),
        "joints": list(hal.joints),
        "parts": [part.name for part in hal.parts],
        "simulator_order": list(hal.simulator_order),
        "cameras": [camera.name for camera in hal.cameras],
        "overruns": hal.overruns,
    }


AGAIN_S = 1.0
_CLEAR = "\x1b[H\x1b[J"  # to the top left corner; nothing below


def watch(look: Callable[[], list[str]]) -> NoReturn:
    """Print the lines that ``look`` finds, every second until Ctrl-C, each time with the time."""
    while True:
        lines = look()
        if has_cursor(sys.stdout):
            sys.stdout.write(_CLEAR)
        echo("\n".join([utc_stamp(time.time()), *lines]))
        time.sleep(AGAIN_S)
