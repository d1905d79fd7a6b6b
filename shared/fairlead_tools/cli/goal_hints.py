"""What to look at next when a goal did not succeed."""

from __future__ import annotations

from fairlead.messages import GateState, GateStatus
from fairlead.operate.goal import Progress
from fairlead_tools.cli.status import state_and_cause


def goal_hints(progress: Progress, gate: GateStatus, runner: str) -> list[str]:
    """Lines for a person, each naming a command."""
    hints = []
    if gate.state in (GateState.STOPPED, GateState.LATCHED):
        hints.append(f"the gate is {state_and_cause(gate)}\n  try: {gate.fix}")
    refused, judged = progress.verdicts.get("refused", 0), sum(progress.verdicts.values())
    if refused:
        hints.append(f"{refused} of {judged} chunks were refused; see why: fairlead why")
    if progress.result is not None and progress.result.kind == "policy_error":
        hints.append(f"what the policy printed, tracebacks too: fairlead logs {runner}")
    return hints
