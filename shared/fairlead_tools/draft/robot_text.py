"""robot.yaml's text: a drafted robot's document, as a person reads it."""

from __future__ import annotations

from typing import Any

import yaml

from fairlead_tools.draft.robot_document import DraftRobot


class _Dumper(yaml.SafeDumper):
    """Numbers and names in a row stand on one line; what both profiles share is written once."""

    def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
        plain = all(not isinstance(item, list | dict) for item in sequence)
        return super().represent_sequence(tag, sequence, flow_style=plain)

    def generate_anchor(self, node: Any) -> str:
        return super().generate_anchor(node).replace("id", "sim_")


def robot_text(robot: DraftRobot, command: str) -> str:
    """robot.yaml's text."""
    head = (
        f"# Drafted by: {command}\n"
        "# to_confirm lists what nobody has given or confirmed yet: correct each, then delete its\n"
        "# line. The profile hardware is not compiled before. Where it differs from sim, replace\n"
        "# its *alias by a block of its own.\n"
    )
    text = yaml.dump(robot.document(), Dumper=_Dumper, sort_keys=False, width=120)
    return head + text
