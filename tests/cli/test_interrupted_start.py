"""Ctrl-C while ``fairlead`` is being imported: nothing was begun, and nothing else is said."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

from tests.cli.command import fairlead_command, fairlead_environment

pytestmark = pytest.mark.processes

AT_IMPORT = """
import os, signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            os.kill(os.getpid(), signal.SIGINT)

sys.meta_path.insert(0, Finder())
"""


@pytest.mark.parametrize(
    "module",
    [
        "fairlead.errors",
        "fairlead.wire.printable",
        "fairlead_tools.cli.console",
        "typer",
        "fairlead_tools.cli.app",
        "fairlead_tools.cli.processes",  # of the command itself
    ],
)
def test_ctrl_c_while_a_module_is_imported_ends_the_command_without_a_traceback(
    module: str, tmp_path: Path
) -> None:
    (tmp_path / "sitecustomize.py").write_text(AT_IMPORT.format(module=module), encoding="utf-8")
    done = subprocess.run(
        fairlead_command("ps"),
        env=fairlead_environment(tmp_path) | {"PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
        timeout=60.0,
        check=False,
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")
