"""Robots among walls, starts and rows for the tests of where rows lead."""

from __future__ import annotations

import json
from typing import Any

import numpy as np

from fairlead.messages import FloatArray
from fairlead.paths import gate_config
from tests.differential.path_reference import PathReference

FAR = 50.0


def narrowed(robot: str) -> dict[str, Any]:
    """The gate file with walls and a floor near the robot, and half a gain."""
    data: dict[str, Any] = json.loads(gate_config(robot, "sim").read_text())
    for part in data["parts"]:
        part["singularity_limit"] = part["singularity_limit"] and 0.06
        for block in part["modes"].values():
            block.update({"gain": [0.4, 0.9]} if "gain" in block else {})
    data["collision"]["clearance"] = 0.02
    data["workspace"]["volumes"] = [
        {"name": "cell", "kind": "keep_in", "lower": [-0.3, -0.8, 0.2], "upper": [0.75, 0.8, 1.6]}
    ]
    if data["base"] is not None:
        hall = [[-0.8, -0.7], [0.6, -0.7], [0.9, 0.2], [0.4, 0.7], [-0.8, 0.6]]
        data["base"]["zones"] = [{"name": "hall", "kind": "keep_in", "corners": hall}]
    return data


def rows_of(
    data: dict[str, Any], rng: np.random.Generator, start: FloatArray, part: str, mode: str
) -> FloatArray:
    """Rows that go on in one direction, within the limits that single rows have."""
    declared = next(one for one in data["parts"] if one["name"] == part)
    # Some steps are small: it takes more of them to get anywhere.
    most = 24 if mode in ("joint_position", "cartesian_twist") else 10
    block, horizon = declared["modes"][mode], int(rng.integers(2, most))
    names = [joint["name"] for joint in data["joints"]]
    own = [names.index(name) for name in declared["joints"]]
    if mode in ("joint_position", "joint_velocity"):
        rows = np.zeros((horizon, len(names)))
        limits = [data["joints"][joint]["velocity_limit"] for joint in own]
        step = rng.uniform(-1.0, 1.0, len(own)) * np.minimum(block["step_limit"], limits) * 0.98
        count = np.arange(1, horizon + 1)[:, None]
        rows[:, own] = start[own] + count * step if mode == "joint_position" else step
        return rows
    rows = np.zeros((horizon, 6))
    free = block.get("free_axes", list(range(6)))
    drawn = rng.normal(size=6)
    for half, key in ((slice(0, 3), "linear"), (slice(3, 6), "angular")):
        top = min(block.get(f"{key}_limit", 1.0), block[f"{key}_step_limit"]) * 0.98
        drawn[half] *= top * rng.random() / np.linalg.norm(drawn[half])
    rows[:, free] = drawn[free]
    return rows


def start_of(
    data: dict[str, Any], reference: PathReference, rng: np.random.Generator, part: str, mode: str
) -> FloatArray:
    """A configuration with room around it."""
    joints = [*data["joints"], *data["passive_joints"]]
    bounds = [joint.get("bounds", {"lower": -0.4, "upper": 0.4}) for joint in joints]
    lower = np.array([bound["lower"] for bound in bounds])
    upper = np.array([bound["upper"] for bound in bounds])
    while True:
        positions = np.asarray(rng.uniform(lower, upper), dtype=np.float64)
        if reference.start_margin(positions, part, mode) > 0.005:
            return positions


def with_wall(data: dict[str, Any], x: float, part: str) -> dict[str, Any]:
    """Nothing around but a wall ahead, of the base or else of tools; one pair of capsules."""
    upper = [FAR if part == "base" else x, FAR, FAR]
    box = {"name": "cell", "kind": "keep_in", "lower": [-FAR] * 3, "upper": upper}
    changed = data | {"workspace": data["workspace"] | {"volumes": [box]}}
    changed["collision"] = data["collision"] | {"pairs": data["collision"]["pairs"][:1]}
    if data["base"] is not None:
        corners = [[-FAR, -FAR], [x, -FAR], [x, FAR], [-FAR, FAR]]
        zones = [{"name": "hall", "kind": "keep_in", "corners": corners}]
        changed["base"] = data["base"] | {"zones": zones}
    return changed


def gain_of(data: dict[str, Any], part: str, mode: str) -> tuple[float, float]:
    declared = next(one for one in data["parts"] if one["name"] == part)
    low, high = declared["modes"][mode]["gain"]
    return float(low), float(high)
