"""JointReachPolicy: bring an arm of seven joints and its gripper, or any joints, to one pose."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.messages import FloatArray
from fairlead.policy import Actions, Done, Observation
from fairlead.skill.manifest import SkillManifest

LAYOUT = "libero"
ARM_JOINTS = 7
STATE_DIM = 9
ACTION_DIM = 8
FULL_OPENING_M = 0.08
ACCELERATION_RAD = 0.01
"""Largest change of a joint's step, per tick and tick, unless told: 4 rad/s2 at 20 Hz."""
LOST_RAD = 0.25
"""A joint this far from its plan did something else: plan anew from where it is."""

Finite = Annotated[float, Field(allow_inf_nan=False)]


class JointReachOptions(BaseModel):
    """Where to, and how fast.

    target_rad: of seven joints with layout libero, else of each joint of the state.
    opening_m: total opening, with layout libero only.
    step_rad: fastest, per tick. acceleration_rad: largest change of that, per tick.
    done_rad: without a layout, joints this near to the target have reached it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    target_rad: tuple[Finite, ...] = Field(min_length=1)
    opening_m: float | None = Field(default=None, ge=0.0, le=FULL_OPENING_M)
    step_rad: float = Field(default=0.045, gt=0.0, le=0.1)
    acceleration_rad: float = Field(default=ACCELERATION_RAD, gt=0.0, le=0.1)
    done_rad: float = Field(default=0.03, gt=0.0, le=0.5)


class JointReachPolicy:
    """Joint targets on a smooth way to a pose, all joints at once.

    Output rows (float32): with layout libero 8 wide, seven joint targets [rad], then the gripper
    in [-1, 1], +1 fully open. Of a state that is joints alone, the targets of these [rad]; then
    the policy says itself when they are there.

    Args:
        horizon: rows per chunk, one per tick.
    """

    def __init__(self, options: JointReachOptions, horizon: int) -> None:
        self._options = options
        self._target = np.array(options.target_rad)
        self._arm = len(self._target)
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
        state, dim, arm = skill.state_contract, skill.action_contract.dim, len(checked.target_rad)
        if state.layout not in (None, LAYOUT):
            raise ConfigError(expected(who, f"layout {LAYOUT}", state.layout_name))
        if state.layout is None:
            if checked.opening_m is not None:
                raise ConfigError(expected(who, f"layout {LAYOUT} with opening_m", "joints alone"))
            if not state.dim == dim == arm:
                what = f"a state and an action of {arm}, as target_rad"
                raise ConfigError(expected(who, what, f"{state.dim} and {dim}"))
        elif arm != ARM_JOINTS or checked.opening_m is None:
            got = f"{arm} and opening_m {checked.opening_m}"
            raise ConfigError(expected(who, f"target_rad of {ARM_JOINTS} and opening_m", got))
        elif dim != ACTION_DIM:
            raise ConfigError(expected(who, f"an action of {ACTION_DIM}", dim))
        return cls(checked, skill.horizon)

    def reset(self) -> None:
        """Forget the plan: the next observation is where the way begins."""
        self._plan: dict[int, tuple[FloatArray, FloatArray]] = {}

    def infer(self, observation: Observation) -> Actions | Done:
        """One chunk, shape ``[horizon, dim]``, from a state of layout ``libero`` or of joints.

        It goes on from its own target of the tick before, not from the joints, which
        follow a little later: targets stay smooth from chunk to chunk. After a tick in
        which a part held it plans anew from the joints.

        Raises:
            PolicyError: for a state of another size.
        """
        state, arm = np.asarray(observation.state, dtype=np.float64), self._arm
        dim = arm if self._options.opening_m is None else STATE_DIM
        if state.shape != (dim,):
            raise PolicyError(expected("joint_reach", f"a state of shape ({dim},)", state.shape))
        joints = state[:arm]
        if dim == arm and np.all(np.abs(self._target - joints) < self._options.done_rad):
            return Done(f"every joint is within {self._options.done_rad:g} rad of the target")
        if any(part.hold for part in observation.executed.values()):
            self._plan = {}
        at, step = self._plan.get(observation.tick - 1, (joints, np.zeros(arm)))
        if np.any(np.abs(at - joints) > LOST_RAD):
            at, step = joints, np.zeros(arm)
        rows = []
        self._plan = {}
        for row in range(self._horizon):
            step = self._next_step(at, step)
            at = at + step
            self._plan[observation.tick + row] = (at, step)
            rows.append([*at, *self._gripper])
        return np.array(rows, dtype=np.float32)

    @property
    def _gripper(self) -> tuple[float, ...]:
        opening_m = self._options.opening_m
        return () if opening_m is None else (2.0 * opening_m / FULL_OPENING_M - 1.0,)

    def _next_step(self, at: FloatArray, step: FloatArray) -> FloatArray:
        """Faster by no more than the acceleration, and slow enough to stop at the target."""
        error, acceleration = self._target - at, self._options.acceleration_rad
        left = np.abs(error)
        faster = np.maximum(step * np.sign(error), 0.0) + acceleration
        braking = np.sqrt(2.0 * acceleration * left)
        size = np.minimum.reduce(
            [left, faster, braking, np.full(self._arm, self._options.step_rad)]
        )
        return np.asarray(np.sign(error) * size)
