"""What the runner and its policy worker process say to each other.

msgpack over a socket pair on one host, each message after its length; never pickle. The worker
answers every request with exactly one `Answer`, `Ended` or `Raised`.
"""

from __future__ import annotations

import struct
from typing import Any

import msgspec
import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, PolicyError
from fairlead.plugins import Plugin
from fairlead.policy import (
    Actions,
    Done,
    Executed,
    Failed,
    Judged,
    Observation,
    PastAnswer,
)
from fairlead.reason_text import reason_of, short_text
from fairlead_skill_runner.action_rows import float_rows, policy_rows

HEADER = struct.Struct("!I")
"""The length of the message that follows, in bytes."""

_WITH_TIME = 4  # dimensions of a picture's frames

_TEXT_MAX = 100_000
"""Characters of what a policy says."""


def reply_max_bytes(dim: int, horizon: int) -> int:
    """No reply is longer: rows of float32, or a text."""
    return 4 * dim * horizon + 10 * _TEXT_MAX


class Load(msgspec.Struct, frozen=True, tag=True):
    """Import ``policy`` and build it. skill, options: JSON.

    robot: its id; profile: which of its safety profiles holds.
    """

    policy: Plugin
    skill: str
    options: str
    robot: str
    profile: str


class Reset(msgspec.Struct, frozen=True, tag=True):
    """Call the policy's ``reset``."""


class Picture(msgspec.Struct, frozen=True):
    """One array as the skill declares it, or ``[T, ...]`` of all its frames."""

    name: str
    dtype: str
    shape: tuple[int, ...]
    data: bytes

    @classmethod
    def of(cls, name: str, array: npt.NDArray[Any]) -> Picture:
        """Pack a picture for the pipe."""
        return cls(name, array.dtype.str, array.shape, array.tobytes())

    def array(self) -> npt.NDArray[Any]:
        """The array again."""
        return np.frombuffer(self.data, dtype=self.dtype).reshape(self.shape)


class Past(msgspec.Struct, frozen=True):
    """One `PastAnswer`; its masks are bytes of 0 and 1."""

    tick: int
    shape: tuple[int, ...]
    rows: bytes
    periods: int
    outcome: str
    masks: tuple[bytes, bytes, bytes]

    @classmethod
    def of(cls, past: PastAnswer) -> Past:
        """Pack it for the pipe."""
        masks = (past.acted.tobytes(), past.refused.tobytes(), past.to_act.tobytes())
        rows = np.ascontiguousarray(past.rows, dtype="<f4")
        return cls(past.tick, rows.shape, rows.tobytes(), past.periods, past.outcome, masks)

    def answer(self) -> PastAnswer:
        """The same again."""
        acted, refused, to_act = map(_mask, self.masks)
        rows = np.frombuffer(self.rows, dtype="<f4").reshape(self.shape)
        return PastAnswer(self.tick, rows, self.periods, self.outcome, acted, refused, to_act)


def _mask(data: bytes) -> npt.NDArray[np.bool_]:
    return np.frombuffer(data, dtype=np.bool_)


