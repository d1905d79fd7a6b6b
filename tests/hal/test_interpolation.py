"""What a faster drive is told between setpoints: SciPy's spline, and never beyond the setpoints."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from scipy.interpolate import BSpline

from fairlead.hal.interpolation import Interpolator, LinearInterpolator, SplineInterpolator
from fairlead.messages import FloatArray

N_DOF, PERIODS, PER_PERIOD = 7, 40, 25
PLACES = np.arange(1, PER_PERIOD + 1) / PER_PERIOD


@pytest.fixture(params=range(3))
def setpoints(request: pytest.FixtureRequest) -> FloatArray:
    """``[PERIODS, N_DOF]``: walks that also leap, rest and turn back."""
    rng = np.random.default_rng(request.param)
    steps = rng.uniform(-1.0, 1.0, (PERIODS, N_DOF)) * rng.integers(0, 3, (PERIODS, 1))
    return np.cumsum(steps, axis=0)


def follow(setpoints: FloatArray, most: float = np.inf) -> FloatArray:
    """``[PERIODS, PER_PERIOD, N_DOF]``, from standstill at the first setpoint."""
    spline = SplineInterpolator(np.full(N_DOF, most))
    spline.restart(setpoints[0])
    ways = [spline.advance(setpoint) for setpoint in setpoints]
    return np.array([[way(place) for place in PLACES] for way in ways])


def with_start(setpoints: FloatArray) -> FloatArray:
    return np.vstack([np.tile(setpoints[0], (3, 1)), setpoints])


def test_it_is_the_spline_that_scipy_makes_of_the_same_control_points(
    setpoints: FloatArray,
) -> None:
    control = with_start(setpoints)
    theirs = BSpline(np.arange(-3, PERIODS + 4), control, 3)
    times = np.arange(PERIODS)[:, None] + PLACES
    np.testing.assert_allclose(follow(setpoints), theirs(times), rtol=0, atol=1e-12)


@pytest.mark.parametrize("most", [np.inf, 1.0, 0.3])
def test_no_position_step_or_change_is_beyond_those_of_the_setpoints(
    setpoints: FloatArray, most: float
) -> None:
    control, way = with_start(setpoints), follow(setpoints, most)
    slack = 1e-9
    for period, positions in enumerate(way):
        near = control[period : period + 4]
        assert (positions >= near.min(axis=0) - slack).all()
        assert (positions <= near.max(axis=0) + slack).all()
        steps = np.abs(np.diff(near, axis=0)).max(axis=0)
        assert (np.abs(np.diff(positions, axis=0)) * PER_PERIOD <= steps + slack).all()
        changes = np.minimum(np.abs(np.diff(near, 2, axis=0)).max(axis=0), most)
        second = np.abs(np.diff(positions, 2, axis=0)) * PER_PERIOD**2
        assert (second <= changes + 1e-6).all()
        straight = near[1] + PLACES[:, None] * (near[2] - near[1])
        assert (np.abs(positions - straight) <= changes / 6.0 + slack).all()


def test_it_stands_at_the_setpoint_three_periods_after_that_does() -> None:
    spline = SplineInterpolator(np.array([0.15]))
    spline.restart(np.zeros(1))
    for setpoint in (0.2, 0.5, 0.9):
        spline.advance(np.array([setpoint]))
    ends = [spline.advance(np.array([1.0]))(1.0)[0] for _ in range(4)]
    assert ends[0] < ends[1] < 1.0
    np.testing.assert_allclose(ends[2:], 1.0, rtol=0, atol=1e-15)


def test_velocity_leaps_by_what_is_not_smoothed_and_nothing_else(setpoints: FloatArray) -> None:
    control, most, near_by = with_start(setpoints), 0.5, 1e-7
    spline = SplineInterpolator(np.full(N_DOF, most))
    spline.restart(setpoints[0])
    ways = [spline.advance(setpoint) for setpoint in setpoints]
    for period, (before, after) in enumerate(pairwise(ways)):
        leap = (after(near_by) - after(0.0) - before(1.0) + before(1.0 - near_by)) / near_by
        change = np.diff(control[period + 1 : period + 4], 2, axis=0)[0]
        wanted = change - np.clip(change, -most, most)
        np.testing.assert_allclose(leap, wanted, rtol=0, atol=1e-5)


@pytest.mark.parametrize("interpolator", [LinearInterpolator(), SplineInterpolator(np.ones(1))])
def test_a_steady_motion_is_as_late_as_declared(interpolator: Interpolator) -> None:
    interpolator.restart(np.zeros(1))
    for period in range(1, 6):
        way = interpolator.advance(np.array([0.1 * period]))
    wanted = 0.1 * (5 - interpolator.lag_periods)
    np.testing.assert_allclose(way(1.0)[0], wanted, rtol=0, atol=1e-12)
