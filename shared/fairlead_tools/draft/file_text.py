"""The text of a drafted robot's files: robot.yaml, and a deployment file."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import yaml

from fairlead.yaml_file import RowDumper
from fairlead_tools.draft.robot_document import DraftRobot


class _Dumper(RowDumper):
    """What both profiles share is written once."""

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


SERVICES = ("safety", "state_assembler", "runner")


def deployment_text(robot: str, hal: str, missing: Sequence[str]) -> str:
    """The file's text."""
    told = "".join(f"# {line}\n" for one in missing for line in one.splitlines())
    why = (
        f"# The HAL is {hal}, without physics or true tool motions, until hal_mujoco can move it:\n"
        + told
    )
    runs = {"hal": hal, **{name: name for name in SERVICES}, "runner": "skill_runner"}
    head = (
        f"# {robot}, every service on this machine, in lockstep: fairlead up {robot}.yaml\n"
        f"{why if missing else ''}"
        f"robot: {robot}\nid: {robot}\nprofile: sim\npacing: lockstep\nservices:\n"
    )
    return head + "".join(f"  {name}: {{run: {run}}}\n" for name, run in runs.items())
