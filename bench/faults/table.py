"""All rows of the fault matrix."""

from __future__ import annotations

from bench.faults import (
    access_faults,
    camera_faults,
    creeping_faults,
    forger_faults,
    frame_faults,
    hardware_faults,
    life_faults,
    machine_faults,
    network_faults,
    policy_faults,
    process_faults,
    protocol_faults,
    sensor_faults,
    stop_faults,
    teleop_faults,
)
from bench.faults.row import Row

_FAMILIES = (
    creeping_faults,
    process_faults,
    network_faults,
    frame_faults,
    protocol_faults,
    sensor_faults,
    stop_faults,
    policy_faults,
    machine_faults,
    life_faults,
    camera_faults,
    hardware_faults,
    teleop_faults,
    access_faults,
    forger_faults,
)
ROWS: tuple[Row, ...] = tuple(
    sorted((row for family in _FAMILIES for row in family.ROWS), key=lambda row: row.number)
)
