"""Who the robot is, what it has, and how it is paced."""

from __future__ import annotations

from typing import Literal

from fairlead.messages.message import U8, U32, U64, V1, Hash32, Message, Record


class ModeRange(Record, frozen=True, kw_only=True):
    """SI command range of one mode of one part, one float64 per controlled value."""

    mode: U8
    lower: bytes
    upper: bytes


class HalPart(Record, frozen=True, kw_only=True):
    """One part as the HAL found it. ``simulator_part`` is "" on hardware."""

    name: str
    simulator_part: str
    joints: tuple[str, ...]
    ranges: tuple[ModeRange, ...]


class HalCamera(Record, frozen=True, kw_only=True):
    """One camera and how many ticks lie between its frames."""

    name: str
    width: U32
    height: U32
    period_ticks: U32


class HalStatus(Message, frozen=True, kw_only=True, tag=5):
    """Who the robot is and how it is paced."""

    version: V1 = 1
    session: U64
    robot: str
    robot_hash: Hash32
    pacing: Literal["realtime", "lockstep"]
    period_ns: U64
    tick: U64
    episode_tick: U64
    state: Literal["ready", "resetting", "holding", "fault"]
    detail: str
    joints: tuple[str, ...]
    passive_joints: tuple[str, ...]
    parts: tuple[HalPart, ...]
    simulator_order: tuple[str, ...]
    cameras: tuple[HalCamera, ...]
    has_task: bool
    overruns: U64
