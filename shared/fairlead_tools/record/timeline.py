"""A picture of one run: asked, released and measured for each part, over time."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fairlead.messages import Hold, Outcome
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.record.measured import Curve
from fairlead_tools.record.part_series import Panel, held_ticks, panels
from fairlead_tools.record.picture_file import require_picture
from fairlead_tools.record.run_log import Run

if TYPE_CHECKING:
    from matplotlib.axes import Axes

PANEL_HEIGHT_IN = 1.15
WIDTH_IN = 14.0
LATE = 0.85  # of the time shown: labels after it are written to the left
ROOM = 0.15  # above and below the curves
_STYLES = {
    "asked": {"color": "#9aa0a6", "linewidth": 5.0, "alpha": 0.6},
    "released": {"color": "#1a56db", "linewidth": 1.3},
    "measured": {"color": "#e8710a", "linewidth": 1.3},
}
_HOLD_COLOUR, _STOP_COLOUR, _ABLE_COLOUR = "#fde293", "#a50e0e", "#ceead6"
_OUTCOMES = {
    Outcome.RELEASED: ("released", "|", "#1e8e3e"),
    Outcome.TRUNCATED: ("truncated", "v", "#e8710a"),
    Outcome.REFUSED: ("refused", "x", "#d93025"),
}


def draw_timeline(run: Run, robot: RobotManifest, title: str, path: Path) -> None:
    """Write the picture of what was asked of a robot, and of every verdict.

    Raises:
        ConfigError: the file's name does not end as that of a picture.
    """
    require_picture("plot", path)
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    drawn = panels(run, robot)
    figure, axes = plt.subplots(
        len(drawn) + 1, 1, sharex=True, squeeze=False, layout="constrained",
        figsize=(WIDTH_IN, PANEL_HEIGHT_IN * (len(drawn) + 1) + 1.0),
    )  # fmt: skip
    column: list[Axes] = list(axes[:, 0])
    for panel, axis in zip(drawn, column[:-1], strict=True):
        _draw_panel(panel, axis)
        _shade(held_ticks(run, panel.part), axis)
        _mark_refusals(run, axis)
    _shade(held_ticks(run), column[-1])
    _draw_verdicts(run, column[-1])
    for axis in column:
        axis.grid(visible=True, color="#e0e0e0", linewidth=0.5)
        for tick, *_ in run.stops:
            axis.axvline(tick, color=_STOP_COLOUR, linewidth=1.5)
    if run.joints:
        column[0].set_xlim(_first_tick(run) - 1, run.tick + 2)
    _label_time(run, robot, column)
    figure.suptitle(title, fontsize=12)
    labelled = [axis.get_legend_handles_labels() for axis in column]
    once = {label: handle for handles, labels in labelled
            for handle, label in zip(handles, labels, strict=True)}  # fmt: skip
    figure.legend(once.values(), once.keys(), loc="outside lower center", ncols=6, frameon=False)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_panel(panel: Panel, axis: Axes) -> None:
    for name, style in _STYLES.items():
        curve: Curve = getattr(panel, name)
        if curve:
            ticks, values = _with_gaps(curve)
            axis.plot(ticks, values, label=name, drawstyle="steps-post", **style)  # type: ignore[arg-type]
    if panel.gain is not None and panel.released and panel.measured:
        ticks, told = _with_gaps(
            {tick: math.nan if tick in panel.carried else v for tick, v in panel.released.items()}
        )
        least, most = (np.array(told) * share for share in panel.gain)
        axis.fill_between(
            ticks, least, most, step="post", color=_ABLE_COLOUR, zorder=0,
            label="expected motion within the tick (declared tracking gain)",
        )  # fmt: skip
    if panel.share is not None:
        at_rest = ",\nbase at rest" if panel.carried & panel.released.keys() else ""
        axis.text(
            1.005, 0.5, f"moves {panel.share:.2f}\nof released{at_rest}", fontsize=8, va="center",
            transform=axis.transAxes, color=str(_STYLES["measured"]["color"]),
        )  # fmt: skip
    words = [panel.name, panel.unit and f"[{panel.unit}]", panel.frame and f"in {panel.frame}"]
    axis.set_ylabel("\n".join(filter(None, words)), fontsize=8, rotation=0, ha="right", va="center")
    axis.set_ylim(*_range(panel))
    axis.margins(x=0.01)


def _range(panel: Panel) -> tuple[float, float]:
    """What was released and done fills the panel; what was only asked may leave it."""
    curves = [panel.released, panel.measured] if panel.released else [panel.asked, panel.measured]
    values = [value for curve in curves for value in curve.values() if not math.isnan(value)]
    low, high = min(values, default=0.0), max(values, default=0.0)
    room = ROOM * (high - low) or 1.0
    return low - room, high + room


def _with_gaps(curve: Curve) -> tuple[list[float], list[float]]:
    """Points in order of tick, with a break wherever ticks are missing; the last has its width."""
    ticks: list[float] = []
    values: list[float] = []
    for tick in sorted(curve):
        if tick - 1 not in curve and ticks:
            ticks += [ticks[-1] + 1, ticks[-1] + 1]
            values += [values[-1], math.nan]
        ticks.append(tick)
        values.append(curve[tick])
    return [*ticks, ticks[-1] + 1], [*values, values[-1]]


def _shade(held: Collection[int], axis: Axes) -> None:
    """Mark ticks in which the robot held."""
    start = None
    for tick in sorted(held):
        if start is None:
            start = tick
        if tick + 1 not in held:
            axis.axvspan(start, tick + 1, color=_HOLD_COLOUR, label="held", zorder=0)
            start = None


def _mark_refusals(run: Run, axis: Axes) -> None:
    colour = _OUTCOMES[Outcome.REFUSED][2]
    for tick, verdict in run.first_verdicts().values():
        if verdict.outcome == Outcome.REFUSED:
            axis.axvline(tick, color=colour, linewidth=0.8, linestyle=":", label="chunk refused")


def _draw_verdicts(run: Run, axis: Axes) -> None:
    first, counts = _first_tick(run), verdict_counts(run)
    for level, (outcome, (name, marker, colour)) in enumerate(_OUTCOMES.items()):
        codes: dict[int, list[str]] = {}
        for tick, verdict in run.first_verdicts().values():
            if verdict.outcome == outcome:
                codes.setdefault(tick, []).append(f"G{verdict.code:03d}" if verdict.code else "")
        axis.plot(list(codes), [level] * len(codes), marker, color=colour, markersize=7)
        for number, (tick, texts) in enumerate(codes.items()):
            late = tick > first + LATE * (run.tick - first)  # it would leave the frame
            axis.annotate(
                ", ".join(sorted(set(texts) - {""})), (tick, level), fontsize=7, color=colour,
                # neighbours take turns above and below, or their codes would overlap
                xytext=(-5 if late else 5, 4 if number % 2 else -9), textcoords="offset points",
                ha="right" if late else "left",
            )  # fmt: skip
        axis.text(
            1.005, level, f"{counts.get(name, 0)} {name}", color=colour, fontsize=8, va="center",
            transform=axis.get_yaxis_transform(),
        )  # fmt: skip
    for tick, why, _ in run.stops:
        late = tick > first + LATE * (run.tick - first)
        axis.annotate(
            why, (tick, len(_OUTCOMES) - 0.5), fontsize=7, color=_STOP_COLOUR, va="top",
            xytext=(-3 if late else 3, 0), textcoords="offset points",
            ha="right" if late else "left",
        )  # fmt: skip
    axis.set_yticks(range(len(_OUTCOMES)), [name for name, *_ in _OUTCOMES.values()], fontsize=8)
    axis.set_ylim(-0.6, len(_OUTCOMES) - 0.4)
    axis.set_ylabel("chunks", fontsize=8, rotation=0, ha="right", va="center")


def _first_tick(run: Run) -> int:
    return run.joints[0].tick if run.joints else 0


def _label_time(run: Run, robot: RobotManifest, column: Sequence[Axes]) -> None:
    period_s, first = robot.tick_period_ns / 1e9, _first_tick(run)
    column[-1].set_xlabel(f"tick (one is {1e3 * period_s:g} ms); refused chunks carry their code")
    above = column[0].secondary_xaxis(
        "top",
        functions=(
            lambda tick: (np.asarray(tick) - first) * period_s,
            lambda seconds: np.asarray(seconds) / period_s + first,
        ),
    )
    above.set_xlabel("robot time [s]", fontsize=8)


def verdict_counts(run: Run) -> dict[str, int]:
    """How many chunks of all sources had which outcome; a copy's answer counts no second time."""
    return Counter(
        Outcome(verdict.outcome).name.lower() for _, verdict in run.first_verdicts().values()
    )


def hold_names(run: Run) -> dict[str, int]:
    """How many ticks were held for each reason, by every part."""
    return dict(Counter(Hold(hold).name.lower() for hold in held_ticks(run).values()))
