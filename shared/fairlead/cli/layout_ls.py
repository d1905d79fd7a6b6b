"""``fairlead layout ls``: the layouts this installation can assemble."""

from __future__ import annotations

import inspect

from fairlead.cli.console import print_json, print_table
from fairlead.cli.deployment_choice import JsonOption

EXAMPLE = "fairlead layout ls"


def command(as_json: JsonOption = False) -> None:
    """List state layouts and what each one contains."""
    from fairlead_state_assembler import LAYOUT_ASSEMBLERS

    found = {name: _first_line(assembler) for name, assembler in sorted(LAYOUT_ASSEMBLERS.items())}
    if as_json:
        print_json([{"layout": name, "content": text} for name, text in found.items()])
    else:
        print_table(("LAYOUT", "CONTENT"), list(found.items()))


def _first_line(assembler: object) -> str:
    text = inspect.getdoc(assembler) or ""
    return text.splitlines()[0] if text else ""
