"""The robots that faults are done to, by name."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

from tests.faults.camera_stage import camera_stage
from tests.faults.failing_disk import disk_stage
from tests.faults.faulty_stage import faulty_stage
from tests.faults.gate_stage import gate_stage
from tests.faults.life_faults import order_stage, soak_stage
from tests.faults.live_stage import live_stage
from tests.faults.machine_stage import machine_stage
from tests.faults.routed_stage import routed_stage

STAGES: Mapping[str, Callable[[Path], AbstractContextManager[Any]]] = {
    "robot": live_stage,
    "gate": gate_stage,
    "orders": order_stage,
    "soak": soak_stage,
    "machine": machine_stage,
    "disk": disk_stage,
    "cameras": camera_stage,
    "faulty": faulty_stage,
    "routed": routed_stage,
}
"""Each opens in an empty folder."""
