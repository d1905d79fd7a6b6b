"""Chunks that no sender should send."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from bench.equipment.case import Chunk, PartRows
from tests.differential.gate_file import JOINT_MODES, WIDTHS, GateFile

NUMBERS = (
    np.nan,
    np.inf,
    -np.inf,
    5e-324,
    -5e-324,
    2.2250738585072014e-308,
    1e6,
    -1e6,
    float(np.nextafter(1e6, np.inf)),
    -float(np.nextafter(1e6, np.inf)),
    1e308,
    -0.0,
    0.0,
)
U32_MAX = 2**32 - 1
MODE_NUMBERS = (*range(14), 255)
Rng = np.random.Generator
Spoiler = Callable[[GateFile, Chunk, int, Rng], Chunk]


def spoil(file: GateFile, chunk: Chunk, tick: int, rng: Rng) -> tuple[Chunk, str]:
    """The chunk with one or two things wrong, and their names."""
    names = []
    for _ in range(int(rng.integers(1, 3))):
        name = "a number" if rng.random() < 0.25 else str(rng.choice(list(SPOILERS)))
        chunk = SPOILERS[name](file, chunk, tick, rng)
        names.append(name)
    return _as_read(file, chunk), " and ".join(names)


def _as_read(file: GateFile, chunk: Chunk) -> Chunk:
    """The blocks have no width of their own: where the numbers fit, they are read as rows."""

    def read(rows: PartRows) -> PartRows:
        is_known = rows.mode in JOINT_MODES or rows.mode in WIDTHS
        width = file.width(rows.mode) if is_known else 0
        if rows.values.size != chunk.horizon * width or rows.values.size == 0:
            return rows
        return replace(rows, values=rows.values.reshape(chunk.horizon, width))

    return replace(chunk, parts=tuple(read(rows) for rows in chunk.parts))


def _one(chunk: Chunk, rng: Rng, change: Callable[[PartRows], PartRows]) -> Chunk:
    """Change one of the parts."""
    if not chunk.parts:
        return chunk
    at = int(rng.integers(len(chunk.parts)))
    parts = list(chunk.parts)
    parts[at] = change(parts[at])
    return replace(chunk, parts=tuple(parts))


def _number(_: GateFile, chunk: Chunk, __: int, rng: Rng) -> Chunk:
    def change(rows: PartRows) -> PartRows:
        values = rows.values.copy()
        if values.size:
            values.flat[int(rng.integers(values.size))] = rng.choice(NUMBERS)
        return replace(rows, values=values)

    return _one(chunk, rng, change)


def _width(_: GateFile, chunk: Chunk, __: int, rng: Rng) -> Chunk:
    def change(rows: PartRows) -> PartRows:
        if rng.random() < 0.5:
            return replace(rows, values=rows.values[:, :-1])
        return replace(rows, values=np.hstack([rows.values, rows.values[:, :1]]))

    return _one(chunk, rng, change)


def _horizon(_: GateFile, chunk: Chunk, __: int, rng: Rng) -> Chunk:
    return replace(
        chunk, horizon=int(rng.choice([0, min(chunk.horizon + 1, U32_MAX), 65, U32_MAX]))
    )


def _long(_: GateFile, chunk: Chunk, __: int, rng: Rng) -> Chunk:
    """Rows without end: the last one again and again, up to and beyond what a chunk may have."""
    count = int(rng.choice([63, 64, 65]))
    parts = tuple(
        replace(rows, values=np.repeat(rows.values[-1:], count, axis=0)) for rows in chunk.parts
    )
    return replace(chunk, horizon=count, parts=parts)


def _mask(file: GateFile, chunk: Chunk, _: int, rng: Rng) -> Chunk:
    n = len(file.joints)
    masks = [(), (0,), (n - 1,), (n,), (1, 0), (0, 0), tuple(range(n)), (200,)]
    return _one(chunk, rng, lambda rows: replace(rows, active=masks[rng.integers(len(masks))]))


def _frame(_: GateFile, chunk: Chunk, __: int, rng: Rng) -> Chunk:
    frame = str(rng.choice(["", "odom", "base_link", "x" * 60]))
    return _one(chunk, rng, lambda rows: replace(rows, frame=frame))


def _mode(_: GateFile, chunk: Chunk, __: int, rng: Rng) -> Chunk:
    mode = int(rng.choice(MODE_NUMBERS))
    return _one(chunk, rng, lambda rows: replace(rows, mode=mode))


def _part(file: GateFile, chunk: Chunk, _: int, rng: Rng) -> Chunk:
    part = int(rng.choice([*range(len(file.parts) + 1), 255]))
    return _one(chunk, rng, lambda rows: replace(rows, part=part))


def _twice(_: GateFile, chunk: Chunk, __: int, rng: Rng) -> Chunk:
    if not chunk.parts or len(chunk.parts) >= 8:
        return chunk
    return replace(chunk, parts=(*chunk.parts, chunk.parts[int(rng.integers(len(chunk.parts)))]))


def _padding(_: GateFile, chunk: Chunk, __: int, rng: Rng) -> Chunk:
    def change(rows: PartRows) -> PartRows:
        values = rows.values.copy()
        if values.size:
            values[:, rng.integers(values.shape[1])] = rng.choice([5e-324, 1e-9, -1.0])
        return replace(rows, values=values)

    return _one(chunk, rng, change)


def _start(_: GateFile, chunk: Chunk, tick: int, rng: Rng) -> Chunk:
    starts = [0, max(0, tick - chunk.horizon), tick - 1, tick + 1, tick + 2, 2**64 - 1]
    return replace(chunk, start_tick=min(int(starts[rng.integers(len(starts))]), 2**64 - 1))


def _nothing(_: GateFile, chunk: Chunk, __: int, ___: Rng) -> Chunk:
    return replace(chunk, parts=())


SPOILERS: dict[str, Spoiler] = {
    "a number": _number,
    "a width": _width,
    "a horizon": _horizon,
    "a long chunk": _long,
    "a mask": _mask,
    "a frame": _frame,
    "a mode": _mode,
    "a part": _part,
    "a part twice": _twice,
    "padding": _padding,
    "a start": _start,
    "no parts": _nothing,
}
