"""The light robot on a machine whose clock, disk and files can be tampered with."""

from __future__ import annotations

import os
import shutil
import struct
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from bench.faults.live_stage import SOURCE, Changes, LiveStage, live_stage
from bench.faults.row import NotHereError
from fairlead.paths import repo_root

MACHINE_FILE = "FAIRLEAD_TEST_MACHINE"
SMALL_DISK = "8m"
ON_OTHER_DISK = ("safety", "runner")


class MachineStage(LiveStage):
    """tree: the robots' own copy of ``robots/``. disk: where gate and runner write."""

    tree: Path
    disk: Path
    machine_file: Path

    def tamper(self, wall_shift_s: int = 0, fsync_ms: int = 0) -> int:
        """Set the wall clock and the disk of every service.

        Returns:
            CLOCK_MONOTONIC just before [ns].
        """
        now_ns = time.monotonic_ns()
        with self.machine_file.open("r+b") as file:
            file.write(struct.pack("<qq", wall_shift_s, fsync_ms))
        return now_ns

    def wall_clock(self) -> float:
        """What a process of this machine takes for the time."""
        words = [sys.executable, "-c", "import time; print(time.time())"]
        environment = os.environ | self.variables()
        return float(subprocess.check_output(words, env=environment, timeout=30))

    def variables(self) -> dict[str, str]:
        """The environment that makes the tampering reach a process."""
        return _variables(self.machine_file)


def _variables(file: Path) -> dict[str, str]:
    return {"LD_PRELOAD": str(file.with_suffix(".so")), MACHINE_FILE: str(file)}


def with_state_on(disk: Path) -> Callable[[str, list[str]], list[str]]:
    """Changes the words that start gate and runner: they write to that disk."""

    def command(service: str, words: list[str]) -> list[str]:
        if service not in ON_OTHER_DISK:
            return words
        own = disk / service
        own.mkdir(exist_ok=True)
        at = words.index("--state-dir") + 1
        return [*words[:at], str(own), *words[at + 1 :]]

    return command


@contextmanager
def machine_stage(folder: Path) -> Iterator[MachineStage]:
    """All services, with a copy of the robots, on a small disk and under the preload library."""
    file, tree, disk = folder / "machine", folder / "tree", folder / "disk"
    file.write_bytes(struct.pack("<qq", 0, 0))
    source = Path(__file__).with_name("preload.c")
    compiler = ["cc", "-O1", "-shared", "-fPIC", "-o", str(file.with_suffix(".so")), str(source)]
    subprocess.run([*compiler, "-ldl"], check=True, timeout=60)
    copy_tree(tree)
    disk.mkdir()
    variables = {**_variables(file), "FAIRLEAD_ROOT": str(tree)}

    on_disk = with_state_on(disk)

    def command(service: str, words: list[str]) -> list[str]:
        return on_disk(service, in_tree(tree, words))

    with _small_disk(disk), live_stage(folder, Changes("realtime", {"": variables}, command)) as r:
        stage = MachineStage(r.robot)
        stage.tree, stage.disk, stage.machine_file = tree, disk, file
        yield stage


def copy_tree(tree: Path) -> None:
    """A checkout (``FAIRLEAD_ROOT``) whose robots may be changed."""
    tree.mkdir()
    shutil.copytree(repo_root() / "robots", tree / "robots")
    for name in ("rskills", "compose", "build"):
        (tree / name).symlink_to(repo_root() / name)
    assert SOURCE.is_file()


def in_tree(tree: Path, words: list[str]) -> list[str]:
    """A service's words, with the robots of that checkout."""
    return [word.replace(f"{repo_root()}/robots", f"{tree}/robots") for word in words]


@contextmanager
def _small_disk(folder: Path) -> Iterator[None]:
    words = ["mount", "-t", "tmpfs", "-o", f"size={SMALL_DISK}", "fairlead-faults", str(folder)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=20, check=False)
    if done.returncode:
        raise NotHereError(f"no small disk: {done.stderr.strip()}")
    try:
        yield
    finally:
        subprocess.run(["umount", str(folder)], check=True, timeout=20)
