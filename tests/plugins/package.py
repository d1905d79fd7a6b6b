"""A package that is installed as far as Python can tell: modules and metadata in one folder."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path


def install(
    site: Path,
    name: str,
    entry_points: Mapping[str, Mapping[str, str]] | str,
    files: Mapping[str, str],
    version: str = "1.2",
) -> None:
    """Put a distribution into a folder.

    Args:
        site: for ``PYTHONPATH``, see `run`.
        entry_points: by group, ``module:object`` by name; or the file's text as it is.
        files: text by path.
    """
    info = site / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir(parents=True)
    info.joinpath("METADATA").write_text(
        f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n", encoding="utf-8"
    )
    if not isinstance(entry_points, str):
        entry_points = "".join(
            f"[{group}]\n" + "".join(f"{key} = {value}\n" for key, value in named.items())
            for group, named in entry_points.items()
        )
    info.joinpath("entry_points.txt").write_text(entry_points, encoding="utf-8")
    for path, text in files.items():
        file = site / path
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(text, encoding="utf-8")


def run(site: Path, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run Python where the packages of ``site`` are installed, beside all that is."""
    return subprocess.run(
        [sys.executable, *words],
        env=os.environ | {"PYTHONPATH": str(site), "COLUMNS": "200"} | environment,
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )


def fairlead(site: Path, *words: str, **environment: str) -> subprocess.CompletedProcess[str]:
    """Run the command line there."""
    return run(site, "-m", "fairlead_tools.cli.main", *words, **environment)
