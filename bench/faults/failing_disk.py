"""A real file system that turns read-only while files on it are open for writing.

An ext4 image on a loop device; what makes it fail is what makes a broken disk fail: the kernel
finds an error and, as the mount says, allows no more writing (``errors=remount-ro``).
"""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from bench.faults.live_stage import Changes, LiveStage, live_stage
from bench.faults.machine_stage import with_state_on
from bench.faults.row import NotHereError

IMAGE_BYTES = 64 << 20
TRIGGER = "/sys/fs/ext4/{device}/trigger_fs_error"


class FailingDisk:
    """Mounted on an empty folder until `close`.

    Raises:
        NotHereError: no right to mount, no loop devices, no ext4, or no way to make it fail.
    """

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        image = folder.with_suffix(".image")
        folder.mkdir(parents=True)
        with image.open("wb") as file:
            file.truncate(IMAGE_BYTES)
        _here(["mkfs.ext4", "-q", "-m", "0", str(image)])
        _here(["mount", "-o", "loop,errors=remount-ro", str(image), str(folder)])
        device = _here(["findmnt", "-no", "SOURCE", str(folder)])
        self._trigger = Path(TRIGGER.format(device=Path(device).name))
        if not self._trigger.exists():
            self.close()
            raise NotHereError(f"no {self._trigger}")

    def fail(self) -> None:
        """From now on every write is refused: EROFS, also through files that are open."""
        self._trigger.write_text("a test's error")

    def close(self) -> None:
        """Take it away; whoever wrote to it has ended."""
        subprocess.run(["umount", str(self.folder)], check=True, timeout=20)


class DiskStage:
    """Opens robots, each with a disk of its own: a failed one does not come back."""

    def __init__(self, folder: Path) -> None:
        self._folder, self._opened = folder, 0

    @contextmanager
    def robot(self) -> Iterator[tuple[LiveStage, FailingDisk]]:
        """The light robot; gate and runner keep their state on the disk."""
        self._opened += 1
        folder = self._folder / str(self._opened)
        disk = FailingDisk(folder / "disk")
        try:
            with live_stage(folder, Changes(command=with_state_on(disk.folder))) as robot:
                yield robot, disk
        finally:
            disk.close()


@contextmanager
def disk_stage(folder: Path) -> Iterator[DiskStage]:
    """Nothing runs yet."""
    yield DiskStage(folder)


def _here(words: list[str]) -> str:
    try:
        done = subprocess.run(words, capture_output=True, text=True, timeout=20, check=False)
    except FileNotFoundError as error:
        raise NotHereError(f"no {error.filename}") from error
    if done.returncode:
        raise NotHereError(f"{words[0]}: {done.stderr.strip()}")
    return done.stdout.strip()
