"""The text of a drafted robot's files: robot.yaml, and a deployment file."""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from typing import Any

import yaml

from fairlead.deploy.process_table import is_listening
from fairlead.paths import deployment_files
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


_FIRST, _BLOCKS, _EACH = 7600, 200, 10
SERVICES = ("safety", "state_assembler", "runner")


def deployment_text(robot: str, hal: str, missing: Sequence[str]) -> str:
    """The file's text, with ports that no deployment file of ours names and nobody listens on."""
    ports = _ports(robot)
    told = "".join(f"# {line}\n" for one in missing for line in one.splitlines())
    why = f"# The HAL is {hal}, without physics, until hal_mujoco can move the robot:\n" + told
    runs = {"runner": "skill_runner"}
    lines = [
        f"  {name}: {{run: {runs.get(name, name)}, listen: tcp/127.0.0.1:{port}}}"
        for name, port in zip(("hal", *SERVICES), ports, strict=True)
    ]
    lines[0] = lines[0].replace("run: hal,", f"run: {hal},")
    head = (
        f"# {robot}, every service on this machine, in lockstep: fairlead up {robot}.yaml\n"
        f"{why if missing else ''}"
        f"robot: {robot}\nid: {robot}\nprofile: sim\npacing: lockstep\nservices:\n"
    )
    return head + "\n".join(lines) + "\n"


def _ports(robot: str) -> list[int]:
    """Below those that the kernel hands out; the first try depends on the robot's id."""
    named = {
        int(port)
        for file in deployment_files()
        for port in re.findall(r":(\d{4,5})\b", file.read_text(encoding="utf-8"))
    }
    start = zlib.crc32(robot.encode()) % _BLOCKS
    blocks = (
        [_FIRST + (start + number) % _BLOCKS * _EACH + offset for offset in range(1, 5)]
        for number in range(_BLOCKS)
    )
    return next(
        ports for ports in blocks if not named & set(ports) and not any(map(is_listening, ports))
    )
