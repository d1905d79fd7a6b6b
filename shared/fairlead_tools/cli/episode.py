"""``fairlead episode``: start a new simulated episode."""

from __future__ import annotations

from typing import Annotated

import typer

from fairlead.errors import RefusedError
from fairlead.messages import GateState, ResetEpisodeReply
from fairlead.operate.client import RobotClient
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.deployment_choice import DeploymentOption, choose_deployment
from fairlead_tools.cli.status import state_and_cause
from fairlead_tools.cli.wire_number import MAX_NUMBER

EXAMPLE = "fairlead episode --seed 7"


def command(
    seed: Annotated[
        int, typer.Option(min=0, max=MAX_NUMBER, help="where things stand in the new scene")
    ] = 0,
    deployment: DeploymentOption = None,
) -> None:
    """Start a new episode of a simulator, without a goal, and wait until the robot stands in it.

    Disarms first. Refused while somebody has a claim, or the gate is stopped or latched.
    """
    chosen = choose_deployment(deployment)
    with RobotClient(chosen, by="fairlead episode") as client:
        reply = new_episode(client, seed)
    echo(f"{chosen.id} is in a new episode, seed {seed}, from tick {reply.episode_tick} on")
    echo("next: fairlead run SKILL, or fairlead arm")


def new_episode(client: RobotClient, seed: int) -> ResetEpisodeReply:
    """Disarm, start a new episode, and return once the HAL confirms that the robot stands in it.

    Raises:
        RefusedError: somebody has a claim, the gate is stopped or latched, or the robot is real.
        NoAnswerError: the gate or the HAL does not answer.
    """
    gate = client.gate_status()
    if gate.state in (GateState.STOPPED, GateState.LATCHED):
        why = f"no new episode while the gate is {state_and_cause(gate)}"
        raise RefusedError("fairlead", why, gate.fix)
    if gate.claims:
        claim = gate.claims[0]
        why = f"a new episode would end the claim of {claim.source}, which runs {claim.skill}"
        raise RefusedError("fairlead", why, f"fairlead cancel {claim.source}")
    if gate.state == GateState.ARMED:
        client.disarm()
    return client.reset_episode(seed)
