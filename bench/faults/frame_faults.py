"""Frames that are no chunk, and chunks of impossible shape: a few of each, and a million."""

from __future__ import annotations

import os
import random
import re
import statistics
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from bench.equipment.gate_scene import Scene
from bench.faults.gate_stage import JUDGED, GateStage, Stopwatch, refused_at_once
from bench.faults.row import Row, Shot
from fairlead.messages import Outcome, encode, pack_floats

RANDOM_FRAMES = 2000
MANY_FRAMES, MANY_VARIABLE = 1_000_000, "FAIRLEAD_FAULT_FRAMES"
BURST = 2_000
GROWTH_KB = 4096
NOBODY = 0xFFFF_FFFF  # far from a claim's number, so one wrong bit does not make it one


def broken_frames(scene: Scene) -> list[bytes]:
    """Frames that are no ActionChunk, from one that is."""
    good, rng = encode(scene.chunk()), random.Random(scene.gate.port)
    flips = []
    for _ in range(50):
        flipped = bytearray(good)
        flipped[rng.randrange(3)] ^= 1 << rng.randrange(8)  # length, type or version
        flips.append(bytes(flipped))
    cut = [good[: rng.randrange(len(good))] for _ in range(50)]
    return [*cut, *flips, good + b"\0", good + bytes(70_000), b"", b"\xc1" * 64]


def bad_shapes(stage: GateStage) -> Shot:
    with stage.ready() as scene:
        watch = Stopwatch()
        shapes = (
            scene.chunk(rows=0), scene.chunk(rows=65), scene.chunk(horizon=9),
            scene.chunk(horizon=2**32 - 1),
            scene.chunk(parts=(scene.arm_part(values=pack_floats(np.zeros((8, 5)))),)),
        )  # fmt: skip
        for chunk in shapes:
            refused_at_once(scene, watch, chunk, 7)
        memory_kb = resident_kb(scene.gate.process.pid)
        rng = random.Random(scene.gate.port)
        frames = [
            *broken_frames(scene),
            *(rng.randbytes(rng.randrange(400)) for _ in range(RANDOM_FRAMES)),
        ]
        for frame in frames:
            scene.send_bytes(frame)
        scene.statuses.wait_for(lambda m: dict(m.counters).get("G001", 0) >= 5)
        assert scene.safe.unread() == [], "a broken frame released rows"
        grown_kb = resident_kb(scene.gate.process.pid) - memory_kb
        assert grown_kb < GROWTH_KB, f"the gate grew by {grown_kb} KiB"
        good_again(scene)
        return watch.shot(f"{len(frames)} broken frames; the gate grew by {grown_kb} KiB")


def good_again(scene: Scene) -> None:
    """After a claim was lost to bad frames, a new one moves the robot."""
    scene.statuses.wait_for(lambda m: not m.claims)
    scene.take_claim()
    verdict = scene.send(scene.chunk())
    assert verdict.outcome == Outcome.RELEASED, verdict


def resident_kb(pid: int) -> int:
    """Resident memory of a process [KiB]."""
    for line in Path(f"/proc/{pid}/status").read_text().splitlines():
        if line.startswith("VmRSS:"):
            return int(line.split()[1])
    raise AssertionError(f"process {pid} has no memory")


def mutants(good: bytes, rng: random.Random) -> Iterator[bytes]:
    """Without end: random bytes, and a good frame with some bits or its end changed."""
    while True:
        yield rng.randbytes(rng.randrange(400))
        yield good[: rng.randrange(len(good))]
        for flips in (1, 1, 8):
            changed = bytearray(good)
            for _ in range(flips):
                changed[rng.randrange(len(changed))] ^= 1 << rng.randrange(8)
            yield bytes(changed)


def judged(scene: Scene) -> int:
    """Chunks and other frames that the gate has refused so far, by its own counters."""
    return sum(count for code, count in scene.status().counters if code.startswith("G"))


def count_left_out(line: str) -> int:
    """How many candidates a line of the gate's log leaves out."""
    told = re.search(r"candidates left out unread: (\d+) .*, (\d+) copies, (\d+) beyond", line)
    return sum(map(int, told.groups())) if told else 0


def many_frames(stage: GateStage) -> Shot:
    """Bursts as fast as they can be sent, none of the claim's own: a few a second get a turn.

    The gate accounts for each: judged, or counted among those that it left out; what it says
    nothing of was lost on the way, and is sent again.
    """
    wanted = int(os.environ.get(MANY_VARIABLE, MANY_FRAMES))
    with stage.ready() as scene:
        began_ns, pid = time.monotonic_ns(), scene.gate.process.pid
        good = encode(scene.chunk(claim_id=scene.claim_id ^ NOBODY))
        frames = mutants(good, random.Random(20))
        before, left_out, warm_kb, sent = judged(scene), 0, 0, 0
        while (done := judged(scene) - before) + left_out < wanted:
            for _ in range(min(BURST, wanted - done - left_out)):
                scene.send_bytes(next(frames))
                sent += 1
            left_out += sum(map(count_left_out, scene.gate.new_lines()))
            warm_kb = warm_kb or resident_kb(pid)
        assert done + left_out <= sent, (done, left_out, sent)
        grown_kb, seconds = resident_kb(pid) - warm_kb, (time.monotonic_ns() - began_ns) / 1e9
        verdicts = scene.verdicts.unread()
        assert done and verdicts and {v.outcome for v in verdicts} == {Outcome.REFUSED}
        assert scene.safe.unread() == [], "a broken frame released rows"
        assert grown_kb < GROWTH_KB, f"the gate grew by {grown_kb} KiB"
        verdict = scene.send(scene.chunk())
        assert verdict.outcome == Outcome.RELEASED, verdict
    note = (
        f"{done} frames judged and {left_out} left out in {seconds:.0f} s; the gate grew by "
        f"{grown_kb} KiB"
    )
    taken_ms = [verdict.latency_ns / 1e6 for verdict in verdicts]
    p99_ms = statistics.quantiles(taken_ms, n=100)[98]
    return Shot(p99_ms, began_ns, time.monotonic_ns(), None, note, also=max(taken_ms))


ROWS = (
    Row(
        20, "wrong horizons, wrong widths; cut, flipped, oversized, empty, random frames",
        "refused; the gate grows by less than 4 MiB",
        1, "gate", bad_shapes, JUDGED, 5,
    ),
    Row(
        20, f"{MANY_FRAMES:,} random and mutated frames in bursts",
        "refused; the gate grows by less than 4 MiB",
        1, "gate", many_frames, f"{JUDGED}: 99 of 100 within", 1, "the longest",
    ),
)  # fmt: skip
