"""Every error fairlead raises on purpose.

    FairleadError
    ├── ConfigError        a file, manifest, argument or width that does not fit
    ├── MessageError       bytes on a key that are not the message they should be
    ├── LayoutError        a state vector that cannot be assembled (frame, joint, age)
    ├── PolicyError        a policy that failed, hung, or returned the wrong shape
    ├── RefusedError       another service answered "no"; carries its Refusal
    ├── ChunkRefusedError  the gate refused rows; carries its Verdict
    ├── ClaimLostError     parts that were held are held no longer
    ├── ServiceError       a process of a deployment that died, hung or cannot be started
    ├── NoAnswerError      nobody answered a query before its deadline
    ├── HardwareError      a device that does not answer, or that has failed
    └── TransportError     the Zenoh session could not be opened or has closed

A message always says who is complaining, what it expected, what it got, and,
where there is a closed set of choices, the choices.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING, Literal

if TYPE_CHECKING:
    from fairlead.messages import Verdict

__all__ = [
    "ChunkRefusedError",
    "ClaimLostError",
    "ConfigError",
    "FairleadError",
    "HardwareError",
    "LayoutError",
    "MessageError",
    "NoAnswerError",
    "PolicyError",
    "RefusedError",
    "ServiceError",
    "TransportError",
    "expected",
]


class FairleadError(Exception):
    """Base of every deliberate error; the command line prints it without a traceback."""


class ConfigError(FairleadError):
    """A file, manifest, argument or array width that does not fit."""


class MessageError(FairleadError):
    """Bytes that are not the message their key promises."""


LayoutFailure = Literal[
    "missing_frame", "stale_frame", "contested_frame", "loop", "missing_joint", "missing_tick",
    "not_finite", "wrong_width", "unknown_skill", "no_assembler", "failed",
]  # fmt: skip
"""Why a layout vector cannot be assembled."""


class LayoutError(FairleadError):
    """A layout vector cannot be assembled.

    Attributes:
        kind: why, for programs.
        name: the frame, joint or layout concerned.
        parent: the frame the lookup started from, "" where there is none.
        age_ticks: how old the newest usable transform is, in ticks; -1 if there is none.
        is_certain: no message that may still be on its way can mend it.
    """

    def __init__(
        self,
        message: str,
        *,
        kind: LayoutFailure,
        name: str,
        parent: str = "",
        age_ticks: int = -1,
        is_certain: bool = False,
    ) -> None:
        super().__init__(message)
        self.kind = kind
        self.name = name
        self.parent = parent
        self.age_ticks = age_ticks
        self.is_certain = is_certain


class PolicyError(FairleadError):
    """A policy failed, hung, or returned something that is not ``[H, dim]`` finite numbers."""


class RefusedError(FairleadError):
    """A service refused a query.

    Attributes:
        who: the refusing service.
        reason: what it refused and why.
        fix: the command that would change the answer, "" if there is none.
    """

    def __init__(self, who: str, reason: str, fix: str = "") -> None:
        super().__init__(f"{who} refused: {reason}" + (f"\n  try: {fix}" if fix else ""))
        self.who = who
        self.reason = reason
        self.fix = fix


class ChunkRefusedError(FairleadError):
    """The gate refused a chunk; rows that it released before still act.

    Attributes:
        verdict: the gate's whole answer: code, row, part, axis, value and limit.
    """

    def __init__(self, message: str, verdict: Verdict) -> None:
        super().__init__(f"safety refused: {message}\n  try: fairlead why")
        self.verdict = verdict


class ClaimLostError(FairleadError):
    """Parts that a program held are held no longer: they stand still, and rows are refused."""


class ServiceError(FairleadError):
    """A process of a deployment died, did not become ready, or cannot be started."""


class NoAnswerError(FairleadError):
    """No service answered a query before its deadline."""


class HardwareError(FairleadError):
    """A device does not answer, or says that it has failed."""


class TransportError(FairleadError):
    """The Zenoh session could not be opened, or has closed."""


def expected(who: str, what: str, got: object, choices: Iterable[str] = ()) -> str:
    """Format one complaint: ``who: expected what, got got (valid: a, b)``."""
    listed = ", ".join(choices)
    return f"{who}: expected {what}, got {got}" + (f" (valid: {listed})" if listed else "")


def each_error(error: Exception) -> Iterator[Exception]:
    """The errors in a group, or the error itself."""
    if isinstance(error, ExceptionGroup):
        for one in error.exceptions:
            yield from each_error(one)
    else:
        yield error
