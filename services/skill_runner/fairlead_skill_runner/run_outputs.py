"""What a goal's core wants done, and what its policy says."""

from __future__ import annotations

from dataclasses import dataclass

from fairlead.errors import PolicyError
from fairlead.policy import Actions, Done, Failed, Observation


@dataclass(frozen=True)
class SendChunk:
    """Publish these bytes on the candidate key."""

    payload: bytes


@dataclass(frozen=True)
class AskPolicy:
    """Ask the policy; bring its answer to `RunCore.on_policy` with the same call number."""

    call: int
    observation: Observation


Output = SendChunk | AskPolicy
PolicyAnswer = Actions | Done | Failed | PolicyError
