"""Run in dora's environment: both nodes of a dataflow that moves pictures."""

from __future__ import annotations

import importlib
import json
import sys
from pathlib import Path

from bench.image_move.pictures import CASES, PATIENCE_S, Arrivals, Case, ticks


def send(case: Case, count: int) -> None:
    """The camera."""
    node, arrow = importlib.import_module("dora").Node(), importlib.import_module("pyarrow")
    for pictures in ticks(case, count):
        for number, one in enumerate(pictures):
            node.send_output(f"camera{number}", arrow.array(one.reshape(-1)), {})
    node.next(timeout=PATIENCE_S)  # until the other end is done


def receive(case: Case, count: int, result: Path) -> None:
    """Who wants arrays."""
    node, arrivals = importlib.import_module("dora").Node(), Arrivals(case, count)
    for event in node:
        if event["type"] == "INPUT":
            pixels = event["value"].to_numpy(zero_copy_only=True)
            if arrivals.add(pixels.reshape(case.height, case.width, 3)):
                break
    result.write_text(json.dumps(arrivals.latencies_us))


def main() -> None:
    """``python -m bench.image_move.dora_node send|receive CASE COUNT RESULT``."""
    end, name, count, result = sys.argv[1:]
    case = next(one for one in CASES if one.name == name)
    if end == "send":
        send(case, int(count))
    else:
        receive(case, int(count), Path(result))


if __name__ == "__main__":
    main()
