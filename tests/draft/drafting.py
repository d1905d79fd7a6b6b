"""``fairlead robot new`` and ``robot check`` in a folder of one's own."""

from __future__ import annotations

import json
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fairlead.paths import repo_root
from tests.cli.command import fairlead_here

EXAMPLE = repo_root() / "docs" / "examples" / "my_arm.xml"


@dataclass(frozen=True)
class Desk:
    """A person's folder; their robots lie in ``robots``."""

    folder: Path

    @property
    def robots(self) -> Path:
        return self.folder / "robots"

    def write(self, name: str, text: str) -> Path:
        path = self.folder / name
        path.write_text(text)
        return path

    def example(self, *replaced: tuple[str, str]) -> Path:
        """The example's MJCF with other words in it."""
        text = EXAMPLE.read_text()
        for old, new in replaced:
            assert old in text, old
            text = text.replace(old, new)
        return self.write("arm.xml", text)

    def new(self, name: str, *words: object) -> subprocess.CompletedProcess[str]:
        return fairlead_here("robot", "new", name, *map(str, words), state=self.folder)

    def check(self, name: str) -> tuple[int, dict[str, Any]]:
        """Its exit code, and what it found."""
        done = fairlead_here("robot", "check", name, "--json", state=self.folder)
        assert done.stdout, done.stderr
        found: dict[str, Any] = json.loads(done.stdout)
        return done.returncode, found

    def findings(self, name: str, *states: str) -> list[tuple[str, str]]:
        """Subject and finding of all that is in one of these states."""
        return [
            (one["subject"], one["found"])
            for one in self.check(name)[1]["findings"]
            if one["state"] in states
        ]
