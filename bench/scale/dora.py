"""The same graph in dora-rs, if it is there, in an environment of its own."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from pathlib import Path

import yaml

from bench.image_move.dora import environment
from bench.scale.measured import Tick, Window
from bench.scale.processes import Process, ended, settle, spending
from bench.scale.traffic import Sent
from bench.tick_watch import with_children
from fairlead.paths import repo_root

START_S = 90.0
WIRES: Mapping[str, tuple[Mapping[str, str], tuple[str, ...]]] = {
    "hal": (
        {"tick": "dora/timer/millis/20", "lease": "gate/lease", "safe": "gate/safe"},
        ("tf", "state"),
    ),
    "gate": (
        {"state": "hal/state", "chunk": "feeder/chunk", "heartbeat": "feeder/heartbeat"},
        ("lease", "verdict", "safe"),
    ),
    "feeder": (
        {
            "beat": "dora/timer/millis/50", "tf": "hal/tf", "state": "hal/state",
            "lease": "gate/lease", "verdict": "gate/verdict",
        },
        ("chunk", "heartbeat"),
    ),
}  # fmt: skip
"""Each node's inputs and outputs, within its robot."""


KEYS = {
    "tf": "tf/", "state": "state/joints", "lease": "safety/lease", "verdict": "safety/verdict/",
    "safe": "action/safe/", "chunk": "action/candidate/", "heartbeat": "skill/",
}  # fmt: skip
"""How the keys of the same messages begin in fairlead."""


def dora(messages: Mapping[str, Sent], count: int, seconds: float, folder: Path) -> Window:
    """So many robots in one dataflow, for so long.

    Args:
        messages: what a robot of fairlead sends; these are as large.
    """
    sizes = {
        name: next(one.size for key, one in messages.items() if key.startswith(start))
        for name, start in KEYS.items()
    }
    nodes = [_node(kind, number, sizes, folder) for number in range(count) for kind in WIRES]
    folder.mkdir(parents=True)
    flow = folder / "flow.yml"
    flow.write_text(yaml.safe_dump({"nodes": nodes}), encoding="utf-8")
    words = [str(environment() / "bin" / "dora"), "run", str(flow)]
    run = Process(words, folder / "dora.log", os.environ, folder)
    try:
        logs = [folder / f"{number}.ticks" for number in range(count)]
        run.wait_for(lambda: all(map(_ticks_of, logs)), "all robots tick", START_S)
        settle("dora-rs", lambda: sum(_moves(log) for log in logs), count)
        own = [pid for pid in with_children(run.pid) if pid != run.pid]
        window = spending({"robots": own, "router": [run.pid]}, seconds)
        ticks = [
            [one for one in _ticks_of(log) if window.began_ns <= one.stamp_ns <= window.ended_ns]
            for log in logs
        ]
    finally:
        ended([run])
    return Window(window, ticks)


def _node(kind: str, number: int, sizes: Mapping[str, int], folder: Path) -> dict[str, object]:
    inputs, outputs = WIRES[kind]
    told = json.dumps({name: sizes[name] for name in outputs}, separators=(",", ":"))
    return {
        "id": f"{kind}{number}",
        "path": str(environment() / "bin" / "python"),
        "args": f"-u -m bench.scale.dora_node {kind} '{told}' {folder / f'{number}.ticks'}",
        "env": {"PYTHONPATH": str(repo_root())},
        "inputs": {name: _own(source, number) for name, source in inputs.items()},
        "outputs": list(outputs),
    }


def _own(source: str, number: int) -> str:
    """The output of this robot's node; a timer is everybody's."""
    node, _, output = source.partition("/")
    return source if node == "dora" else f"{node}{number}/{output}"


def _ticks_of(log: Path) -> list[Tick]:
    if not log.exists():
        return []
    lines = log.read_text(encoding="ascii").rpartition("\n")[0].splitlines()
    numbers = ([int(word) for word in line.split()] for line in lines)
    return [Tick(stamp, lease, bool(moves)) for stamp, lease, moves in numbers]


def _moves(log: Path) -> bool:
    return any(tick.moves for tick in _ticks_of(log)[-1:])
