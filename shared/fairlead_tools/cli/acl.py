"""``fairlead acl``: who may do what on a robot's keys."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.access import Rights, rights
from fairlead.deploy.deployment import load_deployment
from fairlead.operate.connection import choose_file
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.options import JsonOption, example, make_group, parse_running_or_file


@example("fairlead acl show panda_mujoco")
def show_command(
    target: Annotated[
        Path | None,
        typer.Argument(
            parser=parse_running_or_file,
            metavar="NAME_OR_FILE",
            help="as in `fairlead ps`, a name in compose/, or a file; "
            "without it: the only deployment that runs here",
        ),
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Show who may write and read each key of a deployment; nobody may do anything else.

    Who writes a query asks it, who reads it answers it. EXCEPT: keys of ``KEY`` that are somebody's
    own; those have a line of their own.
    """
    deployment = load_deployment(choose_file(target))
    found = list(rights(deployment.parties))
    if as_json:
        rows = [
            {"key": r.key, "except": r.but, "kind": r.kind, "write": r.write, "read": r.read}
            for r in found
        ]
        print_json({"access": deployment.access, "rows": rows})
        return
    header = ("KEY", "KIND", "MAY WRITE", "MAY READ", "EXCEPT")
    print_table(header, [_row(one) for one in found])
    if deployment.open_access:
        echo(f"\nWARNING nothing enforces this: {deployment.open_access}")


def _row(one: Rights) -> tuple[str, str, str, str, str]:
    return one.key, one.kind, ", ".join(one.write), ", ".join(one.read), ", ".join(one.but)


group = make_group("acl", "Show who may do what on a robot's keys.", {"show": show_command})
