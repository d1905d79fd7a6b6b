"""A supervisor's entry in the registry, and the lock that makes it the only one."""

from __future__ import annotations

import os
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import IO

from fairlead.deploy.process_table import ProcessId, process_id
from fairlead.deploy.registry import Registry, Running, ServiceEntry
from fairlead.errors import ServiceError


class Listing:
    """What the registry says of one deployment, from `reserve` until `leave`."""

    def __init__(self, registry: Registry, name: str, file: Path, state_dir: Path) -> None:
        self._registry, self._name = registry, name
        self._file, self._state_dir = str(file), str(state_dir)
        self._lock: IO[str] | None = None

    def reserve(self, names: Collection[str], gate: str) -> None:
        """List these processes as not started yet.

        Beside a gate that was started by hand the copy of the file stays as it was then.

        Raises:
            ServiceError: the deployment runs already, or something of these does.
        """
        if self._lock is not None:
            return
        self._lock = self._registry.lock(self._name)
        try:
            self._refuse_leftovers(names)
            before = self._registry.find(self._name)
            self.write(dict.fromkeys(names, ServiceEntry(None, False, 0)))
            if before is None or gate not in before.by_hand:
                self._registry.keep_file(self._name, Path(self._file))
        except BaseException:
            self._unlock()
            raise

    def write(self, services: Mapping[str, ServiceEntry]) -> None:
        """Say how the services are now."""
        own = process_id(os.getpid()) or ProcessId(os.getpid(), 0)
        entry = Running(self._name, self._file, self._state_dir, own, dict(services))
        self._registry.write(entry)

    def leave(self, living: Mapping[str, ServiceEntry]) -> None:
        """List nothing but what lives on, if anything does."""
        if self._lock is None:
            return
        if living:
            self.write(living)
        else:
            self._registry.remove(self._name)
        self._unlock()

    def _unlock(self) -> None:
        assert self._lock is not None
        self._lock.close()
        self._lock = None

    def _refuse_leftovers(self, names: Collection[str]) -> None:
        entry = self._registry.find(self._name)
        services = entry.services if entry is not None else {}
        still = [
            f"{name} (pid {service.running.pid})"
            for name, service in services.items()
            if name in names and service.running
        ]
        if still:
            raise ServiceError(
                f"deployment {self._name}: processes that were started before still run: "
                f"{', '.join(still)}; end them first: fairlead down {self._name}"
            )
