"""The limits of shape, surroundings and protocol in a compiled gate file."""

from __future__ import annotations

from typing import Any

from fairlead_tools.limits.effective_limit import EffectiveLimit


def surrounding_limits(config: dict[str, Any]) -> list[EffectiveLimit]:
    """Self-collision, volumes, the base and its zones, then the protocol."""
    collision, workspace, base = config["collision"], config["workspace"], config["base"]
    rows = [
        EffectiveLimit(
            "self-collision", "clearance", collision["clearance"], "m", collision["source"]
        ),
        EffectiveLimit(
            "self-collision", "pairs", float(len(collision["pairs"])), "1", collision["source"]
        ),
    ]
    for volume in workspace["volumes"]:
        where, source = f"volume {volume['name']}", workspace["source"]
        for end in ("lower", "upper"):
            name, ends = f"{volume['kind']} {end}", tuple(volume[end])
            rows.append(EffectiveLimit(where, name, ends, "m", source))
    return rows + _base_limits(base) + _protocol_limits(config["protocol"])


def _base_limits(base: dict[str, Any] | None) -> list[EffectiveLimit]:
    if base is None:
        return []
    source = base["source"]
    rows = [
        EffectiveLimit("base", "footprint", _flat(base["footprint"]), "m", source),
        EffectiveLimit("base", "yaw_axis", tuple(base["yaw_axis"]), "m", source),
        EffectiveLimit("base", "reaction_s", base["reaction_s"], "s", source),
        EffectiveLimit("base", "tool_drift", base["tool_drift"], "m", source),
        EffectiveLimit("base", "clearance_drift", base["clearance_drift"], "m", source),
    ]
    for zone in base["zones"]:
        where, name = f"zone {zone['name']}", f"{zone['kind']} corners"
        rows.append(EffectiveLimit(where, name, _flat(zone["corners"]), "m", source))
    return rows


def _flat(corners: list[list[float]]) -> tuple[float, ...]:
    return tuple(number for corner in corners for number in corner)


def _protocol_limits(protocol: dict[str, float]) -> list[EffectiveLimit]:
    rows = []
    for name, value in protocol.items():
        unit = name.rsplit("_", 1)[-1]
        unit = unit if unit in ("us", "ms", "s", "hz", "ticks") else "1"
        source = "robot.yaml, safety.protocol"
        rows.append(EffectiveLimit("protocol", name, float(value), unit, source))
    return rows
