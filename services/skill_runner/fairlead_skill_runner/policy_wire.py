"""What the runner and its policy worker process say to each other.

msgpack over a socket pair on one host, each message after its length; never pickle. The worker
answers every request with exactly one `Answer`, `Ended` or `Raised`.
"""

from __future__ import annotations

import struct

import msgspec
import numpy as np

from fairlead.errors import PolicyError
from fairlead.plugins import Plugin
from fairlead.policy import Actions, Done, Executed, Failed, Judged, Observation

HEADER = struct.Struct("!I")
"""The length of the message that follows, in bytes."""


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
    """One uint8 ``[height, width, 3]`` array."""

    name: str
    height: int
    width: int
    data: bytes


class Infer(msgspec.Struct, frozen=True, tag=True):
    """Call the policy's ``infer``; state is float64."""

    tick: int
    state: bytes
    prompt: str
    pictures: tuple[Picture, ...]
    executed: dict[str, Executed]
    judged: Judged | None

    @classmethod
    def of(cls, observation: Observation) -> Infer:
        """Pack an observation for the pipe."""
        pictures = tuple(
            Picture(name, image.shape[0], image.shape[1], image.tobytes())
            for name, image in observation.images.items()
        )
        state = np.ascontiguousarray(observation.state, dtype="<f8").tobytes()
        return cls(
            observation.tick,
            state,
            observation.prompt,
            pictures,
            dict(observation.executed),
            observation.judged,
        )

    def observation(self) -> Observation:
        """The observation again, bit for bit; arrays are views of the received bytes."""
        images = {
            p.name: np.frombuffer(p.data, dtype=np.uint8).reshape(p.height, p.width, 3)
            for p in self.pictures
        }
        state = np.frombuffer(self.state, dtype="<f8")
        return Observation(self.tick, state, self.prompt, images, self.executed, self.judged)


class Answer(msgspec.Struct, frozen=True, tag=True):
    """Done; the array is empty for everything but `Infer`."""

    dtype: str = "float32"
    shape: tuple[int, ...] = (0,)
    data: bytes = b""


class Ended(msgspec.Struct, frozen=True, tag=True):
    """The policy ended its goal; kind is "" if it is done."""

    kind: str
    reason: str

    @classmethod
    def of(cls, end: Done | Failed) -> Ended:
        """Pack an end for the pipe."""
        return cls(end.kind if isinstance(end, Failed) else "", str(end.reason))

    def end(self) -> Done | Failed:
        """What the policy returned."""
        return Failed(self.kind, self.reason) if self.kind else Done(self.reason)


class Raised(msgspec.Struct, frozen=True, tag=True):
    """The policy raised."""

    text: str


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
    """Raises `PolicyError` for bytes that are no reply."""
    try:
        return _REPLIES.decode(data)
    except msgspec.DecodeError as error:
        raise PolicyError(f"policy worker: not a reply: {error}") from None


def pack_actions(actions: object) -> Answer:
    """A policy's return value for the pipe, as it is; `check_actions` judges it there.

    Raises:
        PolicyError: for a masked array, whose masked numbers would come back to life.
    """
    if isinstance(actions, np.ma.MaskedArray):
        raise PolicyError("policy: expected an array without masked numbers, got a masked array")
    array = np.asarray(actions)
    return Answer(str(array.dtype), array.shape, array.tobytes())


def check_actions(answer: Answer, dim: int, horizon: int) -> Actions:
    """The rows of an answer: float32 ``[H, dim]``, 1 <= H <= horizon, all finite.

    Discarded dimensions count too: a policy that says NaN anywhere is not in order.

    Raises:
        PolicyError: for any other type, shape or value.
    """
    got = f"{answer.dtype} {list(answer.shape)}"
    fits = len(answer.shape) == 2 and 1 <= answer.shape[0] <= horizon and answer.shape[1] == dim
    if answer.dtype != "float32" or not fits:
        raise PolicyError(f"policy: expected float32 [1 to {horizon}, {dim}], got {got}")
    actions = np.frombuffer(answer.data, dtype="<f4").reshape(answer.shape)
    if not np.isfinite(actions).all():
        row, column = np.argwhere(~np.isfinite(actions))[0]
        raise PolicyError(
            f"policy: expected finite numbers, got {actions[row, column]} in row {row} "
            f"dimension {column}"
        )
    return actions
