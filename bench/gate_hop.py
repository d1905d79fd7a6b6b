"""What the gate costs: candidate in to SafeChunk out, beside a relay that decides nothing.

Both are C++ processes on the same Zenoh library, driven alternately from this process with
the same bytes, so that what the machine does to one it does to the other.

    .venv/bin/python -m bench.gate_hop [--count 2000] [--count-20hz 200] [--rows 1 8] [--json]
    .venv/bin/python -m bench.gate_hop --write    also puts the table into docs/speed.md

Prints medians and 99th percentiles [us] and their ratio, back to back and at 20 Hz, for rows of
seven joint targets (panda) and for rows that step the tool (panda_mobile). The relay sends one
message on, the gate a SafeChunk and after it a lease and a verdict; a second relay sends three
messages too.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import tempfile
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from bench.equipment.gate_scene import Scene
from bench.page import Write, write_table
from fairlead.messages import ActionChunk, ActionPart, Message, Verdict, encode, pack_floats
from fairlead.modes import ControlMode
from fairlead.paths import gate_binary, gate_config
from fairlead.wire.bus import Bus, Qos, Sample
from fairlead.wire.endpoints import RUNTIME, RUNTIME_VARIABLE, Endpoints
from fairlead.wire.session import ZenohBus

DEADLINE_S = 10.0
AIM = 1.10  # the gate's median over the relay's
KEY_IN, KEY_OUT = "fl/bench/relay_in", "fl/bench/relay_out"
JOINTS, SWAY_RAD = 7, 0.002  # of panda's arm, its first joints
MORE = ("fl/bench/relay_lease", "fl/bench/relay_verdict")


def socket_in(folder: Path, name: str) -> str:
    """Endpoint of a socket: what the services of one host meet on."""
    return f"unixsock-stream/{folder / name}.sock"


@dataclass(frozen=True)
class Case:
    """Rows of one kind, and the robot whose gate is given them."""

    name: str
    robot: str
    part: Callable[[Scene, int], ActionPart]


def _tool_steps(scene: Scene, rows: int) -> ActionPart:
    return scene.arm_part(rows)


def _joint_targets(scene: Scene, rows: int) -> ActionPart:
    """To and fro about the measured joints, beginning there."""
    values = np.zeros((rows, len(scene.hal.joints)))
    values[:, :JOINTS] = scene.hal.positions[:JOINTS]
    values[1::2, :JOINTS] += SWAY_RAD
    return scene.arm_part(
        rows,
        mode=ControlMode.JOINT_POSITION,
        frame_id="",
        values=pack_floats(values),
        active=tuple(range(JOINTS)),
    )


CASES = (
    Case("joint targets", "panda", _joint_targets),
    Case("tool steps", "panda_mobile", _tool_steps),
)


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
        self.expect()
        start_ns = time.perf_counter_ns()
        send(payload)
        self.wait()
        return (self._at_ns - start_ns) / 1e3

    def wait(self) -> None:
        """Until something has arrived since the last `expect`."""
        if not self._event.wait(DEADLINE_S):
            raise SystemExit("gate_hop: a message was lost; run it again")

    def expect(self) -> None:
        """What arrives from now on is new."""
        self._event.clear()


class Relay:
    """A bare relay's process and a session connected to it by a socket.

    Args:
        folder: for the socket.
        more: keys on which it sends a short message after each one, heard here too.
    """

    def __init__(self, folder: Path, kind: type[Message], more: tuple[str, ...] = ()) -> None:
        binary = gate_binary().with_name("bare-relay")
        endpoint = socket_in(folder, f"relay-{len(more)}")
        threads = {RUNTIME_VARIABLE: RUNTIME["peer"]}  # as the gate has them
        self.process = subprocess.Popen(
            [str(binary), endpoint, KEY_IN, KEY_OUT, *more],
            stdout=subprocess.PIPE, text=True, env=os.environ | threads,
        )  # fmt: skip
        assert self.process.stdout is not None
        assert self.process.stdout.readline() == "ready\n"
        self.bus = ZenohBus(Endpoints(connect=[endpoint]))
        self.arrival = Arrival(self.bus, KEY_OUT)
        self.others = [Arrival(self.bus, key) for key in more]
        self.publisher = self.bus.publisher(KEY_IN, kind, Qos.HOT)

    def time(self, payload: bytes) -> float:
        """Microseconds until its message is back; returns when the others are, too."""
        for other in self.others:
            other.expect()
        microseconds = self.arrival.after(self.publisher.put_bytes, payload)
        for other in self.others:
            other.wait()  # their work would count as the next one's
        return microseconds

    def close(self) -> None:
        """Leave the session and end the relay's process."""
        self.bus.close()
        self.process.terminate()
        self.process.communicate(timeout=DEADLINE_S)


