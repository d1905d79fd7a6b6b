"""What ``fairlead up`` says once the whole robot is there, and of its gate whenever it is back."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

from fairlead.errors import FairleadError
from fairlead.messages import GateState, GateStatus
from fairlead.operate.client import RobotClient
from fairlead_tools.cli.console import hex_id
from fairlead_tools.cli.status import state_and_cause

Say = Callable[[str, str], None]
PATIENCE_S = 10.0


class Greeting:
    """Says, once, that the robot is up and what to do next; names what it waits for."""

    def __init__(self, client: RobotClient, folder: Path, say: Say) -> None:
        self._client = client
        self._folder = folder
        self._say = say
        self._complain_at_s = time.monotonic() + PATIENCE_S
        self._done = False

    def say_once_up(self) -> bool:
        """Call it a few times a second: it waits for nobody while somebody is missing.

        Returns:
            Whether it was said just now.
        """
        if self._done:
            return False
        gate, trouble = self._following_gate()
        if gate is not None:
            self._done = True
            self._greet(gate)
        elif time.monotonic() > self._complain_at_s:
            self._complain_at_s += PATIENCE_S
            self._say("up", f"not up yet: {trouble}")
        return gate is not None

    def _following_gate(self) -> tuple[GateStatus | None, str]:
        """The gate's status once it follows the HAL; else what is missing."""
        missing = set(self._client.deployment.services) - self._client.alive
        if missing:
            return None, f"{', '.join(sorted(missing))} not seen"
        try:
            gate = self._client.following_gate()
        except FairleadError as error:
            return None, str(error)
        return gate, "the gate has no state of this HAL yet; see: fairlead status"

    def _greet(self, gate: GateStatus) -> None:
        self._say("up", f"{self._client.deployment.id} is up; state and logs: {self._folder}")
        if gate.state == GateState.DISARMED:
            if self._client.deployment.runners:
                next_step = "fairlead run SKILL   (see: fairlead skill ls)"
            else:  # no service of the file runs skills
                next_step = "fairlead status; fairlead arm for a program of your own"
            self._say("up", f"in another terminal: {next_step}")
        else:
            explain_gate(gate, self._say)


def explain_gate(gate: GateStatus, say: Say) -> None:
    """Say why the gate will not arm, and the commands that lead back to a goal."""
    say("up", f"the gate is {state_and_cause(gate)}")
    for one in (gate.latch_id, *gate.stop_ids):
        if one:
            say("up", f"when the cause is gone: fairlead reset {hex_id(one)}")
