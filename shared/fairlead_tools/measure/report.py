"""What was measured as numbers, as findings in words, and as blocks of robot.yaml."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from fairlead_tools.measure.measurement import Measurement
from fairlead_tools.measure.tracking import STEADY_TICKS, Track

FOLLOWS = 0.8
"""A servo whose joint gets less than this of the speed it was told cannot follow."""
MARGIN = 2.0
"""By which worst cases are multiplied to be limits."""


def document(found: Measurement) -> dict[str, Any]:
    """All numbers in SI, and what follows from them: ``findings`` and ``proposed``."""
    driven = found.driven
    return {
        "robot": driven.robot.id,
        "deployment": driven.deployment.id,
        "hal": driven.deployment.services[driven.deployment.hal].what,
        "profile": driven.profile,
        "ticks": found.ticks,
        "contacts_at_rest": found.contacts,
        "joints": {row["joint"]: row for row in joint_rows(found)},
        "modes": mode_rows(found),
        "findings": list(findings(found)),
        "proposed": proposed(found),
    }


def joint_rows(found: Measurement) -> Iterator[dict[str, Any]]:
    """One for each measured joint."""
    record, robot, stops = found.joints, found.driven.robot, found.stop_s()
    for at, name in enumerate(robot.measured_joint_names):
        efforts = {kind: float(v[at]) for kind, v in record.efforts.items()}
        moving = float(record.moving[at])
        yield {
            "joint": name,
            "unit": robot.joint(name).unit,
            "told_per_s": _digits(float(record.told[at])),
            "speed_per_s": _digits(float(record.speed[at])),
            "effort_free": _digits(efforts.get("free", 0.0)),
            "effort_touching": _digits(efforts.get("touching", 0.0)),
            "jump_per_tick": _digits(float(record.jump[at])),
            "beyond": _digits(float(record.beyond[at])),
            "change_at_rest": _digits(float(found.rest_change[at])),
            "speed_at_rest": _digits(float(found.rest_speed[at])),
            "least_change_moving": _digits(moving) if math.isfinite(moving) else None,
            "dead_band": found.dead_bands.get(name),
            "stop_s": _digits(float(stops[at])),
        }


def mode_rows(found: Measurement) -> list[dict[str, Any]]:
    """One for each joint or half of each mode: its gain and what that leaves, or its lag."""
    rows: list[dict[str, Any]] = []
    for (part, mode, what), kinds in found.tracking.tracks.items():
        every = Track([sample for track in kinds.values() for sample in track.samples])
        steady = every.shares(least_same=STEADY_TICKS) or every.shares()
        gain = None if steady is None else _gain(steady)
        left = None if gain is None else _digits(every.residual((gain[0], gain[1])))
        rows.append({"part": part, "mode": mode, "what": what, "gain": gain, "residual": left})
    for (part, mode, what), lags in found.tracking.lags.items():
        lag = _digits(max(lags.values()))
        rows.append({"part": part, "mode": mode, "what": what, "lag": lag})
    return rows


def _gain(steady: tuple[float, float]) -> list[float]:
    """Two digits, outwards; never less than nothing."""
    low, high = steady
    return [max(0.0, math.floor(100.0 * low) / 100.0), min(1.5, math.ceil(100.0 * high) / 100.0)]


def findings(found: Measurement) -> Iterator[str]:
    """What a person has to look at, in words."""
    for contact in found.contacts:
        yield f"contact at rest: {contact}; what it hinders counts as the robot's own"
    free, every = sum(found.joints.free_ticks), sum(found.ticks.values())
    if every and free < 0.5 * every:
        yield f"only {free} of {every} ticks were free of contacts and ends of joints"
    for row in joint_rows(found):
        told, speed = row["told_per_s"], row["speed_per_s"]
        if told and speed < FOLLOWS * told:
            yield (
                f"{row['joint']}: its servo cannot follow: told {told:g} {row['unit']}/s, got to "
                f"{speed:g}"
            )
    if every and not any(effort.any() for effort in found.joints.efforts.values()):
        yield "no joint reported an effort: without physics no number here is the robot's own"
    if found.share < 1.0:
        yield (
            f"driven at {found.share:g} of full scale: what is proposed is never tighter than what "
            "robot.yaml declares, as nobody saw what full scale does"
        )
    if found.unfinished:
        yield (
            f"still moving when watching a stop ended: {', '.join(found.unfinished)}; raise "
            "stop_ramp_ms in robot.yaml and measure again"
        )
    yield from _beyond_declared(found)


def _beyond_declared(found: Measurement) -> Iterator[str]:
    profile = found.driven.robot.profile(found.driven.profile)
    for row in joint_rows(found):
        told = profile.measured[row["joint"]]
        pairs = {
            "jump_per_tick": (row["jump_per_tick"], told.jump_per_tick),
            "tolerance": (row["beyond"], told.tolerance),
            "contact_limit": (row["effort_free"], told.contact_limit),
            "standstill_per_s": (row["speed_at_rest"], told.standstill_per_s),
            "dead_band_per_tick": (row["dead_band"], told.dead_band_per_tick),
        }
        for key, (seen, declared) in pairs.items():
            if seen is not None and declared is not None and seen > declared:
                yield f"{row['joint']}: measured {seen:g}, beyond {key} {declared:g}"
    longest_ms = 1e3 * float(found.stop_s().max(initial=0.0))
    ramp_ms = profile.protocol.stop_ramp_ms
    if longest_ms > ramp_ms:
        yield f"a stop took {longest_ms:.0f} ms, beyond stop_ramp_ms {ramp_ms}"
    for row in mode_rows(found):
        block = getattr(profile.parts[row["part"]], row["mode"])
        key, index = _tracking_key(found, row)
        declared = getattr(block, key) if index is None else getattr(block, key)[index]
        seen = row.get("lag", row.get("residual"))
        if seen is not None and seen > declared:
            where = f"{row['part']} {row['mode']} {row['what']}"
            yield f"{where}: measured {seen:g}, beyond {key} {declared:g}"


def _tracking_key(found: Measurement, row: dict[str, Any]) -> tuple[str, int | None]:
    """The key of robot.yaml that bounds what is measured here, and the place in its list."""
    if row["what"] not in ("linear", "angular"):
        joints = found.driven.robot.part(row["part"]).joints
        return "tracking_limits", joints.index(row["what"])
    profile = found.driven.robot.profile(found.driven.profile)
    block = getattr(profile.parts[row["part"]], row["mode"])
    names = type(block).model_fields
    return next(name for name in names if name.startswith(f"{row['what']}_tracking")), None


def proposed(found: Measurement) -> dict[str, Any]:
    """Limits as robot.yaml words them, worst cases doubled, each block with its source.

    After a gentle drive none is tighter than what is declared, which may be of full scale.
    """
    driven, robot = found.driven, found.driven.robot
    hal = driven.deployment.services[driven.deployment.hal].what
    source = f"measured: fairlead robot measure {robot.id}, {driven.deployment.id}, {hal}"
    if found.share < 1.0:
        source += f", at {found.share:g} of full scale, no tighter than declared before"
    ramp_ms = math.ceil(10.0 * MARGIN * float(found.stop_s().max(initial=0.0))) * 100
    if found.unfinished or found.share < 1.0:
        ramp_ms = max(ramp_ms, robot.profile(driven.profile).protocol.stop_ramp_ms)
    return {
        "measured": _joint_limits(found, source),
        "parts": _mode_limits(found, source),
        "protocol": {"stop_ramp_ms": ramp_ms},
    }


def _wide(found: Measurement, seen: float, told: float | None) -> float:
    return seen if found.share == 1.0 or told is None else max(seen, told)


def _joint_limits(found: Measurement, source: str) -> dict[str, Any]:
    driven, robot = found.driven, found.driven.robot
    blocks: dict[str, Any] = {}
    for row in joint_rows(found):
        joint = robot.joint(row["joint"])
        floor = 0.005 * joint.velocity_limit
        told = robot.profile(driven.profile).measured[row["joint"]]
        jump = _wide(found, _up(row["jump_per_tick"]), told.jump_per_tick)
        block: dict[str, Any] = {"jump_per_tick": jump}
        if joint.has_bounds:
            seen = max(_up(max(row["beyond"], floor * driven.period_s)), _seam(found, row["joint"]))
            block["tolerance"] = _wide(found, seen, told.tolerance)
        rest = _up(max(row["speed_at_rest"], floor))
        block["standstill_per_s"] = _wide(found, rest, told.standstill_per_s)
        if joint in robot.joints:
            most = 1.05 * joint.effort_limit
            effort = _digits(min(_up(row["effort_free"]) or most, most))
            block["contact_limit"] = _wide(found, effort, told.contact_limit)
            step = max(_up(row["change_at_rest"]), 1e-11)
            block["encoder_step"] = _wide(found, step, told.encoder_step)
            dead = _up(max(row["dead_band"] or 0.0, 1e-6))
            block["dead_band_per_tick"] = _wide(found, dead, told.dead_band_per_tick)
        blocks[row["joint"]] = {**block, "source": f"{source}, doubled"}
    return blocks


def _mode_limits(found: Measurement, source: str) -> dict[str, Any]:
    declared = found.driven.robot.profile(found.driven.profile)
    parts: dict[str, Any] = {}
    for row in mode_rows(found):
        at = parts.setdefault(row["part"], {}).setdefault(row["mode"], {})
        told = getattr(declared.parts[row["part"]], row["mode"])
        seen = row.get("lag", row.get("residual"))
        if row.get("gain") is not None:
            kept = found.share < 1.0 and hasattr(told, "gain")
            low, high = at.get("gain", told.gain if kept else row["gain"])
            at["gain"] = [min(low, row["gain"][0]), max(high, row["gain"][1])]
        if seen is not None:
            key, index = _tracking_key(found, row)
            if index is None:
                at[key] = _wide(found, _up(seen), getattr(told, key))
            else:
                at.setdefault(key, []).append(_wide(found, _up(seen), getattr(told, key)[index]))
        at["source"] = f"{source}, tracking doubled"
    return parts


def _seam(found: Measurement, joint: str) -> float:
    """What lets a chunk begin while the joint is behind its targets, as far as is declared now."""
    lags = [
        max(seen.values()) for (_, _, what), seen in found.tracking.lags.items() if what == joint
    ]
    declared = found.driven.robot.profile(found.driven.profile).measured[joint].tolerance
    return _digits(min(max(lags, default=0.0), declared or 0.0))


def _up(value: float) -> float:
    """Doubled, two digits, rounded up."""
    wide = MARGIN * value
    if wide <= 0.0:
        return 0.0
    unit = 10.0 ** (math.floor(math.log10(wide)) - 1)
    return float(f"{math.ceil(wide / unit - 1e-9) * unit:.2g}")


def _digits(value: float) -> float:
    return float(f"{value:.3g}")
