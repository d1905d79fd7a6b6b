"""What an operator may ask for: arm, disarm, stop, reset, status; a new episode."""

from __future__ import annotations

from fairlead.messages.message import U64, V1, Message


class StopLevel(Message, frozen=True, kw_only=True, tag=12):
    """`safety/stop`: a protective stop request, repeated until a lease lists ``stop_id``.

    A HAL or gate that reads id 0, or bytes that are no StopLevel, raises a stop under an id of
    its own: a stop that is badly said still stops.
    """

    version: V1 = 1
    stop_id: U64  # random, never 0; cited by the reset
    by: str
    reason: str  # in words


class Refusal(Message, frozen=True, kw_only=True, tag=20):
    """The error reply to any query."""

    version: V1 = 1
    who: str  # the service that refuses
    reason: str  # what and why
    fix: str  # the command that would change the answer, or empty


class Done(Message, frozen=True, kw_only=True, tag=21):
    """The plain success reply."""

    version: V1 = 1
    text: str  # in words


class StatusQuery(Message, frozen=True, kw_only=True, tag=22):
    """Query `safety/status` or `hal/status`. Reply: `GateStatus` or `HalStatus`."""

    version: V1 = 1


class Arm(Message, frozen=True, kw_only=True, tag=23):
    """Query `safety/cmd/arm`: let claims be granted, in a new epoch. Reply: `ArmReply`."""

    version: V1 = 1
    by: str


class ArmReply(Message, frozen=True, kw_only=True, tag=24):
    """The gate is armed: the epoch it opened and the HAL session it follows."""

    version: V1 = 1
    epoch: U64
    session: U64


class Disarm(Message, frozen=True, kw_only=True, tag=25):
    """Query `safety/cmd/disarm`: end every claim; the robot holds. Reply: `Done`."""

    version: V1 = 1
    by: str


class Reset(Message, frozen=True, kw_only=True, tag=26):
    """Query `safety/cmd/reset`: acknowledge one stop or latch. Reply: `Done`."""

    version: V1 = 1
    by: str
    id: U64  # the stop or latch acknowledged


class ResetEpisode(Message, frozen=True, kw_only=True, tag=30):
    """Query `hal/cmd/reset_episode`: a new simulated episode. Reply: `ResetEpisodeReply`."""

    version: V1 = 1
    seed: U64  # of the new episode
    by: str = ""  # who asks; may be absent


class ResetEpisodeReply(Message, frozen=True, kw_only=True, tag=31):
    """The robot stands still in a new scene."""

    version: V1 = 1
    tick: U64  # newest
    episode_tick: U64
    held_ticks: U64  # ticks until still
