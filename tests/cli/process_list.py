"""Processes of this machine, found by what their command lines mention."""

from __future__ import annotations

from pathlib import Path

from fairlead.deploy.process_table import command_of


def all_pids() -> list[int]:
    return [int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit()]


def pids_that_mention(folder: Path) -> list[int]:
    """Processes whose command line names a folder or something in it."""
    return [pid for pid in all_pids() if str(folder) in command_of(pid)]
