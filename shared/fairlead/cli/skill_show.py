"""``fairlead skill show``: a skill's contracts, with every default filled in."""

from __future__ import annotations

from typing import Annotated

import typer
import yaml

from fairlead.cli.console import print_json
from fairlead.cli.deployment_choice import JsonOption
from fairlead.skill.manifest import load_skill

EXAMPLE = "fairlead skill show oracle-counter-to-cabinet"


def command(
    skill: Annotated[str, typer.Argument(help="folder under rskills/")],
    as_json: JsonOption = False,
) -> None:
    """Show a skill: its policy, what it needs as state, what its numbers mean."""
    manifest = load_skill(skill)
    document = manifest.model_dump(mode="json") | {"skill_hash": manifest.skill_hash.hex()}
    if as_json:
        print_json(document)
    else:
        typer.echo(yaml.safe_dump(document, sort_keys=False).rstrip())
