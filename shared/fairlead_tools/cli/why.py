"""``fairlead why`` and ``fairlead judge``: a decision of the gate in words, and one made again."""

from __future__ import annotations

import os
import re
from pathlib import Path
from typing import Annotated, Any

import msgspec
import typer

from fairlead.deploy.registry import Registry
from fairlead.errors import NoAnswerError, expected
from fairlead.paths import decisions_binary
from fairlead.regular_file import regular
from fairlead.wire.gate_checks import CHECKS
from fairlead_tools.cli.console import echo, print_json
from fairlead_tools.cli.options import JsonOption, RunningOption, choose_running, example
from fairlead_tools.decision_log.explanation import Explanation, explain
from fairlead_tools.decision_log.text import check_lines, decision_lines

_LOGS = "decisions/*.decisions"


def choose_decision_log(wanted: str | None, state_dir: Path | None) -> Path:
    """The newest log of the deployment that is named, runs, or ran last.

    Args:
        wanted: name or file of a deployment that runs.
        state_dir: state folder of one that need not run.

    Raises:
        NoAnswerError: there is none, with where it was looked for.
        ConfigError: several deployments run and none was named.
    """
    registry = Registry()
    if state_dir is not None:
        return _newest(state_dir, f"*/{_LOGS}")
    if wanted is not None or registry.entries():
        return _newest(Path(choose_running(wanted).state_dir), f"*/{_LOGS}")
    return _newest(registry.root, f"*/*/{_LOGS}")


def _newest(folder: Path, pattern: str) -> Path:
    found = sorted(folder.glob(pattern), key=lambda path: path.stat().st_mtime_ns)
    if not found:
        raise NoAnswerError(
            f"no decision log in {folder}/{pattern}; a running gate writes one; "
            "name another place: --state-dir DIR or --log FILE"
        )
    return found[-1]


def parse_tick(text: str) -> int | None:
    """``last`` (None) or the number of a tick."""
    if text == "last":
        return None
    if not text.isdecimal():
        wanted = "`last`, a tick such as 120 or a check such as G020"
        raise typer.BadParameter(f"expected {wanted}, got {text!r}")
    return int(text)


def parse_check(text: str) -> int | None:
    """The number of a check such as ``G020``; None if it is no such word."""
    if re.fullmatch(r"[Gg]\d{1,3}", text) is None:
        return None
    code = int(text[1:])
    if code not in CHECKS:
        wrong = expected("", "the code of a check", repr(text), [f"G{one:03d}" for one in CHECKS])
        raise typer.BadParameter(wrong.removeprefix(": "))
    return code


@example("fairlead why last")
def why_command(
    tick: Annotated[
        str,
        typer.Argument(metavar="[TICK|last|CODE]", help="a tick, the last refusal, or a check"),
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
    here, or ran last. G020 says what that check asks, what follows and what to do.
    """
    if (code := parse_check(tick)) is not None:
        lines = check_lines(code)
        print_json({"words": lines}) if as_json else echo("\n".join(lines))
        return
    number = parse_tick(tick)
    chosen = regular(log) if log is not None else choose_decision_log(deployment, state_dir)
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


@example(
    "fairlead judge out/demo/state/safety/decisions --config robots/panda_mobile/gate.sim.json"
)
def judge_command(
    log: Annotated[
        Path, typer.Argument(exists=True, help="a decision log, or a folder of them: its newest")
    ],
    config: Annotated[
        Path | None,
        typer.Option(
            exists=True,
            dir_okay=False,
            help="another gate file of the same robot: what would it have refused?",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Judge a recorded run again: identical bit for bit, or otherwise under other limits.

    Becomes `fairlead-decisions judge`, which lies beside the gate. Exit status: 0 identical, 1
    different, 2 not readable or damaged.
    """
    reader = str(decisions_binary())
    words = [] if config is None else ["--config", str(regular(config))]
    os.execv(reader, [reader, "judge", str(regular(log)), *words, *(["--json"] if as_json else [])])  # noqa: S606
