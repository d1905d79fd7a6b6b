"""What the gate said of a run at one tick, as text and as a bar below a picture."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead.messages import Outcome, Verdict
from fairlead.wire.verdict_text import describe
from fairlead_tools.record.part_series import held_ticks
from fairlead_tools.record.run_log import Run

HEIGHT_PX = 72
_DPI = 100
_COLOURS = {"RELEASED": "#1e8e3e", "TRUNCATED": "#e8710a", "REFUSED": "#d93025"}
_HOLD_COLOUR, _GREY = "#b06000", "#3c4043"


@dataclass(frozen=True)
class Caption:
    """word: an outcome, or HOLDS. asked, said: of the robot, by the gate. counts: so far."""

    word: str
    asked: str
    said: str
    counts: str


def captions(run: Run, asked: str) -> Callable[[int], Caption]:
    """By tick: the newest verdict then; HOLDS where every part holds and no refusal says why."""
    verdicts, held = list(run.first_verdicts().values()), held_ticks(run)

    def caption(tick: int) -> Caption:
        given = [verdict for at, verdict in verdicts if at <= tick]
        outcomes = Counter(Outcome(verdict.outcome) for verdict in given)
        counts = (
            f"tick {tick}   chunks: {outcomes[Outcome.RELEASED]} released, "
            f"{outcomes[Outcome.TRUNCATED]} truncated, {outcomes[Outcome.REFUSED]} refused"
        )
        if not given:
            return Caption("HOLDS", asked, "no chunk yet: every part of the robot holds", counts)
        word = Outcome(given[-1].outcome).name
        if word != "REFUSED" and tick in held:
            return Caption("HOLDS", asked, "no released row for this tick", counts)
        return Caption(word, asked, _words(given[-1]), counts)

    return caption


def refusal(run: Run, asked: str, verdict: Verdict) -> Caption:
    """One verdict by itself, after the run, and whether the robot held in its last period."""
    held = "   every part holds" if run.tick - 1 in held_ticks(run) else ""
    return Caption(Outcome(verdict.outcome).name, asked, _words(verdict), f"tick {run.tick}{held}")


def _words(verdict: Verdict) -> str:
    if verdict.outcome == Outcome.REFUSED:
        return describe(verdict)
    return (
        f"chunk {verdict.seq}: rows for ticks {verdict.released_first} to {verdict.released_last}"
    )


def draw_caption(caption: Caption, width_px: int) -> npt.NDArray[np.uint8]:
    """A bar, uint8 ``[HEIGHT_PX, width_px, 3]``."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width_px / _DPI, HEIGHT_PX / _DPI), dpi=_DPI, facecolor="white")
    colour, size = _COLOURS.get(caption.word, _HOLD_COLOUR), 7.5 * width_px / 640
    figure.text(0.01, 0.78, caption.word, size=1.6 * size, weight="bold", color=colour, va="center")
    figure.text(0.99, 0.78, caption.counts, size=size, color=_GREY, ha="right", va="center")
    figure.text(0.01, 0.45, caption.asked, size=size, color=_GREY, va="center")
    figure.text(0.01, 0.17, caption.said, size=size, color=colour, va="center")
    canvas: Any = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba())[:, :, :3].copy()
