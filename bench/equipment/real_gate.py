"""The real gate core in a child process: its own code, our time, our losses."""

from __future__ import annotations

import os
import struct
import subprocess
from pathlib import Path
from typing import get_args

from bench.equipment.gate_port import EventKind, GateOutput, OutputKind
from fairlead.paths import built_program, gate_config

TOOL = "fairlead-safety-core-stdio"
LOGS = "FAIRLEAD_EXPLORER_LOGS"  # a folder that keeps the decision log of every run
BOOT = 255
EVENTS: dict[EventKind, int] = {kind: number for number, kind in enumerate(get_args(EventKind))}
OUTPUTS: dict[int, OutputKind] = {
    1: "safe_chunk",
    2: "verdict",
    3: "lease",
    4: "status",
    5: "reply",
    6: "refusal",
}


class RealGate:
    """One gate core, driven over the tool's stdin and stdout.

    Args:
        restarted: whether a gate ran before and was killed: this one boots latched.
        config: the compiled gate file, by default panda_mobile's.
    """

    def __init__(self, seed: int, restarted: bool = False, config: Path | None = None) -> None:
        file = config or gate_config("panda_mobile", "sim")
        command = [str(built_program(TOOL)), "--config", str(file), "--seed", str(seed)]
        if LOGS in os.environ:
            command += ["--decision-log", os.environ[LOGS]]
        self._child = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.boot(restarted)

    def boot(self, restarted: bool = False) -> None:
        """Put a new gate in the place of the present one; its time starts anew."""
        self._call(BOOT, 0, b"", b"\x00\x00" if restarted else b"\x01\x00")

    def step(
        self, now_ns: int, kind: EventKind, source: str = "", payload: bytes = b""
    ) -> list[GateOutput]:
        """One event at a time of its clock; everything that the gate then puts out."""
        return self._call(EVENTS[kind], now_ns, source.encode(), payload)

    def close(self) -> None:
        """End the child process, which has to end well."""
        assert self._child.stdin is not None and self._child.stdout is not None
        self._child.stdin.close()
        assert self._child.wait(timeout=10) == 0
        self._child.stdout.close()

    def _call(self, kind: int, now_ns: int, source: bytes, payload: bytes) -> list[GateOutput]:
        assert self._child.stdin is not None
        head = struct.pack("<BQI", kind, now_ns, len(source))
        self._child.stdin.write(head + source + struct.pack("<I", len(payload)) + payload)
        self._child.stdin.flush()
        return [self._read_output() for _ in range(self._number())]

    def _read_output(self) -> GateOutput:
        kind = OUTPUTS.get(self._read(1)[0], "other")
        source = self._read(self._number()).decode()
        return GateOutput(kind, source, self._read(self._number()))

    def _number(self) -> int:
        (value,) = struct.unpack("<I", self._read(4))
        return int(value)

    def _read(self, size: int) -> bytes:
        assert self._child.stdout is not None
        data = self._child.stdout.read(size)
        assert len(data) == size, f"{TOOL} ended with {self._child.poll()}"
        return data
