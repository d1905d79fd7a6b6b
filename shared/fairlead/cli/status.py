"""``fairlead status``: what the robot, its gate and its services are doing."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import msgspec
import typer

from fairlead.cli.console import echo, hex_id, print_json
from fairlead.cli.deployment_choice import DeploymentOption, JsonOption, choose_file
from fairlead.cli.starting import starting_services
from fairlead.deploy.deployment import load_deployment
from fairlead.errors import NoAnswerError
from fairlead.messages import GateState, GateStatus, GoalFeedback, HalStatus
from fairlead.operate.client import RobotClient
from fairlead.wire.printable import printable
from fairlead.wire.verdict_text import CHECKS

EXAMPLE = "fairlead status --json"


def command(deployment: DeploymentOption = None, as_json: JsonOption = False) -> None:
    """Show the gate's state and cause, the robot's, and who is alive; exit 1 if one is not."""
    file = choose_file(deployment)
    chosen = load_deployment(file)
    starting = starting_services(file)
    with RobotClient(chosen) as client:
        try:
            client.wait_alive(*chosen.services)
        except NoAnswerError:
            if not client.alive and not starting:
                raise
        gate, hal = _answers(client)
        runners = _runners(client)
        alive = sorted(client.alive)
    starting = [name for name in starting if name not in alive]
    missing = sorted(set(chosen.services) - set(alive) - set(starting))
    if as_json:
        print_json(
            {
                "alive": alive,
                "missing": missing,
                "starting": starting,
                "gate": gate and gate_document(gate),
                "hal": hal and hal_document(hal),
                "runners": [runner_document(one) for one in runners],
            }
        )
    else:
        _print(gate, hal, runners, alive, missing, starting)
    if missing or starting:
        raise typer.Exit(1)


def _answers(client: RobotClient) -> tuple[GateStatus | None, HalStatus | None]:
    """What gate and HAL say; None for one that does not answer."""
    gate, hal = None, None
    with suppress(NoAnswerError):
        gate = client.gate_status()
    with suppress(NoAnswerError):
        hal = client.hal_status()
    return gate, hal


def _runners(client: RobotClient) -> list[GoalFeedback]:
    """What each runner that is seen says of its goal."""
    found = []
    for runner in client.deployment.runners:
        if runner in client.alive:
            with suppress(NoAnswerError):
                found.append(client.goal_feedback(runner))
    return found


def _print(
    gate: GateStatus | None,
    hal: HalStatus | None,
    runners: list[GoalFeedback],
    alive: list[str],
    missing: list[str],
    starting: list[str],
) -> None:
    silent = "is starting" if starting else "does not answer"
    if gate is None:
        echo(f"gate   {silent}")
    else:
        print_gate(gate)
    if hal is None:
        echo(f"robot  the HAL {silent}")
    else:
        print_robot(hal)
    for one in runners:
        echo(f"goal   {one.source}: {goal_line(one)}")
    echo(f"alive  {', '.join(alive) or 'none yet'}")
    if starting:
        echo(f"starting {', '.join(starting)}; ask again in a moment")
    if missing:
        echo(f"missing {', '.join(missing)}; see: fairlead ps, fairlead logs {missing[0]}")


def print_robot(hal: HalStatus) -> None:
    """The robot's state, pacing and tick, and what its HAL says besides."""
    detail = f" ({printable(hal.detail)})" if hal.detail else ""
    echo(
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
    why = f": {printable(ended.detail)}" if ended.detail else ""
    return f"{goal.skill} {ended.outcome} (decided by the {ended.decided_by}){why}"


def print_gate(gate: GateStatus) -> None:
    """The gate's state, its cause, what to do, its claims and what it counted."""
    echo(f"gate   {state_and_cause(gate)}")
    if gate.fix:
        echo(f"       try: {gate.fix}")
    for stop_id in gate.stop_ids:
        echo(f"       stop {hex_id(stop_id)}")
    if gate.latch_id:
        echo(f"       latch {hex_id(gate.latch_id)}")
    for claim in gate.claims:
        echo(f"claim  {claim.source} runs {claim.skill} on {', '.join(claim.parts)}")
    for line in _counted(gate):
        echo(line)


def _counted(gate: GateStatus) -> list[str]:
    """Chunks by outcome, then each check's finds in words: chunks, and other messages too."""
    found = {name: count for name, count in gate.counters if count}
    codes = {f"G{code:03d}": what for code, what in CHECKS.items()}
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
