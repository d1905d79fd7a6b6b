"""The gate as the explorer drives it: events in, messages out, time as an argument."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Protocol

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


class GatePort(Protocol):
    """A gate: the real core in a child process, or a model of it."""

    def step(
        self, now_ns: int, kind: EventKind, source: str = "", payload: bytes = b""
    ) -> list[GateOutput]: ...

    def close(self) -> None: ...
