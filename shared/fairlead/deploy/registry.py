"""What runs on this machine: one small file per deployment, and a lock while it runs.

Everything lies under ``$FAIRLEAD_STATE`` (default ``$XDG_STATE_HOME/fairlead``, else
``~/.local/state/fairlead``), so ``ps``, ``down`` and ``logs`` work from any folder:

    running/<name>.json             who supervises the deployment, and its processes
    running/<name>.yaml             its file as it was then, for a stop once that cannot be read
    running/<name>.lock             held by the supervisor, with its pid; the kernel frees it when
                                    it dies; never deleted: two could then hold one lock
    running/<name>+<service>.json   a service that ``fairlead service`` started
    <name>/                         the deployment's state folder, unless ``--state-dir`` says
                                    otherwise
"""

from __future__ import annotations

import fcntl
import logging
import os
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

import msgspec

from fairlead.deploy.deployment import Deployment
from fairlead.deploy.process_table import ProcessId
from fairlead.errors import ServiceError
from fairlead.paths import make_private, user_state_dir, written

_LOG = logging.getLogger("registry")
_SAID: set[Path] = set()


@dataclass(frozen=True)
class ServiceEntry:
    """One service of a running deployment, as its supervisor last saw it.

    process: None before the first start.
    by_hand: started by ``fairlead service``: nobody watches it, or knows whether it is ready.
    managed: by hand, and a service manager starts it again when it ends.
    """

    process: ProcessId | None
    ready: bool
    restarts: int
    by_hand: bool = False
    managed: bool = False

    @property
    def running(self) -> ProcessId | None:
        """Its process, if that runs."""
        return self.process if self.process is not None and self.process.is_running else None


@dataclass(frozen=True)
class Running:
    """One deployment that was started on this machine.

    name: ``<id>``, or ``<id>@<namespace>`` outside the default namespace; of several hosts
        one: ``<id>:<host>``.
    supervisor: None where all its services were started by hand.
    """

    name: str
    deployment: str
    state_dir: str
    supervisor: ProcessId | None
    services: dict[str, ServiceEntry] = field(default_factory=dict)

    @property
    def is_supervised(self) -> bool:
        """Whether the supervisor that wrote the entry still runs."""
        return self.supervisor is not None and self.supervisor.is_running

    @property
    def by_hand(self) -> dict[str, ServiceEntry]:
        """Its services that were started by hand and run."""
        return {
            name: entry for name, entry in self.services.items() if entry.by_hand and entry.running
        }

    @property
    def leftovers(self) -> list[ProcessId]:
        """Processes of its services that still run."""
        return [entry.running for entry in self.services.values() if entry.running]


def running_name(deployment: Deployment, host: str | None = None) -> str:
    """The name under which ``ps``, ``down`` and ``logs`` know a deployment."""
    name = deployment.id if host is None else f"{deployment.id}:{host}"  # no name has a colon
    return name if deployment.namespace == "fl" else f"{name}@{deployment.namespace}"


class Registry:
    """The files under one state root.

    Args:
        root: None for the user's own (see the module's text).
    """

    def __init__(self, root: Path | None = None) -> None:
        self.root = root if root is not None else user_state_dir()

    @property
    def folder(self) -> Path:
        """Where the files are; it need not exist yet."""
        return self.root / "running"

    def default_state_dir(self, name: str) -> Path:
        """Where a deployment keeps logs and state if it is not told."""
        return self.root / name

    def entries(self) -> list[Running]:
        """Deployments with a live supervisor or a live process, by name."""
        found: dict[str, Running] = {}
        for entry in self._read_all():
            if not (entry.is_supervised or entry.leftovers):
                continue
            known = found.get(entry.name, entry)
            whole, part = (entry, known) if entry.is_supervised else (known, entry)
            whole.services.update(part.by_hand)
            found[entry.name] = whole
        return list(found.values())

    def find(self, name: str) -> Running | None:
        """One live deployment by name."""
        return next((entry for entry in self.entries() if entry.name == name), None)

    def write(self, entry: Running) -> None:
        """Write an entry so that readers see the old text or the new, never a mixture."""
        self._write(self._path(entry.name, "json"), entry)

    def keep_file(self, name: str, file: Path) -> None:
        """Keep a deployment's file as it is now."""
        self._make_folder()
        kept = self._path(name, "yaml")
        with written(kept, kept):
            kept.write_bytes(file.read_bytes())

    def kept_files(self, file: Path) -> list[Path]:
        """Copies of a file as it was when deployments that run were started of it.

        Each that differs once: several hosts of a robot may be on this machine. The file itself
        where a copy is missing.
        """
        whole = str(file.absolute())
        names = [entry.name for entry in self.entries() if entry.deployment == whole]
        kept = [self._path(name, "yaml") for name in names]
        found = [path if path.is_file() else file for path in kept]
        return list({path.read_bytes(): path for path in found if path.is_file()}.values())

    def write_by_hand(self, service: str, entry: Running, is_gate: bool) -> None:
        """List one service that nobody supervises, beside what is supervised.

        is_gate: the file is kept as the gate was started with it, else as the first service was.
        """
        if is_gate or self.find(entry.name) is None:
            self.keep_file(entry.name, Path(entry.deployment))
        self._write(self._path(f"{entry.name}+{service}", "json"), entry)

    def _write(self, path: Path, entry: Running) -> None:
        self._make_folder()
        draft = path.with_suffix(".draft")
        with written(path, draft):
            with draft.open("wb") as out:
                out.write(msgspec.json.format(msgspec.json.encode(entry)))
                out.flush()
                os.fsync(out.fileno())  # else it may be there and empty once the power has failed
            draft.replace(path)

    def remove(self, name: str) -> None:
        """Forget a deployment that has ended; whoever calls this holds its lock."""
        self._path(name, "json").unlink(missing_ok=True)
        if self.find(name) is None:  # nor does a service by hand
            self._path(name, "yaml").unlink(missing_ok=True)

    def remove_if_ended(self, name: str) -> None:
        """Forget a deployment, unless it was started again meanwhile."""
        try:
            with self.lock(name):
                self.remove(name)
        except ServiceError:
            return

    def lock(self, name: str) -> IO[str]:
        """Take the deployment's lock; closing the returned file frees it.

        Raises:
            ServiceError: naming the supervisor that holds it.
        """
        path = self._path(name, "lock")
        self._make_folder()
        handle = path.open("a+", encoding="utf-8")
        try:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            with handle:
                handle.seek(0)
                holder = handle.read()
            is_listed = not holder or self.find(name) is not None
            end = f"fairlead down {name}" if is_listed else f"kill {holder}"
            raise ServiceError(
                f"deployment {name} is already running (pid {holder or 'unknown'}); "
                f"stop it first: {end}"
            ) from None
        with suppress(OSError):  # a full disk: its pid is not known then
            handle.truncate(0)
            os.write(handle.fileno(), str(os.getpid()).encode())
        return handle

    def _make_folder(self) -> None:
        """What robots do is nobody else's to read."""
        make_private(self.folder)

    def _path(self, name: str, suffix: str) -> Path:
        return self.folder / f"{name}.{suffix}"

    def _read_all(self) -> Iterator[Running]:
        for path in sorted(self.folder.glob("*.json")):
            try:
                yield msgspec.json.decode(path.read_bytes(), type=Running)
            except FileNotFoundError:  # it ended just now
                continue
            except (
                OSError,
                msgspec.DecodeError,
            ) as error:  # the others can be stopped all the same
                if path not in _SAID:
                    _SAID.add(path)
                    _LOG.warning("%s cannot be read: %s; delete it if nothing runs", path, error)
