"""What ``fairlead run`` says once a goal has ended."""

from __future__ import annotations

from fairlead.messages import GateState, GateStatus, GoalResult
from fairlead.operate.goal_hearing import Progress
from fairlead_tools.cli.console import echo
from fairlead_tools.cli.status import state_and_cause


def print_result(skill: str, result: GoalResult) -> None:
    """How a goal has ended, and why, in one line."""
    ticks = result.last_tick - result.first_tick + 1
    when = f"after {ticks} ticks" if result.first_tick else "before its first tick"
    by_policy = result.detail if result.decided_by == "policy" else ""
    why = f": {result.kind}: {result.detail}" if result.kind else by_policy and f": {by_policy}"
    echo(f"{skill} {result.outcome} {when} (decided by the {result.decided_by}){why}")


def goal_hints(progress: Progress, gate: GateStatus, runner: str) -> list[str]:
    """Lines for a person, each naming a command."""
    hints = []
    if gate.state in (GateState.STOPPED, GateState.LATCHED):
        hints.append(f"the gate is {state_and_cause(gate)}\n  try: {gate.fix}")
    result = progress.result
    refused, judged = progress.verdicts.get("refused", 0), sum(progress.verdicts.values())
    if result is not None and "chunks refused" in result.detail:  # the runner's own count
        hints.append("see why chunks were refused: fairlead why")
    elif refused:
        hints.append(f"{refused} of {judged} chunks were refused; see why: fairlead why")
    if result is not None and result.kind == "policy_error":
        hints.append(f"what the policy printed, tracebacks too: fairlead logs {runner}")
    return hints
