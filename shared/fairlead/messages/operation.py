"""What an operator may ask for: arm, disarm, stop, reset, status; a new episode."""

from __future__ import annotations

from fairlead.messages.message import U64, V1, Message


class StopLevel(Message, frozen=True, kw_only=True, tag=12):
    """A protective stop request, repeated every 50 ms until a lease lists ``stop_id``.

    stop_id: random, never 0. A HAL that reads 0, or bytes that are no StopLevel, raises a
    stop under an id of its own: a stop that is badly said still stops.
    """

    version: V1 = 1
    stop_id: U64
    by: str
    reason: str


class Refusal(Message, frozen=True, kw_only=True, tag=20):
    """The error reply to any query."""

    version: V1 = 1
    who: str
    reason: str
    fix: str


class Done(Message, frozen=True, kw_only=True, tag=21):
    """The plain success reply."""

    version: V1 = 1
    text: str


class StatusQuery(Message, frozen=True, kw_only=True, tag=22):
    """Ask for `GateStatus` or `HalStatus` on their keys."""

    version: V1 = 1


class Arm(Message, frozen=True, kw_only=True, tag=23):
    """Let claims be granted, in a new epoch. Reply: `ArmReply`."""

    version: V1 = 1
    by: str


class ArmReply(Message, frozen=True, kw_only=True, tag=24):
    """The gate is armed: the epoch it opened and the HAL session it follows."""

    version: V1 = 1
    epoch: U64
    session: U64


class Disarm(Message, frozen=True, kw_only=True, tag=25):
    """End every claim; the robot holds. Reply: `Done`."""

    version: V1 = 1
    by: str


class Reset(Message, frozen=True, kw_only=True, tag=26):
    """Acknowledge one stop or latch by its id. Reply: `Done`."""

    version: V1 = 1
    by: str
    id: U64


class ResetEpisode(Message, frozen=True, kw_only=True, tag=30):
    """Start a new simulated episode. Reply: `ResetEpisodeReply`, when standing still."""

    version: V1 = 1
    seed: U64


class ResetEpisodeReply(Message, frozen=True, kw_only=True, tag=31):
    """The robot stands still in a new scene.

    tick: the tick this was seen at. episode_tick: the episode's first tick. held_ticks:
    ticks it was held for since the reset.
    """

    version: V1 = 1
    tick: U64
    episode_tick: U64
    held_ticks: U64
