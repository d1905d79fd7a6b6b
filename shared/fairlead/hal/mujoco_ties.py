"""Joints of a MuJoCo model that equalities tie to others: they stand where their leaders say."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import mujoco
import numpy as np

from fairlead.messages import FloatArray


@dataclass(frozen=True)
class Tie:
    """Number of the joint that follows another, and the polynomial by which it does."""

    follower: int
    leader: int
    polynomial: FloatArray


def joint_ties(model: mujoco.MjModel, told: Collection[int]) -> list[Tie]:
    """What follows the joints that are told, by number, leaders before what follows them."""
    every = [
        Tie(int(model.eq_obj1id[one]), int(model.eq_obj2id[one]), model.eq_data[one, :5])
        for one in range(model.neq)
        if model.eq_type[one] == mujoco.mjtEq.mjEQ_JOINT and model.eq_active0[one]
    ]
    found, known = list[Tie](), set(told)
    while new := [one for one in every if one.leader in known and one.follower not in known]:
        found += new
        known.update(one.follower for one in new)
    return found


def follow(model: mujoco.MjModel, qpos: FloatArray, ties: Sequence[Tie]) -> None:
    """Move what is tied to where its leaders stand."""
    for tie in ties:
        follower, leader = model.jnt_qposadr[[tie.follower, tie.leader]]
        moved = qpos[leader] - model.qpos0[leader]
        qpos[follower] = model.qpos0[follower] + np.polyval(tie.polynomial[::-1], moved)
