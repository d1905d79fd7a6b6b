"""Tables of docs/speed.md that a bench command writes itself, between marks that name them."""

from __future__ import annotations

import argparse
import os
import platform
import re
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from fairlead.errors import ConfigError
from fairlead.paths import repo_root
from fairlead_tools.writable import require_writable

PAGE = Path("docs/speed.md")


class Write(argparse.Action):
    """--write: True, once it is known that the page, ``docs/speed.md`` or another, can be."""

    def __init__(self, *, page: Path = PAGE, **options: Any) -> None:
        super().__init__(nargs=0, default=False, **options)
        self._page = repo_root() / page

    def __call__(self, parser: argparse.ArgumentParser, namespace: Any, *_: object) -> None:
        """Raises `SystemExit` with the reason if it cannot."""
        try:
            require_writable("--write", self._page)
        except ConfigError as error:
            parser.error(str(error))
        setattr(namespace, self.dest, True)


def machine() -> str:
    """This machine in words: number of processors, their kind, and the load now."""
    info = Path("/proc/cpuinfo")
    names = re.findall(r"model name\s*: (.*)", info.read_text()) if info.exists() else []
    kind = names[0] if names else platform.machine()
    return f"{os.cpu_count()} x {kind}, load {os.getloadavg()[0]:.1f}"


def write_table(name: str, table: str, page: Path | None = None) -> Path:
    """Put a table into the page, with the day and the machine below it.

    Args:
        name: what the marks call it: ``<!-- NAME -->`` and ``<!-- end of NAME -->``.
        table: Markdown.
        page: the page; docs/speed.md of this checkout without one.

    Raises:
        SystemExit: the page has no such marks.
    """
    path = page or repo_root() / PAGE
    start, end = f"<!-- {name} -->", f"<!-- end of {name} -->"
    before, found, rest = path.read_text().partition(start)
    _, ended, after = rest.partition(end)
    if not found or not ended:
        raise SystemExit(f"bench: {path} has no marks {start} and {end}; put them where it goes")
    note = f"Measured {datetime.now(UTC).date()}: {machine()}."
    path.write_text(f"{before}{start}\n{table}\n\n{note}\n{end}{after}")
    return path
