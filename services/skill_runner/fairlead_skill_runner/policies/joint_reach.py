"""JointReachPolicy: bring an arm of seven joints and its gripper to one pose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.messages import FloatArray
from fairlead.policy import Actions, Observation
from fairlead.skill.manifest import SkillManifest

LAYOUT = "libero"
ARM_JOINTS = 7
STATE_DIM = 9
ACTION_DIM = 8
FULL_OPENING_M = 0.08
ACCELERATION_RAD = 0.01
"""Largest change of a joint's step, per tick and tick: 4 rad/s2 at 20 Hz."""
LOST_RAD = 0.25
"""A joint this far from its plan did something else: plan anew from where it is."""

Finite = Annotated[float, Field(allow_inf_nan=False)]


class JointReachOptions(BaseModel):
    """target_rad: seven joints. opening_m: total opening. step_rad: fastest, per tick."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    target_rad: tuple[Finite, ...] = Field(min_length=ARM_JOINTS, max_length=ARM_JOINTS)
    opening_m: float = Field(ge=0.0, le=FULL_OPENING_M)
    step_rad: float = Field(default=0.045, gt=0.0, le=0.1)


class JointReachPolicy:
    """Joint targets on a smooth way to a pose, all joints at once.

    Output rows (float32, 8 wide): seven joint targets [rad], then the gripper in [-1, 1],
    +1 fully open.

    Args:
        horizon: rows per chunk, one per tick.
    """

    def __init__(self, options: JointReachOptions, horizon: int) -> None:
        self._target = np.array(options.target_rad)
        self._gripper = 2.0 * options.opening_m / FULL_OPENING_M - 1.0
        self._step = options.step_rad
        self._horizon = horizon
        self.reset()

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises as `from_options`, which reads nothing but them."""
        cls.from_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Raises `ConfigError` for options, a layout or an action width that do not fit."""
        who = "joint_reach policy"
        checked = checked_model(who, JointReachOptions, options)
        if skill.state_contract.layout != LAYOUT:
            what = f"layout {LAYOUT}"
            raise ConfigError(expected(who, what, skill.state_contract.layout_name))
        dim = skill.action_contract.dim
        if dim != ACTION_DIM:
            raise ConfigError(expected(who, f"an action of {ACTION_DIM}", dim))
        return cls(checked, skill.horizon)

    def reset(self) -> None:
        """Forget the plan: the next observation is where the way begins."""
        self._plan: dict[int, tuple[FloatArray, FloatArray]] = {}

    def infer(self, observation: Observation) -> Actions:
        """One chunk, shape ``[horizon, 8]``, from a state of layout ``libero``.

        It goes on from its own target of the tick before, not from the joints, which
        follow a little later: targets stay smooth from chunk to chunk. After a tick in
        which a part held it plans anew from the joints.

        Raises:
            PolicyError: for a state of another size.
        """
        state = np.asarray(observation.state, dtype=np.float64)
        if state.shape != (STATE_DIM,):
            what = f"a state of shape ({STATE_DIM},)"
            raise PolicyError(expected("joint_reach", what, state.shape))
        joints = state[:ARM_JOINTS]
        if any(part.hold for part in observation.executed.values()):
            self._plan = {}
        at, step = self._plan.get(observation.tick - 1, (joints, np.zeros(ARM_JOINTS)))
        if np.any(np.abs(at - joints) > LOST_RAD):
            at, step = joints, np.zeros(ARM_JOINTS)
        rows = np.full((self._horizon, ACTION_DIM), self._gripper, dtype=np.float32)
        self._plan = {}
        for row in range(self._horizon):
            step = self._next_step(at, step)
            at = at + step
            self._plan[observation.tick + row] = (at, step)
            rows[row, :ARM_JOINTS] = at
        return rows

    def _next_step(self, at: FloatArray, step: FloatArray) -> FloatArray:
        """Faster by no more than the acceleration, and slow enough to stop at the target."""
        error = self._target - at
        left = np.abs(error)
        faster = np.maximum(step * np.sign(error), 0.0) + ACCELERATION_RAD
        braking = np.sqrt(2.0 * ACCELERATION_RAD * left)
        size = np.minimum.reduce([left, faster, braking, np.full(ARM_JOINTS, self._step)])
        return np.asarray(np.sign(error) * size)
