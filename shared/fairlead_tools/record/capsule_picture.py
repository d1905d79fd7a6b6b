"""A picture of a robot's shape: its links in grey, and the capsules around them, seen twice."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fairlead.messages import FloatArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes

HEIGHT_IN = 7.0
_VIEWS = {  # name: across, up and towards the eye, along the root link's axes
    "from its right": ([1, 0, 0], [0, 0, 1], [0, -1, 0], "x [m]", "z [m]"),
    "from the front": ([0, 1, 0], [0, 0, 1], [1, 0, 0], "y [m]", "z [m]"),
}
_ROUND = np.stack([np.cos(t := np.linspace(0, 2 * np.pi, 48)), np.sin(t)], axis=1)
_LINK, _LINK_EDGE = "#b8bcc2", "#5f6368"
_MARGIN_M = 0.08
_NUMBER_M = 0.045  # room that a number takes


@dataclass(frozen=True)
class RoundedHull:
    """All points within ``radius`` of the hull of ``points`` ``[n, 3]``, in the root's frame [m].

    link: what it belongs to.
    """

    link: str
    points: FloatArray
    radius: float


def draw_capsules(
    pieces: Sequence[RoundedHull], capsules: Sequence[RoundedHull], title: str, path: Path
) -> None:
    """Write the picture as a PNG file; capsules are numbered by their place in the list."""
    import matplotlib as mpl

    mpl.use("Agg")
    from matplotlib import pyplot as plt

    links = list(dict.fromkeys(one.link for one in capsules))
    palette = mpl.colormaps["tab20" if len(links) > 10 else "tab10"].colors  # type: ignore[attr-defined]
    colours = {link: palette[place % len(palette)] for place, link in enumerate(links)}
    shares = [_width(pieces, capsules, np.array(view[0])) for view in _VIEWS.values()]
    tall = _width(pieces, capsules, np.array([0, 0, 1]))
    width = HEIGHT_IN * sum(shares) / tall
    figure, axes = plt.subplots(
        1, len(_VIEWS), figsize=(width + 4.6, HEIGHT_IN + 0.9), layout="constrained",
        gridspec_kw={"width_ratios": shares}, sharey=True,
    )  # fmt: skip
    for axis, (name, view) in zip(axes, _VIEWS.items(), strict=True):
        _draw_view(axis, pieces, capsules, colours, np.array(view[:3], dtype=float))
        axis.set(title=name, xlabel=view[3], ylabel=view[4], aspect="equal")
        axis.grid(visible=True, color="#e8eaed", linewidth=0.6)
        axis.set_axisbelow(True)
    handles = [
        mpl.patches.Patch(
            facecolor=(*colours[one.link], 0.5), edgecolor=colours[one.link],
            label=f"{number}  {one.link}  (radius {one.radius * 1e3:.0f} mm)",
        )
        for number, one in enumerate(capsules)
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside right upper", frameon=False, fontsize=8)
    figure.suptitle(title, fontsize=12)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def _draw_view(
    axis: Axes,
    pieces: Sequence[RoundedHull],
    capsules: Sequence[RoundedHull],
    colours: dict[str, tuple[float, float, float]],
    view: FloatArray,
) -> None:
    plane, eye = view[:2], view[2]
    for one in sorted(pieces, key=lambda solid: float(solid.points.mean(axis=0) @ eye)):
        axis.fill(*outline(one, plane).T, facecolor=_LINK, edgecolor=_LINK_EDGE, linewidth=0.6)
    order = sorted(range(len(capsules)), key=lambda i: float(capsules[i].points.mean(axis=0) @ eye))
    for number in order:
        one, colour = capsules[number], colours[capsules[number].link]
        axis.fill(
            *outline(one, plane).T, facecolor=(*colour, 0.28), edgecolor=colour, linewidth=1.4
        )
    middles = np.array([plane @ one.points.mean(axis=0) for one in capsules])
    for number, (place, middle) in enumerate(zip(_spread(middles), middles, strict=True)):
        colour = colours[capsules[number].link]
        axis.annotate(
            str(number), xy=middle, xytext=(place[0], place[1]), ha="center", va="center",
            fontsize=7.5,
            arrowprops={"arrowstyle": "-", "color": "#3c4043", "linewidth": 0.6},
            bbox={"boxstyle": "circle,pad=0.18", "facecolor": "white", "edgecolor": colour},
        )  # fmt: skip


def _spread(middles: FloatArray) -> list[FloatArray]:
    """A place for each number ``[n, 2]``: its middle, or the nearest that no other covers."""
    placed: list[FloatArray] = []
    for middle in middles:
        ring = (
            middle + step * _NUMBER_M * np.array([np.cos(turn), np.sin(turn)])
            for step in range(40)
            for turn in np.arange(0.0, 2.0 * np.pi, np.pi / 6.0)
        )
        free = (one for one in ring if all(np.hypot(*(one - p)) >= _NUMBER_M for p in placed))
        placed.append(next(free, middle))
    return placed


def _width(
    pieces: Sequence[RoundedHull], capsules: Sequence[RoundedHull], along: FloatArray
) -> float:
    both = [
        max(float((one.points @ way).max()) + one.radius for one in (*pieces, *capsules))
        for way in (along, -along)
    ]
    return sum(both) + _MARGIN_M


def outline(solid: RoundedHull, plane: FloatArray) -> FloatArray:
    """What one sees of it along a plane's normal: a closed line ``[n, 2]`` [m].

    Args:
        plane: two directions across the view, ``[2, 3]``.
    """
    flat = solid.points @ plane.T
    if solid.radius > 0.0:
        flat = (flat[:, None, :] + solid.radius * _ROUND).reshape(-1, 2)
    order = [int(index) for index in np.lexsort((flat[:, 1], flat[:, 0]))]
    return flat[_chain(flat, order) + _chain(flat, order[::-1])]


def _chain(flat: FloatArray, order: list[int]) -> list[int]:
    """One side of the hull (Andrew's monotone chain)."""
    chain: list[int] = []
    for index in order:
        while len(chain) > 1:
            first, second = flat[chain[-1]] - flat[chain[-2]], flat[index] - flat[chain[-2]]
            if first[0] * second[1] - first[1] * second[0] > 0.0:
                break
            chain.pop()
        chain.append(index)
    return chain
