"""``fairlead layout ls``: the layouts this installation can assemble."""

from __future__ import annotations

from typing import Any

from fairlead.errors import ConfigError
from fairlead.layout import load_layout
from fairlead.plugins import LAYOUTS
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.deployment_choice import JsonOption

EXAMPLE = "fairlead layout ls"


def command(as_json: JsonOption = False) -> None:
    """List state layouts: width, bindings that must be given, content, and whose they are."""
    rows: list[dict[str, Any]] = []
    wrong: dict[str, str] = {}
    for name in LAYOUTS.names():
        try:
            layout, package = load_layout(name), LAYOUTS.find(name).package
        except ConfigError as error:
            wrong[name] = str(error)
            continue
        rows.append({"layout": name, "dim": layout.dim, "required_bindings": list(layout.required),
                     "content": layout.content, "package": package})  # fmt: skip
    if as_json:
        print_json([*rows, *({"layout": name, "error": text} for name, text in wrong.items())])
        return
    lines = [
        (row["layout"], row["dim"] or "-", row["content"], ", ".join(row["required_bindings"]),
         row["package"])
        for row in rows
    ]  # fmt: skip
    print_table(("LAYOUT", "DIM", "CONTENT", "BINDINGS NEEDED", "FROM"), lines)
    for text in wrong.values():
        echo(text, err=True)
