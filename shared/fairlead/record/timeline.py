"""A picture of one run: proposed, released and measured for each part, over time."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fairlead.messages import Hold, Outcome
from fairlead.record.part_series import Curve, Panel, held_ticks, panels
from fairlead.record.recorder import Recording, first_verdicts
from fairlead.robot.manifest import RobotManifest

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PANEL_HEIGHT_IN = 1.35
WIDTH_IN = 14.0
LATE = 0.85  # of the time shown: labels after it are written to the left
_STYLES = {
    "proposed": {"color": "#9aa0a6", "linewidth": 5.0, "alpha": 0.6},
    "released": {"color": "#1a56db", "linewidth": 1.3},
    "measured": {"color": "#e8710a", "linewidth": 1.3},
}
_HOLD_COLOUR = "#fde293"
_OUTCOMES = {
    Outcome.RELEASED: ("released", "|", "#1e8e3e"),
    Outcome.TRUNCATED: ("truncated", "v", "#e8710a"),
    Outcome.REFUSED: ("refused", "x", "#d93025"),
}


def draw_timeline(
    recording: Recording, robot: RobotManifest, source: str, title: str, path: Path
) -> None:
    """Write the picture of what one source commanded, and of every verdict, as a PNG file."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    drawn = panels(recording, robot, source)
    figure, axes = plt.subplots(
        len(drawn) + 1, 1, sharex=True, squeeze=False, layout="constrained",
        figsize=(WIDTH_IN, PANEL_HEIGHT_IN * (len(drawn) + 1) + 0.8),
    )  # fmt: skip
    column: list[Axes] = list(axes[:, 0])
    held = sorted(held_ticks(recording))
    for panel, axis in zip(drawn, column[:-1], strict=True):
        _draw_panel(panel, axis)
    for axis in column:
        _shade(held, axis)
        axis.grid(visible=True, color="#e0e0e0", linewidth=0.5)
    _draw_verdicts(recording, column[-1])
    _label_time(recording, robot, column)
    figure.suptitle(title, fontsize=12)
    handles, labels = column[0].get_legend_handles_labels()
    once = dict(zip(labels, handles, strict=True))  # every hold has the same label
    figure.legend(once.values(), once.keys(), loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_panel(panel: Panel, axis: Axes) -> None:
    for name, style in _STYLES.items():
        curve: Curve = getattr(panel, name)
        if curve:
            ticks, values = _with_gaps(curve)
            axis.plot(ticks, values, label=name, drawstyle="steps-post", **style)  # type: ignore[arg-type]
    unit = f"\n[{panel.unit}]" if panel.unit else ""
    axis.set_ylabel(f"{panel.part}\n{panel.quantity}{unit}", fontsize=8)
    axis.margins(x=0.01, y=0.12)


def _with_gaps(curve: Curve) -> tuple[list[float], list[float]]:
    """Points in order of tick, with a break wherever ticks are missing."""
    ticks: list[float] = []
    values: list[float] = []
    for tick in sorted(curve):
        if ticks and tick > ticks[-1] + 1:
            ticks.append(ticks[-1] + 1)
            values.append(float("nan"))
        ticks.append(tick)
        values.append(curve[tick])
    return ticks, values


def _shade(held: Sequence[int], axis: Axes) -> None:
    """Mark ticks in which the robot held."""
    start = None
    for tick in held:
        if start is None:
            start = tick
        if tick + 1 not in held:
            axis.axvspan(start, tick + 1, color=_HOLD_COLOUR, label="robot held", zorder=0)
            start = None


def _draw_verdicts(recording: Recording, axis: Axes) -> None:
    first = recording.joints[0].tick if recording.joints else 0
    for level, (outcome, (name, marker, colour)) in enumerate(_OUTCOMES.items()):
        codes: dict[int, list[str]] = {}
        count = verdict_counts(recording).get(name, 0)
        for tick, verdict in zip(recording.verdict_ticks, recording.verdicts, strict=True):
            if verdict.outcome == outcome:
                codes.setdefault(tick, []).append(f"G{verdict.code:03d}" if verdict.code else "")
        axis.plot(list(codes), [level] * len(codes), marker, color=colour, markersize=7)
        for number, (tick, texts) in enumerate(codes.items()):
            late = tick > first + LATE * (recording.newest_tick - first)  # it would leave the frame
            axis.annotate(
                ", ".join(sorted(set(texts) - {""})), (tick, level), fontsize=7, color=colour,
                # neighbours take turns above and below, or their codes would overlap
                xytext=(-5 if late else 5, 4 if number % 2 else -9), textcoords="offset points",
                ha="right" if late else "left",
            )  # fmt: skip
        axis.text(
            1.005, level, f"{count} {name}", color=colour, fontsize=8, va="center",
            transform=axis.get_yaxis_transform(),
        )  # fmt: skip
    axis.set_yticks(range(len(_OUTCOMES)), [name for name, *_ in _OUTCOMES.values()], fontsize=8)
    axis.set_ylim(-0.6, len(_OUTCOMES) - 0.4)
    axis.set_ylabel("chunks", fontsize=8)


def _label_time(recording: Recording, robot: RobotManifest, column: Sequence[Axes]) -> None:
    period_s = robot.tick_period_ns / 1e9
    first = recording.joints[0].tick if recording.joints else 0
    column[-1].set_xlabel(f"tick (one is {1e3 * period_s:g} ms); refused chunks carry their code")
    above = column[0].secondary_xaxis(
        "top",
        functions=(
            lambda tick: (np.asarray(tick) - first) * period_s,
            lambda seconds: np.asarray(seconds) / period_s + first,
        ),
    )
    above.set_xlabel("robot time [s]", fontsize=8)


def verdict_counts(recording: Recording) -> dict[str, int]:
    """How many chunks of all sources had which outcome; a copy's answer counts no second time."""
    return Counter(
        Outcome(verdict.outcome).name.lower() for _, verdict in first_verdicts(recording).values()
    )


def hold_names(recording: Recording) -> dict[str, int]:
    """How many ticks were held for each reason."""
    counts: dict[str, int] = {}
    for hold in held_ticks(recording).values():
        counts[Hold(hold).name.lower()] = counts.get(Hold(hold).name.lower(), 0) + 1
    return counts
