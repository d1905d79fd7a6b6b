"""JointReachPolicy: bring joints, in any number, and a gripper to one pose."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.layout import load_layout
from fairlead.messages import FloatArray
from fairlead.policy import Actions, Done, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead.skill.slots import Slot

ACCELERATION_RAD = 0.01
"""Largest change of a joint's step, per tick and tick, unless told: 4 rad/s2 at 20 Hz."""
LOST_RAD = 0.25
"""A joint this far from its plan did something else: plan anew from where it is."""

Finite = Annotated[float, Field(allow_inf_nan=False)]
_WHO = "joint_reach policy"


class JointReachOptions(BaseModel):
    """Where to, and how fast.

    target_rad: of each joint of the slots with joint_position.
    opening_m, or opening_rad of a gripper that turns: where a slot with gripper_position follows.
    step_rad: fastest, per tick. acceleration_rad: largest change of that, per tick.
    done_rad: without a layout, joints this near to the target have reached it.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    target_rad: tuple[Finite, ...] = Field(min_length=1)
    opening_m: Finite | None = None
    opening_rad: Finite | None = None
    step_rad: float = Field(default=0.045, gt=0.0, le=0.1)
    acceleration_rad: float = Field(default=ACCELERATION_RAD, gt=0.0, le=0.1)
    done_rad: float = Field(default=0.03, gt=0.0, le=0.5)


class JointReachPolicy:
    """Joint targets on a smooth way to a pose, all joints at once.

    Output rows (float32): the joints' targets [rad], then the gripper as its slot's scale and
    offset have it. Of a state of joints alone, without layout, it says itself when they are there.

    Args:
        gripper: output for the gripper; None without one.
        skill: its state begins with the joints; horizon: rows per chunk, one per tick.
    """

    def __init__(
        self, options: JointReachOptions, gripper: float | None, skill: SkillManifest
    ) -> None:
        self._options, self._target = options, np.array(options.target_rad)
        self._joints, self._state_dim = len(self._target), skill.state_contract.dim
        self._tail = [] if gripper is None else [gripper]
        self._says_done = skill.state_contract.layout is None
        self._horizon = skill.horizon
        self.reset()

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises as `from_options`, which reads nothing but them."""
        cls.from_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Raises `ConfigError` for options, a state or an action that do not fit."""
        checked = checked_model(_WHO, JointReachOptions, options)
        names, others = _commanded(skill)
        if not names:
            first = skill.action_contract.routed[0].name
            raise ConfigError(expected(_WHO, "a first slot of joint_position", first))
        if len(checked.target_rad) != len(names):
            what = f"target_rad of {len(names)} joints, {', '.join(names)}"
            raise ConfigError(expected(_WHO, what, len(checked.target_rad)))
        seen = _seen(skill)[: len(names)]
        if seen != names:
            what = f"a state that begins with the positions of {', '.join(names)} in rad"
            raise ConfigError(expected(_WHO, what, ", ".join(seen) or "none"))
        return cls(checked, _gripper(checked, others), skill)

    def reset(self) -> None:
        """Forget the plan: the next observation is where the way begins."""
        self._plan: dict[int, tuple[FloatArray, FloatArray]] = {}  # by row of the newest answer
        self._plan_tick = 0  # of that answer

    def infer(self, observation: Observation) -> Actions | Done:
        """One chunk, shape ``[horizon, dim]``, from a state that begins with the joints.

        It goes on from its own target of the tick before, not from the joints, which
        follow a little later: targets stay smooth from chunk to chunk. After a tick in
        which a part held it plans anew from the joints.

        Raises:
            PolicyError: for a state of another size.
        """
        state = np.asarray(observation.state, dtype=np.float64)
        if state.shape != (self._state_dim,):
            what = f"a state of shape ({self._state_dim},)"
            raise PolicyError(expected("joint_reach", what, state.shape))
        joints, done_rad = state[: self._joints], self._options.done_rad
        if self._says_done and np.all(np.abs(self._target - joints) < done_rad):
            return Done(f"every joint is within {done_rad:g} rad of the target")
        if any(part.hold for part in observation.executed.values()):
            self._plan = {}
        acting = (observation.tick - 1 - self._plan_tick) // observation.periods
        at, step = self._plan.get(acting, (joints, np.zeros(self._joints)))
        if np.any(np.abs(at - joints) > LOST_RAD):
            at, step = joints, np.zeros(self._joints)
        rows = np.tile(np.array([*self._target, *self._tail], np.float32), (self._horizon, 1))
        self._plan, self._plan_tick = {}, observation.tick
        for row in range(self._horizon):
            step = self._next_step(at, step)
            at = at + step
            self._plan[row] = (at, step)
            rows[row, : self._joints] = at
        return rows

    def _next_step(self, at: FloatArray, step: FloatArray) -> FloatArray:
        """Faster by no more than the acceleration, and slow enough to stop at the target."""
        error, acceleration = self._target - at, self._options.acceleration_rad
        left = np.abs(error)
        faster = np.maximum(step * np.sign(error), 0.0) + acceleration
        braking = np.sqrt(2.0 * acceleration * left)
        fastest = np.full(self._joints, self._options.step_rad)
        size = np.minimum.reduce([left, faster, braking, fastest])
        return np.asarray(np.sign(error) * size)


def _commanded(skill: SkillManifest) -> tuple[tuple[str, ...], Sequence[Slot]]:
    """The joints whose positions the first slots are, in rad as they are, and the other slots."""
    slots = list(skill.action_contract.routed)
    names: list[str] = []
    while slots and slots[0].control_mode == "joint_position" and all(slots[0].in_units()):
        if slots[0].first != len(names) or slots[0].unit == "deg":
            break
        names += slots.pop(0).joint_names or ()
    return tuple(names), slots


def _seen(skill: SkillManifest) -> tuple[str, ...]:
    """Joints whose positions in rad the state begins with."""
    contract = skill.state_contract
    if contract.layout is not None:
        return load_layout(contract.layout).bound_joints(contract.bindings)
    found: list[str] = []
    for field in contract.joints:
        if (field.quantity, field.unit, field.in_units) != ("position", "rad", True):
            break
        found += field.names
    return tuple(found)


def _gripper(options: JointReachOptions, others: Sequence[Slot]) -> float | None:
    """What the gripper's slot is given, so that it comes to the opening that is asked for."""
    asked = [one for one in (options.opening_m, options.opening_rad) if one is not None]
    modes = [slot.control_mode for slot in others]
    wanted = ["gripper_position"] * len(asked)
    if len(asked) > 1 or modes != wanted:
        what = "opening_m or opening_rad, and a slot of gripper_position behind the arm's; or none"
        raise ConfigError(expected(_WHO, what, f"{asked} and slots {modes}"))
    if not asked:
        return None
    return (asked[0] - others[0].offsets()[0]) / others[0].scales()[0]
