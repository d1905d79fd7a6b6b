"""``fairlead skill show``: a skill's contracts, with every default filled in."""

from __future__ import annotations

from typing import Any

import yaml

from fairlead.skill.manifest import find_skill, read_skill
from fairlead_tools.cli.console import echo, print_json
from fairlead_tools.cli.deployment_choice import JsonOption
from fairlead_tools.cli.skill_choice import SkillArgument

EXAMPLE = "fairlead skill show oracle-counter-to-cabinet"

WIDTH = 100


class _RowDumper(yaml.SafeDumper):
    """Numbers and names in a row stand on one line, as people write them."""

    def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
        plain = all(not isinstance(item, (list, dict)) for item in sequence)
        return super().represent_sequence(tag, sequence, flow_style=plain)


def command(
    skill: SkillArgument,
    as_json: JsonOption = False,
) -> None:
    """Show a skill: its policy, what it needs as state, what its numbers mean."""
    manifest = read_skill(find_skill(skill))
    document = manifest.model_dump(mode="json") | {"skill_hash": manifest.skill_hash.hex()}
    if as_json:
        print_json(document)
    else:
        echo(yaml.dump(document, Dumper=_RowDumper, sort_keys=False, width=WIDTH).rstrip())
