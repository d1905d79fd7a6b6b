"""``fairlead why``: why the gate decided as it did, from its decision log."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer

from fairlead_tools.cli.console import echo, print_json
from fairlead_tools.cli.decision_log_choice import choose_decision_log
from fairlead_tools.cli.deployment_choice import JsonOption, RunningOption
from fairlead_tools.receipts.explanation import Explanation, explain
from fairlead_tools.receipts.text import decision_lines

EXAMPLE = "fairlead why last"


def parse_tick(text: str) -> int | None:
    """``last`` (None) or the number of a tick."""
    if text == "last":
        return None
    if not text.isdecimal():
        raise typer.BadParameter(f"expected `last` or a tick such as 120, got {text!r}")
    return int(text)


def command(
    tick: Annotated[
        str, typer.Argument(metavar="[TICK|last]", help="a tick, or the last refusal")
    ] = "last",
    source: Annotated[str | None, typer.Option(help="only chunks of this runner")] = None,
    deployment: RunningOption = None,
    state_dir: Annotated[
        Path | None,
        typer.Option(exists=True, file_okay=False, help="state folder of a run that has ended"),
    ] = None,
    log: Annotated[
        Path | None, typer.Option(exists=True, help="a decision log, or a folder of them")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Say why the gate refused or released: who asked for what, the limit, what would pass.

    `last` is the newest refusal or truncation, with every stop since. A TICK shows what was
    decided at that tick or about a row for it. Reads the decision log of the gate that runs
    here, or ran last.
    """
    number = parse_tick(tick)
    chosen = log if log is not None else choose_decision_log(deployment, state_dir)
    asked = explain(chosen, number, source)
    if as_json:
        print_json(_document(asked))
        return
    echo(f"{asked.robot}, gate started {asked.started}, log {asked.log}")
    for note in _notes(asked):
        echo(note)
    for decision in asked.decisions:
        for line in decision_lines(asked, decision):
            echo(line)
    if not asked.decisions:
        echo(_nothing(asked, number, source))


def _document(asked: Explanation) -> dict[str, Any]:
    document: dict[str, Any] = msgspec.to_builtins(asked)
    words = [decision_lines(asked, decision) for decision in asked.decisions]
    for decision, lines in zip(document["decisions"], words, strict=True):
        decision["words"] = lines
    return document


def _notes(asked: Explanation) -> list[str]:
    notes = []
    if asked.lost:
        notes.append(f"the log has a gap: {asked.lost} records could not be written")
    if asked.read.startswith(("damaged", "cut off")):
        notes.append(f"the log is {asked.read}")
    return notes


def _nothing(asked: Explanation, tick: int | None, source: str | None) -> str:
    whose = f" of {source}" if source is not None else ""
    if tick is None:
        return (
            f"nothing{whose} was refused or cut: {asked.verdicts} verdicts in this log, "
            f"newest state tick {asked.tick}"
        )
    return (
        f"no decision{whose} at tick {tick} or about a row for it; the log's newest state is "
        f"tick {asked.tick}"
    )
