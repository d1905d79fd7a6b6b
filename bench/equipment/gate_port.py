"""What goes into the gate core and what comes out of it; time is an argument."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

EventKind = Literal[
    "timer",
    "joint_state",
    "candidate",
    "hal_status",
    "heartbeat",
    "stop_level",
    "arm",
    "disarm",
    "reset",
    "claim",
    "release",
    "status",
]

OutputKind = Literal["safe_chunk", "verdict", "lease", "status", "reply", "refusal", "other"]


@dataclass(frozen=True)
class GateOutput:
    """One thing the gate wants published or answered."""

    kind: OutputKind
    source: str
    payload: bytes
