"""Where a lockstep tick goes: what a listener hears of it, and what each process spent on it."""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

from fairlead.keys import Keys
from fairlead.messages import (
    ActionChunk,
    Decision,
    JointState,
    LayoutState,
    Lease,
    Message,
    decode,
)
from fairlead.wire.bus import Bus, Sample

NS_PER_MS = 1e6


@dataclass(frozen=True)
class Spent:
    """By one process since it started: on a processor and waiting for one [ms]; memory [MB]."""

    running_ms: float
    waiting_ms: float
    memory_mb: float

    def since(self, before: Spent) -> Spent:
        """The time of the interval; memory as it is now."""
        return Spent(
            self.running_ms - before.running_ms,
            self.waiting_ms - before.waiting_ms,
            self.memory_mb,
        )

    def a_tick(self, ticks: int) -> Spent:
        """The time of one of so many ticks."""
        return Spent(self.running_ms / ticks, self.waiting_ms / ticks, self.memory_mb)


def spent(pid: int, alone: bool = False) -> Spent:
    """What the kernel counts for a process and its children: a policy has a process of its own.

    Args:
        alone: without its children.
    """
    running = waiting = 0.0
    memory_kb = 0
    for one in [pid] if alone else with_children(pid):
        folder = Path(f"/proc/{one}")
        for thread in (folder / "task").iterdir():
            with suppress(FileNotFoundError):
                on, off, _ = (thread / "schedstat").read_text().split()
                running, waiting = running + int(on), waiting + int(off)
        status = dict(
            line.split(":", 1)
            for line in (folder / "status").read_text().splitlines()
            if ":" in line
        )
        memory_kb += int(status["VmRSS"].split()[0])
    return Spent(running / NS_PER_MS, waiting / NS_PER_MS, memory_kb / 1024)


def with_children(pid: int) -> Iterable[int]:
    """A process and all that come of it."""
    yield pid
    for thread in Path(f"/proc/{pid}/task").iterdir():
        with suppress(FileNotFoundError):  # a thread, or a child, that ended meanwhile
            for child in (thread / "children").read_text().split():
                yield from with_children(int(child))


@dataclass
class TickWatch:
    """Hears a robot's ticks on its bus, with the time at which each message came."""

    bus: Bus
    keys: Keys
    skill: str
    source: str
    heard: list[tuple[int, type[Message], bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        for key, kind in (
            (self.keys.joints, JointState),
            (self.keys.layout(self.skill), LayoutState),
            (self.keys.candidate(self.source), ActionChunk),
            (self.keys.lease, Lease),
        ):
            self._listen(key, kind)

    def _listen(self, key: str, kind: type[Message]) -> None:
        def hear(sample: Sample) -> None:
            self.heard.append((time.monotonic_ns(), kind, sample.payload))

        self.bus.subscribe(key, hear)

    def segments(self) -> dict[str, dict[str, float]]:
        """Medians [ms]: of ticks inside a chunk, and of ticks that wait for the next one."""
        came = self._first_times()
        inside: dict[str, list[float]] = {}
        waited: dict[str, list[float]] = {}
        for tick, state in came[JointState].items():
            lease, after = came[Lease].get(tick), came[JointState].get(tick + 1)
            if lease is None or after is None:
                continue
            vector, chunk = came[LayoutState].get(tick), came[ActionChunk].get(tick)
            if chunk is None:
                _note(inside, {"gate": lease - state, "HAL": after - lease})
            elif vector is not None and vector <= chunk <= lease:
                _note(
                    waited,
                    {
                        "assembler": vector - state,
                        "runner": chunk - vector,
                        "gate": lease - chunk,
                        "HAL": after - lease,
                    },
                )
        return {"inside a chunk": _medians(inside), "waits for a chunk": _medians(waited)}

    def _first_times(self) -> Mapping[type[Message], dict[int, int]]:
        """By kind and tick: when the first message came that lets the tick go on."""
        came: dict[type[Message], dict[int, int]] = {
            kind: {} for kind in (JointState, LayoutState, ActionChunk, Lease)
        }
        for at_ns, kind, payload in self.heard:
            message = decode(kind, payload)
            match message:
                case JointState() | LayoutState():
                    tick = message.tick
                case ActionChunk():
                    tick = message.start_tick
                case Lease() if any(one.decision == Decision.ROW for one in message.grants):
                    tick = message.state_tick
                case _:
                    continue
            came[kind].setdefault(tick, at_ns)
        return came


def _note(into: dict[str, list[float]], segments: Mapping[str, int]) -> None:
    for name, ns in segments.items():
        into.setdefault(name, []).append(ns / NS_PER_MS)
    into.setdefault("tick", []).append(sum(segments.values()) / NS_PER_MS)


def _medians(segments: Mapping[str, list[float]]) -> dict[str, float]:
    found = {name: statistics.median(values) for name, values in segments.items()}
    return found | {"ticks": float(len(segments.get("tick", ())))}
