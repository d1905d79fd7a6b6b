"""Where the base goes, at headings of 0, 90 and 180 degrees."""

from __future__ import annotations

import numpy as np
import pytest

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend

pytestmark = pytest.mark.simulator

TICK_S = 0.05


def turn_to(backend: RobosuiteBackend, yaw: float) -> None:
    """Turn on the spot by base_yaw alone, and come to rest."""
    backend.reset(0)
    rates = np.zeros(11)
    for _ in range(200):
        error = yaw - backend.read().positions[2]
        if abs(error) < 0.01:
            break
        rates[2] = np.clip(error * 4, -1.0, 1.0) + np.sign(error) / 6
        backend.apply({"base": PartCommand(ControlMode.JOINT_VELOCITY, "", rates, (2,))})
    for _ in range(10):
        backend.apply({})
    assert backend.read().positions[2] == pytest.approx(yaw, abs=0.02)


def base_pose(backend: RobosuiteBackend) -> tuple[FloatArray, float]:
    """Position of base_link in odom [m] and its heading [rad]."""
    frame = next(f for f in backend.transforms() if f.child == "base_link")
    z, w = frame.rotation_xyzw[2:]
    return frame.translation[:2], float(2 * np.arctan2(z, w))


def in_own_frame(yaw: float, step: FloatArray) -> FloatArray:
    cos, sin = np.cos(yaw), np.sin(yaw)
    return np.array([cos * step[0] + sin * step[1], -sin * step[0] + cos * step[1]])


@pytest.mark.parametrize("yaw", [0.0, np.pi / 2, np.pi])
@pytest.mark.parametrize("direction", [(1.0, 0.0), (0.0, -1.0)])
def test_a_body_twist_moves_the_base_as_it_says(
    backend: RobosuiteBackend, yaw: float, direction: tuple[float, float]
) -> None:
    turn_to(backend, yaw)
    speed = 0.3
    twist = np.array([speed * direction[0], speed * direction[1], 0, 0, 0, 0])
    command = PartCommand(ControlMode.BODY_TWIST, "base_link", twist, ())
    for _ in range(4):  # gather speed
        backend.apply({"base": command})
    start, heading = base_pose(backend)
    for _ in range(10):
        backend.apply({"base": command})
    moved = in_own_frame(heading, base_pose(backend)[0] - start) / (10 * TICK_S)
    np.testing.assert_allclose(moved, twist[:2], atol=0.03)


@pytest.mark.parametrize("yaw", [0.0, np.pi / 2])
def test_a_turning_twist_turns_about_base_links_origin(
    backend: RobosuiteBackend, yaw: float
) -> None:
    turn_to(backend, yaw)
    twist = np.array([0, 0, 0, 0, 0, 0.6])
    start, heading = base_pose(backend)
    for _ in range(12):
        command = PartCommand(ControlMode.BODY_TWIST, "base_link", twist, ())
        backend.apply({"base": command})
    position, now = base_pose(backend)
    assert now - heading == pytest.approx(0.6 * 12 * TICK_S, rel=0.15)
    # Without the pivot in the calculation the origin would have swung by 74 mm.
    assert np.linalg.norm(position - start) < 0.04


@pytest.mark.parametrize(
    ("yaw", "expected"), [(0.0, (1, 0)), (np.pi / 2, (0, -1)), (np.pi, (-1, 0))]
)
def test_joint_velocity_passes_through_and_shows_the_simulators_own_frame(
    backend: RobosuiteBackend, yaw: float, expected: tuple[int, int]
) -> None:
    """Forward commands move along odom's axes turned *back* by the yaw since reset."""
    turn_to(backend, yaw)
    rates = np.zeros(11)
    rates[0] = 0.8
    start = base_pose(backend)[0].copy()
    for _ in range(12):
        backend.apply({"base": PartCommand(ControlMode.JOINT_VELOCITY, "", rates, (0, 1, 2))})
        assert backend.last_packed is not None
        assert backend.last_packed[7:10].tolist() == [np.float32(0.8), 0.0, 0.0]
    step = base_pose(backend)[0] - start
    np.testing.assert_allclose(step / np.linalg.norm(step), expected, atol=0.06)


def test_a_twist_beyond_the_joints_is_refused(backend: RobosuiteBackend) -> None:
    from fairlead.errors import ConfigError

    backend.reset(0)
    twist = np.array([0.9, 0, 0, 0, 0, 0])
    with pytest.raises(ConfigError) as caught:
        backend.apply({"base": PartCommand(ControlMode.BODY_TWIST, "base_link", twist, ())})
    assert str(caught.value) == (
        "packing: part base: expected a body_twist within joint rates of +-[1.0, 1.0, 1.5], "
        "got [1.15, 0.0, 0.0] needed for [0.9, 0.0, 0.0, 0.0, 0.0, 0.0]"
    )
