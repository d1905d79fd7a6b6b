"""The robots that faults are done to, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from tests.faults.live_stage import live_stage

STAGES: Mapping[str, Callable[[Path], AbstractContextManager[Any]]] = {
    "robot": live_stage,
}
"""Each opens in an empty folder."""
