"""What commands print: JSON documents, ids, small tables."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import typer

from fairlead.wire.printable import printable, printable_lines


def echo(text: str, err: bool = False) -> None:
    """Lines for a person: what others wrote in them cannot move the cursor or colour the terminal.

    All of a command's words go through here.
    """
    typer.echo(printable_lines(text), err=err)


def print_json(document: Any) -> None:
    """One JSON document on standard output."""
    typer.echo(json.dumps(document, indent=2, sort_keys=False))


def hex_id(number: int) -> str:
    """An id as people read and type it; 0 means none."""
    return f"{number:016x}" if number else "none"


def print_table(header: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    """Columns as wide as their content, two blanks between them."""
    lines = [list(header)] + [[printable(str(cell)) for cell in row] for row in rows]
    widths = [max(len(line[column]) for line in lines) for column in range(len(header))]
    for line in lines:
        cells = [cell.ljust(width) for cell, width in zip(line, widths, strict=True)]
        echo("  ".join(cells).rstrip())
