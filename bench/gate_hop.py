"""What the gate costs: candidate in to SafeChunk out, beside a relay that decides nothing.

Both are C++ processes on the same Zenoh library, driven alternately from this process with
the same bytes, so that what the machine does to one it does to the other.

    .venv/bin/python -m bench.gate_hop [--count 2000] [--count-20hz 200] [--rows 8] [--json]

Prints medians and 99th percentiles [us] and their ratio, back to back and at 20 Hz.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from fairlead.messages import ActionChunk, Message, Verdict, encode
from fairlead.paths import gate_binary, gate_config
from fairlead.wire.bus import Bus, Qos, Sample
from fairlead.wire.session import Endpoints, ZenohBus
from tests.gate.running_gate import ROBOT, free_port
from tests.gate.scene import Scene

DEADLINE_S = 10.0
KEY_IN, KEY_OUT = "fl/bench/relay_in", "fl/bench/relay_out"


class Arrival:
    """When the next message on a key arrives here."""

    def __init__(self, bus: Bus, key: str) -> None:
        self._event = threading.Event()
        self._at_ns = 0
        bus.subscribe(key, self._on_sample)

    def _on_sample(self, sample: Sample) -> None:
        self._at_ns = time.perf_counter_ns()
        self._event.set()

    def after(self, send: Callable[[bytes], None], payload: bytes) -> float:
        """Microseconds from just before ``send(payload)`` to the arrival."""
        self._event.clear()
        start_ns = time.perf_counter_ns()
        send(payload)
        if not self._event.wait(DEADLINE_S):
            raise SystemExit("gate_hop: a message was lost; run it again")
        return (self._at_ns - start_ns) / 1e3


class Relay:
    """The bare relay's process and a session connected to it."""

    def __init__(self, kind: type[Message]) -> None:
        port = free_port()
        binary = gate_binary().with_name("bare-relay")
        endpoint = f"tcp/127.0.0.1:{port}"
        self.process = subprocess.Popen(
            [str(binary), endpoint, KEY_IN, KEY_OUT], stdout=subprocess.PIPE, text=True
        )
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"
        self.bus = ZenohBus(Endpoints(connect=[endpoint]))
        self.arrival = Arrival(self.bus, KEY_OUT)
        self.publisher = self.bus.publisher(KEY_IN, kind, Qos.HOT)

    def close(self) -> None:
        """Leave the session and end the relay's process."""
        self.bus.close()
        self.process.terminate()
        self.process.communicate(timeout=DEADLINE_S)


@dataclass
class Samples:
    """Round trips [us] and the gate's own share of its."""

    relay_us: list[float] = field(default_factory=list)
    gate_us: list[float] = field(default_factory=list)
    decision_us: list[float] = field(default_factory=list)

    def report(self) -> dict[str, float]:
        """Medians and 99th percentiles [us], and how much longer the way through the gate is."""
        relay, gate = np.array(self.relay_us), np.array(self.gate_us)
        return {
            "relay_p50_us": float(np.median(relay)),
            "relay_p99_us": float(np.percentile(relay, 99)),
            "gate_p50_us": float(np.median(gate)),
            "gate_p99_us": float(np.percentile(gate, 99)),
            "gate_receipt_to_verdict_p50_us": float(np.median(self.decision_us)),
            "ratio_p50": float(np.median(gate) / np.median(relay)),
        }


def measure(
    scene: Scene, safe: Arrival, relay: Relay, rows: int, count: int, pause_s: float
) -> Samples:
    """Alternate relay and gate ``count`` times, with a pause before each message."""
    samples = Samples()
    verdict: Verdict | None = None
    for _ in range(count):
        if verdict is not None:
            scene.acted_on(verdict, 0)
        chunk = scene.chunk(rows)
        payload = encode(chunk)
        time.sleep(pause_s)
        samples.relay_us.append(relay.arrival.after(relay.publisher.put_bytes, payload))
        time.sleep(pause_s)
        samples.gate_us.append(safe.after(scene.send_bytes, payload))
        verdict = scene.verdicts.wait_for(_answers(chunk))
        assert verdict.outcome == 0, verdict
        samples.decision_us.append(verdict.latency_ns / 1e3)
    return samples


def _answers(chunk: ActionChunk) -> Callable[[Verdict], bool]:
    return lambda verdict: verdict.seq == chunk.seq


def main() -> None:
    """Run both cadences and print them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else None)
    parser.add_argument("--count", type=int, default=2000, help="messages back to back")
    parser.add_argument("--count-20hz", type=int, default=200, help="messages at 20 Hz")
    parser.add_argument("--rows", type=int, default=8, help="rows of each chunk")
    parser.add_argument("--json", action="store_true", help="machine-readable")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        relay = Relay(ActionChunk)
        scene = Scene(gate_config(ROBOT, "sim"), Path(folder) / "state")
        try:
            scene.ready_to_move()
            scene.safe.close()  # its work would count as the gate's
            safe = Arrival(scene.bus, scene.keys.safe("runner"))
            measure(scene, safe, relay, arguments.rows, 100, 0.0)  # warm-up
            results = {
                "back_to_back": measure(
                    scene, safe, relay, arguments.rows, arguments.count, 0.0
                ).report(),
                "at_20_hz": measure(
                    scene, safe, relay, arguments.rows, arguments.count_20hz, 0.02
                ).report(),
            }
        finally:
            scene.close()
            relay.close()
    print(json.dumps(results, indent=2) if arguments.json else as_text(results))


def as_text(results: dict[str, dict[str, float]]) -> str:
    """One line per cadence."""
    return "\n".join(
        f"{cadence}: relay {r['relay_p50_us']:.0f} us (p99 {r['relay_p99_us']:.0f}), "
        f"gate {r['gate_p50_us']:.0f} us (p99 {r['gate_p99_us']:.0f}), of which deciding "
        f"{r['gate_receipt_to_verdict_p50_us']:.0f} us; ratio {r['ratio_p50']:.2f}"
        for cadence, r in results.items()
    )


if __name__ == "__main__":
    main()
