"""The shipped deployment of two hosts, with other addresses."""

from __future__ import annotations

from typing import Any

import yaml

from fairlead.paths import repo_root

COMPOSE = repo_root() / "compose"
FILES = [COMPOSE / f"panda_mobile_two_hosts{pacing}.yaml" for pacing in ("", "_realtime")]
HERE, ELSEWHERE = "127.0.0.1", "192.0.2.1"  # the second is reserved for documents


def content(**changes: Any) -> dict[str, Any]:
    """The shipped file on this machine and one elsewhere, with other top-level keys."""
    read: dict[str, Any] = yaml.safe_load(FILES[0].read_text(encoding="utf-8"))
    return read | {"hosts": {"robot": HERE, "gpu": ELSEWHERE}} | changes
