"""The robots that faults are done to, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from bench.faults.camera_stage import camera_stage
from bench.faults.failing_disk import disk_stage
from bench.faults.faulty_stage import faulty_stage, seeing_stage
from bench.faults.gate_stage import gate_stage
from bench.faults.life_faults import order_stage, soak_stage
from bench.faults.live_stage import Changes, live_stage
from bench.faults.machine_stage import machine_stage
from bench.faults.policy_stage import policy_stage
from bench.faults.routed_stage import certified_stage, routed_stage
from bench.faults.servo_stage import servo_stage

STAGES: Mapping[str, Callable[[Path], AbstractContextManager[Any]]] = {
    "robot": live_stage,
    "open": lambda folder: live_stage(folder, Changes(access="open")),
    "gate": gate_stage,
    "orders": order_stage,
    "soak": soak_stage,
    "machine": machine_stage,
    "disk": disk_stage,
    "cameras": camera_stage,
    "faulty": faulty_stage,
    "seeing": seeing_stage,
    "routed": routed_stage,
    "certified": certified_stage,
    "servos": servo_stage,
    "policy": policy_stage,
}
"""Each opens in an empty folder."""