class Infer(msgspec.Struct, frozen=True, tag=True):
    """Call the policy's ``infer``; state and earlier states are float64."""

    tick: int
    state: bytes
    earlier: bytes
    prompt: str
    pictures: tuple[Picture, ...]
    executed: dict[str, Executed]
    judged: Judged | None
    answers: tuple[Past, ...]
    delay_ticks: int
    periods: int

    @classmethod
    def of(cls, observation: Observation) -> Infer:
        """Pack an observation for the pipe."""
        frames = observation.frames
        pictures = tuple(
            Picture.of(name, frames.get(name, image)) for name, image in observation.images.items()
        )
        state = np.ascontiguousarray(observation.state, dtype="<f8").tobytes()
        earlier = np.ascontiguousarray(observation.earlier, dtype="<f8").tobytes()
        return cls(
            observation.tick,
            state,
            earlier,
            observation.prompt,
            pictures,
            dict(observation.executed),
            observation.judged,
            tuple(map(Past.of, observation.answers)),
            observation.delay_ticks,
            observation.periods,
        )

    def observation(self) -> Observation:
        """The observation again, bit for bit; arrays are views of the received bytes."""
        seen = {picture.name: picture.array() for picture in self.pictures}
        frames = {name: pixels for name, pixels in seen.items() if pixels.ndim == _WITH_TIME}
        images = {name: frames[name][-1] if name in frames else seen[name] for name in seen}
        state = np.frombuffer(self.state, dtype="<f8")
        return Observation(
            self.tick,
            state,
            self.prompt,
            images,
            self.executed,
            self.judged,
            frames,
            tuple(past.answer() for past in self.answers),
            self.delay_ticks,
            np.frombuffer(self.earlier, dtype="<f8").reshape(-1, len(state)),
            self.periods,
        )


class Answer(msgspec.Struct, frozen=True, tag=True):
    """Done; the array, of float32, is empty for everything but `Infer`."""

    shape: tuple[int, ...] = (0,)
    data: bytes = b""


class Ended(msgspec.Struct, frozen=True, tag=True):
    """The policy ended its goal; kind is "" if it is done."""

    kind: str
    reason: str

    @classmethod
    def of(cls, end: Done | Failed) -> Ended:
        """Pack an end for the pipe."""
        reason = short_text(str(end.reason), _TEXT_MAX)
        return cls(end.kind if isinstance(end, Failed) else "", reason)

    def end(self) -> Done | Failed:
        """What the policy returned.

        Raises:
            PolicyError: it is none.
        """
        try:
            return Failed(self.kind, self.reason) if self.kind else Done(self.reason)
        except ConfigError as error:
            raise PolicyError(f"policy worker: not an end: {error}") from None


class Raised(msgspec.Struct, frozen=True, tag=True):
    """The policy raised."""

    text: str

    @classmethod
    def of(cls, error: BaseException) -> Raised:
        """Pack what it said for the pipe."""
        return cls(reason_of(error, _TEXT_MAX))


Request = Load | Reset | Infer
Reply = Answer | Ended | Raised

_ENCODER = msgspec.msgpack.Encoder()
_REQUESTS: msgspec.msgpack.Decoder[Request] = msgspec.msgpack.Decoder(Request)
_REPLIES: msgspec.msgpack.Decoder[Reply] = msgspec.msgpack.Decoder(Reply)


def encode(message: Request | Reply) -> bytes:
    """One message for the pipe, as msgpack."""
    return _ENCODER.encode(message)


def decode_request(data: bytes) -> Request:
    """Decode what the runner sent; its own worker is asked nothing else."""
    return _REQUESTS.decode(data)


def decode_reply(data: bytes) -> Reply:
    """Raises `PolicyError` for bytes that are no reply: a policy may write to any file it has."""
    try:
        return _REPLIES.decode(data)
    except (ValueError, RecursionError) as error:  # msgspec's own errors are ValueErrors
        raise PolicyError(f"policy worker: not a reply: {error}") from None


def pack_actions(actions: object, dim: int, horizon: int) -> Answer:
    """A policy's return value for the pipe.

    Raises:
        PolicyError: as `check_actions`.
    """
    rows = policy_rows(actions, dim, horizon)
    return Answer(rows.shape, rows.tobytes())


def check_actions(answer: Answer, dim: int, horizon: int) -> Actions:
    """The rows of an answer: float32 ``[H, dim]``, 1 <= H <= horizon, all finite.

    Raises:
        PolicyError: for any other shape or value.
    """
    try:
        array = np.frombuffer(answer.data, dtype="<f4").reshape(answer.shape)
    except ValueError as error:
        raise PolicyError(f"policy worker: not rows of float32: {error}") from None
    return float_rows("policy worker", "actions", array, dim, horizon)
