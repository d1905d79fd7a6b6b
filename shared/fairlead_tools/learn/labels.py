"""What the scripted expert would have done: in every recorded state, and in states beside it.

An episode shows few states. Beside each are more that the robot can get into: its hand elsewhere,
its base elsewhere, what it holds with it. The expert, which sees states alone, answers in each of
them as it is at that moment, so that a policy learns the way back without a simulator.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from fairlead.messages import FloatArray
from fairlead.policy import Observation, Policy
from fairlead_tools.learn.dataset import Episode

HAND_M, BASE_M, TURN_RAD = 0.03, 0.05, 0.04
"""Standard deviations of how far beside."""

EVERY = 2
"""Ticks between states that are labelled beside."""

HELD_M, OPEN_M = 0.06, 0.07
"""An object nearer to the hand than the first, between fingers closer than the second, is held."""


class Labels(NamedTuple):
    """states: float64 ``[n, 30]`` of ``mobile_pick_30d``. rows: float32 ``[n, H, dim]``."""

    states: FloatArray
    rows: npt.NDArray[np.float32]


def label(expert: Policy, episodes: Sequence[Episode], beside: int, seed: int) -> Labels:
    """Of every tick of every episode, and ``beside`` times beside each second one."""
    pairs = [
        pair
        for episode in episodes
        for pair in _of(expert, episode, beside, np.random.default_rng(seed + episode.seed))
    ]
    states, rows = zip(*pairs, strict=True)
    return Labels(np.array(states), np.array(rows))


def _of(
    expert: Policy, episode: Episode, beside: int, rng: np.random.Generator
) -> Iterator[tuple[FloatArray, npt.NDArray[np.float32]]]:
    expert.reset()
    for tick, state in enumerate(episode.states, start=1):
        before = copy.deepcopy(expert)
        yield state, _rows(expert, tick, state)
        if tick % EVERY == 0:  # never the first, where it remembers to have begun
            for _ in range(beside):
                near = state_beside(state, rng)
                yield near, _rows(copy.deepcopy(before), tick, near)


def _rows(expert: Policy, tick: int, state: FloatArray) -> npt.NDArray[np.float32]:
    rows = expert.infer(Observation(tick, state, ""))
    assert isinstance(rows, np.ndarray)
    return rows


def state_beside(state: FloatArray, rng: np.random.Generator) -> FloatArray:
    """A ``mobile_pick_30d`` vector with hand and base moved; the world stays where it is."""
    size = rng.choice([0.15, 0.5, 1.0])  # most errors are small
    hand = rng.normal(0, HAND_M * size, 3)
    shift = rng.normal(0, BASE_M * size, 2)
    turn = rng.normal(0, TURN_RAD * size)
    made = state.copy()
    is_held = np.linalg.norm(state[16:19] - state[0:3]) < HELD_M and state[14] - state[15] < OPEN_M
    made[0:3] += hand
    made[7:9] += shift
    made[10:14] = _turned(state[10:14], turn)
    yaw = 2 * np.arctan2(state[12], state[13])
    moved = _rotation(-yaw) @ shift
    for first in (16, 23):
        if first == 16 and is_held:
            made[16:19] += hand  # it goes with the hand, in the base's frame
            continue
        made[first : first + 2] = _rotation(-turn) @ (state[first : first + 2] - moved)
        made[first + 3 : first + 7] = _turned(state[first + 3 : first + 7], -turn)
    return made


def _rotation(angle: float) -> FloatArray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin], [sin, cos]])


def _turned(quaternion: FloatArray, angle: float) -> FloatArray:
    """``Rz(angle) * q``, xyzw with w >= 0."""
    x, y, z, w = quaternion
    cos, sin = np.cos(angle / 2), np.sin(angle / 2)
    turned = np.array([cos * x - sin * y, cos * y + sin * x, cos * z + sin * w, cos * w - sin * z])
    return turned if turned[3] >= 0 else -turned
