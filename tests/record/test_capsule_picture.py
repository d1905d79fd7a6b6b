"""The picture of a robot's shape: outlines by hand, and a file with both views."""

from __future__ import annotations

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from fairlead_tools.record.capsule_picture import RoundedHull, draw_capsules, outline

SIDE = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # x across, z up


def test_a_box_seen_from_the_side_is_a_rectangle() -> None:
    corners = [[x, y, z] for x in (0.0, 2.0) for y in (0.0, 9.0) for z in (0.0, 1.0)]
    line = outline(RoundedHull("a", np.array(corners), 0.0), SIDE)
    assert {tuple(point) for point in line.tolist()} == {(0, 0), (2, 0), (2, 1), (0, 1)}


def test_a_capsule_is_as_long_and_wide_as_it_is_and_seen_along_itself_a_disc() -> None:
    upright = RoundedHull("a", np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 3.0]]), 0.5)
    line = outline(upright, SIDE)
    assert line.min(axis=0) == pytest.approx([-0.5, -0.5], abs=2e-3)
    assert line.max(axis=0) == pytest.approx([0.5, 3.5], abs=2e-3)
    away = RoundedHull("a", np.array([[0.0, 0.0, 0.0], [0.0, 3.0, 0.0]]), 0.5)
    assert np.linalg.norm(outline(away, SIDE), axis=1) == pytest.approx(0.5, abs=2e-3)


def test_capsules_in_one_place_are_drawn_with_numbers_apart(tmp_path: Path) -> None:
    point = np.zeros((1, 3))
    capsules = [RoundedHull("one", point, 0.2), RoundedHull("other", point, 0.1)]
    path = tmp_path / "shape.png"
    draw_capsules([RoundedHull("one", point, 0.05)], capsules, "a title", path)
    pixels = matplotlib.image.imread(path)[..., :3]
    coloured = np.ptp(pixels, axis=2) > 0.1
    middle = pixels.shape[1] // 3
    assert coloured[:, :middle].sum() > 1000
    assert coloured[:, middle : 2 * middle].sum() > 1000
