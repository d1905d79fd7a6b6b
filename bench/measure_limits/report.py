"""The measurement as one document: what ``--json`` prints and what the text is made of."""

from __future__ import annotations

from typing import Any

import numpy as np

from bench.measure_limits.measurement import Measurement
from bench.measure_limits.tracking import STEADY_TICKS, Track

DIGITS = 5
CANDIDATES = {
    f"{low:g} to {high:g}": (low, high)
    for low, high in ((0.0, 0.3), (0.1, 0.3), (0.0, 1.0), (0.1, 1.0), (0.3, 1.0), (0.5, 1.0))
}
"""Gains whose residuals are told, beside the steady one."""


def document(found: Measurement) -> dict[str, Any]:
    """All numbers, rounded; SI, per tick where the name says so."""
    driven = found.driven
    return {
        "robot": driven.robot.id,
        "ticks": found.ticks,
        "stops": len(found.stops),
        "gain": {" ".join(key): _gain(kinds) for key, kinds in found.tracking.tracks.items()},
        "lag": {
            " ".join(key): {kind: round(value, DIGITS) for kind, value in kinds.items()}
            for key, kinds in found.tracking.lags.items()
        },
        "joints": _joints(found),
        "stop_ms": {
            "free" if free else "after contact": {
                name: round(ticks * driven.robot.control_period_ms)
                for name, ticks in found.stops_by_joint(free).items()
            }
            for free in (True, False)
        },
        "tool": {
            f"{part} {kind}": {
                "lower_m": box[0].round(3).tolist(),
                "upper_m": box[1].round(3).tolist(),
                "smallest_singular_value": round(found.reach.singular[part, kind], 4),
            }
            for (part, kind), box in found.reach.tools.items()
        },
        "base": {
            kind: {"lower": box[0].round(3).tolist(), "upper": box[1].round(3).tolist()}
            for kind, box in found.reach.base.items()
        },
    }


def _gain(kinds: dict[str, Track]) -> dict[str, Any]:
    every = Track([sample for track in kinds.values() for sample in track.samples])
    steady = every.shares(least_same=STEADY_TICKS)
    gains = dict(CANDIDATES)
    if steady is not None:
        gains["steady"] = steady
    return {
        "steady": _rounded(steady),
        "first_tick": _rounded(every.shares(most_same=0)),
        "any": _rounded(every.shares()),
        "residual": {
            kind: {name: round(track.residual(gain), DIGITS) for name, gain in gains.items()}
            for kind, track in kinds.items()
        },
    }


def _joints(found: Measurement) -> dict[str, Any]:
    record = found.joints
    return {
        name: {
            **{f"effort_{kind}": round(float(v[at]), 2) for kind, v in record.efforts.items()},
            "change_at_rest": float(f"{found.resting[at]:.2g}"),
            "least_change_moving": (
                float(f"{record.moving[at]:.2g}") if np.isfinite(record.moving[at]) else None
            ),
        }
        for at, name in enumerate(found.driven.robot.measured_joint_names)
    }


def _rounded(shares: tuple[float, float] | None) -> list[float] | None:
    return None if shares is None else [round(share, 3) for share in shares]
