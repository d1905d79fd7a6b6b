"""Gate files whose shape, surroundings, tracking and contact refuse and stop nothing: for tests of
the checks before them."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from tests.differential.gate_file import MODES

VAST = 1e4


def quiet(data: dict[str, Any]) -> dict[str, Any]:
    """Far walls, capsules that never meet, joints that brake at once."""
    for joint in data["joints"]:
        joint["stop_lag"] = 0.0
        if joint["acceleration_limit"] is not None:  # null for a gripper's
            joint["acceleration_limit"] = 1e30
    for part in data["parts"]:
        if part["singularity_limit"] is not None:
            part["singularity_limit"] = 1e-12
    let_tools_be_fast(data)
    first, second = data["collision"]["pairs"][0]
    for number, capsule in enumerate(data["collision"]["capsules"]):
        end = [0.0, 0.0, VAST if number == second else 0.0]
        capsule.update(a=end, b=end, radius=0.001)
    data["collision"].update(clearance=0.001, pairs=[[first, second]])
    for volume in data["workspace"]["volumes"]:
        volume.update(kind="keep_in", lower=[-VAST] * 3, upper=[VAST] * 3)
    if data["base"] is not None:
        square = [[-VAST, -VAST], [VAST, -VAST], [VAST, VAST], [-VAST, VAST]]
        data["base"].update(command_frame="odom", tool_drift=0.0, clearance_drift=0.0)
        for zone in data["base"]["zones"]:
            zone.update(kind="keep_in", corners=square)
    return data


def let_tools_be_fast(data: dict[str, Any]) -> None:
    """Joints may be as fast as any motion of their tool asks for."""
    for part in data["parts"]:
        has_tool_modes = any(mode.startswith("cartesian") for mode in part["modes"])
        for joint in data["joints"]:
            if has_tool_modes and joint["name"] in part["joints"]:
                joint["velocity_limit"] *= 1000.0


def unwatched(data: dict[str, Any]) -> dict[str, Any]:
    """What rows do is not looked at, and is predicted to be next to nothing."""
    for joint in data["joints"]:
        joint["contact_limit"] = VAST
    for part in data["parts"]:
        for name in MODES:
            block = part["modes"].get(name, {})
            if "gain" in block:
                block["gain"] = [0.0, 1e-300]
            if "tracking" in block:
                block["tracking"] = [VAST] * len(block["tracking"])
            block |= {key: VAST for key in block if key.endswith("_tracking")}
    return data


def write_quiet(config: Path, folder: Path) -> Path:
    """The quiet version of a gate file, in a folder."""
    path = folder / "gate.quiet.json"
    path.write_text(json.dumps(unwatched(quiet(json.loads(config.read_text())))))
    return path
