"""A built wheel in an environment that holds nothing else, and a person who uses it there."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import pytest

from bench.equipment.live_robot import wait_for
from tests.repo.tree import ROOT

UV = ROOT / "scripts" / "uv"
PACKAGED = Path("fairlead") / "data"


def built(out: Path, gate: Path) -> None:
    """The wheel and the source archive, with a gate that lies built in ``gate``."""
    done = subprocess.run(
        [ROOT / "scripts" / "build-wheel", "--gate", gate, "--out", out],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 0, done.stdout + done.stderr


def install(wheel: Path, folder: Path) -> Path:
    """Make an environment as docs/install.md says: the locked packages, then the wheel.

    Skips the test when the packages are neither in uv's cache nor to be had from a registry.
    """
    python = folder / "bin" / "python"
    subprocess.run([UV, "venv", "--quiet", "--python", sys.executable, folder], check=True)
    lock = wheel.parent / "requirements-run.lock"
    sync = ["pip", "sync", "--quiet", "--require-hashes", "--python", str(python), str(lock)]
    if subprocess.run([UV, *sync, "--offline"], capture_output=True, check=False).returncode:
        online = subprocess.run([UV, *sync], capture_output=True, text=True, check=False)
        if online.returncode:
            pytest.skip(f"no package registry: {online.stderr.strip().splitlines()[-1]}")
    # Its own cache: that of the machine would keep a copy of every wheel that a test built.
    single = ["pip", "install", "--quiet", "--no-deps", "--offline", "--no-cache"]
    subprocess.run([UV, *single, "--python", python, wheel], check=True)
    [site] = folder.glob("lib/python3.*/site-packages")
    return site


@dataclass(frozen=True)
class Person:
    """Somebody who has the environment, a home, and nothing of the checkout.

    site: the environment's site-packages. home: also the working directory.
    """

    site: Path
    home: Path

    @property
    def bin(self) -> Path:
        return self.site.parents[2] / "bin"

    @property
    def tree(self) -> Path:
        return self.site / PACKAGED

    def command(self, *words: str) -> list[str]:
        """A command line for an otherwise empty process environment."""
        variables = {"HOME": self.home, "PATH": "/usr/bin:/bin", "OMP_NUM_THREADS": "1"}
        given = [f"{name}={value}" for name, value in variables.items()]
        return ["env", "-i", *given, "COLUMNS=200", str(self.bin / words[0]), *words[1:]]

    def run(self, *words: str) -> subprocess.CompletedProcess[str]:
        """Run a program of the environment to its end."""
        return subprocess.run(
            self.command(*words),
            cwd=self.home,
            capture_output=True,
            text=True,
            timeout=240,
            check=False,
        )

    @contextmanager
    def up(self, deployment: str) -> Iterator[tuple[subprocess.Popen[str], list[str]]]:
        """``fairlead up``, once the robot is up: its process, and what it prints."""
        command = self.command("fairlead", "up", deployment)
        with subprocess.Popen(command, cwd=self.home, stdout=subprocess.PIPE, text=True) as process:
            lines: list[str] = []
            stream = process.stdout
            assert stream is not None
            threading.Thread(target=lambda: lines.extend(stream), daemon=True).start()
            try:
                wait_for(
                    lambda: process.poll() is not None or any(" is up" in line for line in lines),
                    "the robot is up",
                    120.0,
                )
                assert process.poll() is None, "".join(lines)
                yield process, lines
            finally:
                process.terminate()

    def does(self, *words: str) -> str:
        """What a program prints that has to succeed."""
        done = self.run(*words)
        assert done.returncode == 0, f"{words}\n{done.stdout}{done.stderr}"
        return done.stdout
