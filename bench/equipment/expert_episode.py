"""Run the expert against the simulator in one process, without any service."""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np
import numpy.typing as npt

from fairlead.hal.backend import PartCommand
from fairlead.messages import FloatArray
from fairlead.modes import ControlMode
from fairlead.policy import Observation
from fairlead_hal_sim.robosuite_backend import RobosuiteBackend
from fairlead_skill_runner.policies.oracle.policy import OraclePolicy

DELTA_SCALE = np.array([0.05, 0.05, 0.05, 0.5, 0.5, 0.5])
BASE_SCALE = np.array([1.0, 1.0, 1.5])
BASE_JOINTS = (0, 1, 2)


@dataclass(frozen=True)
class Episode:
    """How one episode went. Ticks count from the first policy call."""

    seed: int
    success_tick: int | None
    near_tick: int | None
    base_travel_m: float
    phase: str
    ticks: int


def true_state(backend: RobosuiteBackend) -> FloatArray:
    """The ``mobile_pick_30d`` vector straight from the simulator's newest positions."""
    poses = backend._poses
    poses.update()
    data, model = poses._scratch, poses._model
    base = model.site("mobilebase0_center").id
    # Sites need a pass of their own; mj_kinematics has just filled them.
    rotation = data.site_xmat[base].reshape(3, 3)
    origin = data.site_xpos[base]
    grip = data.site_xpos[model.site("gripper0_right_grip_site").id]
    parts = [
        rotation.T @ (grip - origin),
        _quat(rotation.T @ data.xmat[model.body("robot0_right_hand").id].reshape(3, 3)),
        origin,
        _quat(rotation),
        backend.read().positions[11:13],
    ]
    for name in ("can_main", "goal"):
        body = model.body(name).id
        parts.append(rotation.T @ (data.xpos[body] - origin))
        parts.append(_quat(rotation.T @ data.xmat[body].reshape(3, 3)))
    return np.concatenate(parts)


def commands(row: npt.NDArray[np.float32]) -> dict[str, PartCommand]:
    """One checkpoint-format row as SI part commands."""
    values = row.astype(np.float64)
    base = np.zeros(11)
    base[:3] = values[7:10] * BASE_SCALE
    opening = values[6:7] * -0.04 + 0.04
    return {
        "arm": PartCommand(ControlMode.CARTESIAN_DELTA, "base_link", values[:6] * DELTA_SCALE, ()),
        "gripper": PartCommand(ControlMode.GRIPPER_POSITION, "", opening, ()),
        "base": PartCommand(ControlMode.JOINT_VELOCITY, "", base, BASE_JOINTS),
        "composite": PartCommand(ControlMode.COMPOSITE_MODE, "", values[11:12], ()),
    }


def run_episode(
    backend: RobosuiteBackend, seed: int, max_ticks: int = 450, chunk: int = 8
) -> Episode:
    """Reset, hold one tick, then let the expert work until success or ``max_ticks``."""
    policy = OraclePolicy()
    backend.reset(seed)
    backend.apply({})
    near, success, travel_m = None, None, 0.0
    rows = np.zeros((0, 12), dtype=np.float32)
    tick = 0
    while tick < max_ticks and success is None:
        if tick % chunk == 0:
            rows = policy.infer(Observation(tick + 1, true_state(backend), ""))
        backend.apply(commands(rows[tick % chunk]))
        tick += 1
        reading = backend.task()
        assert reading is not None
        travel_m = reading.metrics["base_travel"]
        if near is None and reading.metrics["object_gripper_distance"] < 0.10:
            near = tick
        success = tick if reading.success else None
    return Episode(seed, success, near, travel_m, policy.phase, tick)


def _quat(rotation: FloatArray) -> FloatArray:
    """Quaternion xyzw with w >= 0 of a rotation matrix."""
    q = np.zeros(4)
    mujoco.mju_mat2Quat(q, np.ascontiguousarray(rotation).reshape(9))
    q = q if q[0] >= 0 else -q
    return q[[1, 2, 3, 0]]