@dataclass
class Samples:
    """Round trips [us], and how long a chunk waited in the gate for its turn."""

    relay_us: list[float] = field(default_factory=list)
    three_us: list[float] = field(default_factory=list)
    gate_us: list[float] = field(default_factory=list)
    wait_us: list[float] = field(default_factory=list)

    def report(self) -> dict[str, float]:
        """Medians and 99th percentiles [us], and how much longer the way through the gate is."""
        relay, gate = np.array(self.relay_us), np.array(self.gate_us)
        three = float(np.median(self.three_us))
        return {
            "relay_p50_us": float(np.median(relay)),
            "relay_p99_us": float(np.percentile(relay, 99)),
            "gate_p50_us": float(np.median(gate)),
            "gate_p99_us": float(np.percentile(gate, 99)),
            "gate_wait_p50_us": float(np.median(self.wait_us)),
            "relay_of_three_p50_us": three,
            "ratio_p50": float(np.median(gate) / np.median(relay)),
            "ratio_to_three_p50": float(np.median(gate) / three),
        }


@dataclass(frozen=True)
class Bench:
    """A gate with a claim on its robot's arm, beside two relays."""

    case: Case
    scene: Scene
    safe: Arrival
    relays: tuple[Relay, Relay]

    def measure(self, rows: int, count: int, pause_s: float) -> Samples:
        """Alternate both relays and the gate ``count`` times, with a pause before each message."""
        samples = Samples()
        verdict: Verdict | None = None
        for _ in range(count):
            if verdict is not None:
                self.scene.acted_on(verdict, 0)
            chunk = self.scene.chunk(rows, parts=(self.case.part(self.scene, rows),))
            payload = encode(chunk)
            times = (samples.relay_us, samples.three_us)
            for relay, times_us in zip(self.relays, times, strict=True):
                time.sleep(pause_s)
                times_us.append(relay.time(payload))
            time.sleep(pause_s)
            samples.gate_us.append(self.safe.after(self.scene.send_bytes, payload))
            verdict = self.scene.verdicts.wait_for(_answers(chunk))
            if verdict.outcome != 0:
                raise SystemExit(f"gate_hop: a chunk of {self.case.name} was refused: {verdict}")
            samples.wait_us.append(verdict.latency_ns / 1e3)
        return samples


def _answers(chunk: ActionChunk) -> Callable[[Verdict], bool]:
    return lambda verdict: verdict.seq == chunk.seq


def results_of(case: Case, rows: int, count: int, count_20hz: int) -> dict[str, dict[str, float]]:
    """Both cadences of one case: what `Samples.report` says, by cadence."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        relays = (Relay(folder, ActionChunk), Relay(folder, ActionChunk, MORE))
        config, listen = gate_config(case.robot, "sim"), socket_in(folder, "gate")
        scene = Scene(config, folder / "state", robot=case.robot, listen=listen)
        try:
            scene.ready_to_move()
            scene.safe.close()  # its work would count as the gate's
            bench = Bench(case, scene, Arrival(scene.bus, scene.keys.safe("runner")), relays)
            bench.measure(rows, 100, 0.0)  # warm-up
            return {
                "back_to_back": bench.measure(rows, count, 0.0).report(),
                "at_20_hz": bench.measure(rows, count_20hz, 0.02).report(),
            }
        finally:
            scene.close()
            for relay in relays:
                relay.close()


def main() -> None:
    """Run every case at both cadences and print them."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--count", type=int, default=2000, help="messages back to back")
    parser.add_argument("--count-20hz", type=int, default=200, help="messages at 20 Hz")
    parser.add_argument(
        "--rows", type=int, nargs="+", default=[1, 8], help="rows of each chunk; several in turn"
    )
    parser.add_argument("--json", action="store_true", help="machine-readable")
    parser.add_argument("--write", action=Write, help="put the table into docs/speed.md")
    arguments = parser.parse_args()
    results = {
        f"{case.name}, H={rows}": results_of(case, rows, arguments.count, arguments.count_20hz)
        for case in CASES
        for rows in arguments.rows
    }
    table = as_table(results)
    if arguments.write:
        write_table("hop", table)
    if arguments.json:
        print(json.dumps(results | {"load_average": os.getloadavg()[0]}, indent=2))
    else:
        print(f"{table}\n\nload average {os.getloadavg()[0]:.1f}")


def as_table(results: dict[str, dict[str, dict[str, float]]]) -> str:
    """One line per case, in Markdown."""
    cadences = [
        cadence.replace("_", " ").replace("hz", "Hz") for cadence in next(iter(results.values()))
    ]
    lines = [
        f"| gate p50, p99 us; of relay's p50 (aim {AIM:.2f}) | {' | '.join(cadences)} |",
        "|---" * (1 + len(cadences)) + "|",
    ]
    for case, times in results.items():
        cells = [
            f"{r['gate_p50_us']:.0f}, {r['gate_p99_us']:.0f}; {r['ratio_p50']:.2f}"
            for r in times.values()
        ]
        lines.append(f"| {case} | {' | '.join(cells)} |")
    return "\n".join(lines)


if __name__ == "__main__":
    main()
