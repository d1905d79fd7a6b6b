"""What a policy's ``infer`` may return instead of rows: the end of its goal."""

from __future__ import annotations

import re
from dataclasses import dataclass

from fairlead.errors import ConfigError, expected

__all__ = ["Done", "Failed"]


@dataclass(frozen=True)
class Done:
    """The goal is reached: it succeeds, decided by the policy. reason: for people."""

    reason: str


@dataclass(frozen=True)
class Failed:
    """The goal cannot be reached: it fails, decided by the policy.

    Attributes:
        kind: for programs, in lower case: ``goal_outside_zones``.
        reason: for people.

    Raises:
        ConfigError: for another spelling of ``kind``.
    """

    kind: str
    reason: str

    def __post_init__(self) -> None:
        if not re.fullmatch(r"[a-z][a-z0-9_]{0,63}", self.kind):
            form = "1 to 64 of a-z 0-9 _ starting with a letter"
            raise ConfigError(expected("policy: Failed: kind", form, repr(self.kind)))
