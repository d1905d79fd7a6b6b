"""A deployment of one's own: free ports, an id nobody uses, a state folder made anew.

The demo, ``parity`` and the tests run on copies made here, so they meet neither a
running deployment nor what an earlier run left behind.
"""

from __future__ import annotations

import os
import shutil
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import yaml

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.errors import ConfigError
from fairlead_tools.supervisor.ports import free_ports

_FILE = "deployment.yaml"


@dataclass(frozen=True)
class Scratch:
    """A deployment file in its own fresh folder."""

    file: Path
    deployment: Deployment
    state_dir: Path


@dataclass(frozen=True)
class ScratchOptions:
    """What differs from the copied file.

    options: by service name, merged over the file's own options.
    localiser: who sends ``map -> odom``; "" for the HAL, whatever the file says.
    """

    id: str = ""
    pacing: Literal["realtime", "lockstep"] | None = None
    options: dict[str, dict[str, Any]] = field(default_factory=dict)
    localiser: str = ""


def make_scratch(source: Path, folder: Path, options: ScratchOptions) -> Scratch:
    """Copy ``source`` into ``folder`` (emptied first) as a simulator-only deployment.

    Raises:
        ConfigError: if the source cannot be read, the copy does not fit, or the folder
            holds what was not made here.
    """
    original = load_deployment(source)
    services = original.model_dump(mode="json")["services"]
    for port, (name, spec) in zip(free_ports(len(services)), services.items(), strict=True):
        spec["listen"], spec["host"] = f"tcp/127.0.0.1:{port}", ""  # peers, all of them here
        spec["options"] |= options.options.get(name, {})
    copy = {
        "robot": original.robot,
        "id": options.id or f"{original.id}_{os.getpid()}",
        "namespace": original.namespace,
        "profile": "sim",
        "pacing": options.pacing or original.pacing,
        "localiser": options.localiser,
        "services": services,
    }
    file = folder / _FILE
    try:
        _empty(folder)
        file.write_text(yaml.safe_dump(copy, sort_keys=False), encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"state folder {folder}: cannot be made anew: {error.strerror}") from None
    return Scratch(file, load_deployment(file), folder.absolute())


def _empty(folder: Path) -> None:
    """Make ``folder`` anew, but only if an earlier run made it: it may be somebody's own."""
    if folder.is_dir() and any(folder.iterdir()) and not (folder / _FILE).is_file():
        raise ConfigError(f"state folder {folder}: holds other things; choose another --out")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
