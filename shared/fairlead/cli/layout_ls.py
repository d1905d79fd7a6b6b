"""``fairlead layout ls``: the layouts this installation can assemble."""

from __future__ import annotations

import sys

from fairlead.cli.console import print_json, print_table
from fairlead.cli.deployment_choice import JsonOption
from fairlead.skill.bindings import LAYOUTS, LayoutShape

EXAMPLE = "fairlead layout ls"


def command(as_json: JsonOption = False) -> None:
    """List state layouts: width, bindings that must be given, and content."""
    found = [
        {
            "layout": name,
            "dim": shape.dim,
            "required_bindings": list(shape.required),
            "content": _content(name, shape),
        }
        for name, shape in LAYOUTS.items()
    ]
    if as_json:
        print_json(found)
        return
    rows = [
        (row["layout"], row["dim"] or "-", row["content"], ", ".join(shape.required) or "none")
        for row, shape in zip(found, LAYOUTS.values(), strict=True)
    ]
    print_table(("LAYOUT", "DIM", "CONTENT", "BINDINGS NEEDED"), rows)


def _content(layout: str, shape: LayoutShape) -> str:
    """The first line of the layout's file, after its name."""
    from fairlead_state_assembler import LAYOUT_ASSEMBLERS

    if shape.dim is None:
        return "no assembler"
    text = sys.modules[LAYOUT_ASSEMBLERS[layout].__module__].__doc__ or ""
    return text.splitlines()[0].partition(": ")[2] if text else ""
