"""OraclePolicy: a scripted expert for the mobile pick-and-place task.

It sees only the state vector a learned policy would see and answers in the same
checkpoint format, so everything between policy and robot is exercised by it. It imports
no simulator.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, JsonValue

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError, PolicyError, expected
from fairlead.policy import Actions, Done, Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.policies.oracle.motion import (
    ARM_FULL_SCALE,
    ARM_GAIN,
    TICK_S,
    ArmModel,
    DriveModel,
    Vector,
    arm_drag,
    base_output,
    base_rates,
    hand_delta,
)
from fairlead_skill_runner.policies.oracle.phases import (
    Aim,
    Memory,
    Motion,
    Phase,
    advance,
    aim,
    begun,
    is_after,
)
from fairlead_skill_runner.policies.oracle.recall import recall
from fairlead_skill_runner.policies.oracle.sight import (
    STATE_DIM,
    Sight,
    read_state,
    rotation_between,
)

ACTION_DIM = 12
MODE_ARM = -1.0
"""Composite switch: deltas start from the achieved arm pose."""


PhaseName = Literal[
    "APPROACH", "ALIGN", "DESCEND", "GRASP", "LIFT", "TRANSPORT", "ENTER", "LOWER", "RELEASE",
    "RETREAT", "DONE",
]  # fmt: skip


class OracleOptions(BaseModel):
    """horizon: rows per call; None: the skill's.

    first, last: steps of the task that it does, named as in `Phase`; it says itself when ``last``
    is over. memory: whether steps go on by what was before; without, each state alone says the
    step, as it has to for a policy that learns.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    horizon: int | None = Field(default=None, ge=1)
    first: PhaseName = "APPROACH"
    last: PhaseName = "DONE"
    memory: bool = True


class OracleSteps:
    """Carry the object from the counter into the cabinet, or a part of that.

    Output rows (float32, 12 wide): arm delta 6 in [-1, 1], gripper +-1 (+1 closes), base
    3 in [-1, 1], torso 0, composite switch -1.

    Args:
        horizon: rows per chunk, one per tick.
        first, last: the steps that it does.
        has_memory: see `OracleOptions`.
    """

    def __init__(
        self,
        horizon: int = 8,
        first: Phase = Phase.APPROACH,
        last: Phase = Phase.DONE,
        has_memory: bool = True,
    ) -> None:
        self._horizon, self._first, self._last = horizon, first, last
        self._has_memory = has_memory
        self.reset()

    @classmethod
    def check_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> None:
        """Raises as `from_options`, which reads nothing but them."""
        cls.from_options(skill, options)

    @classmethod
    def from_options(cls, skill: SkillManifest, options: Mapping[str, JsonValue]) -> Self:
        """Raises `ConfigError` for options it does not know, or steps of which none is left."""
        checked = checked_model("oracle policy", OracleOptions, options)
        steps = Phase[checked.first], Phase[checked.last]
        if is_after(*steps):
            wanted, got = "a step that is not after last", f"{checked.first} after {checked.last}"
            raise ConfigError(expected("oracle policy: first", wanted, got))
        return cls(checked.horizon or skill.horizon, *steps, checked.memory)

    def reset(self) -> None:
        """Forget everything: the next observation starts a new episode."""
        self._memory: Memory | None = None
        self._home_quat: Vector = np.zeros(4)
        self._forecast: list[tuple[ArmModel, ArmModel, DriveModel]] = []
        self._forecast_tick = 0

    @property
    def phase(self) -> str:
        """What it is doing, for people."""
        return self._memory.phase.value if self._memory else "waiting"

    def infer(self, observation: Observation) -> Actions | Done:
        """One chunk, shape ``[horizon, 12]``, from a state of layout ``mobile_pick_30d``.

        Raises:
            PolicyError: for a state of another size.
        """
        state = np.asarray(observation.state, dtype=np.float64)
        if state.shape != (STATE_DIM,):
            raise PolicyError(expected("oracle", f"a state of shape ({STATE_DIM},)", state.shape))
        sight = read_state(state, int(observation.tick))
        if self._memory is None:
            self._memory = begun(self._first, sight)
            self._home_quat = sight.eef_quat
        hand, wrist, base = self._now(sight)
        if self._has_memory:
            advance(self._memory, sight, Motion(hand.velocity, base.velocity))
        else:
            self._memory = recall(sight, self._memory.home_yaw)
        if is_after(self._memory.phase, self._last):
            return Done(f"after: {self._last.value}")
        return self._chunk(aim(self._memory, sight), hand, wrist, base, sight.tick)

    def _now(self, sight: Sight) -> tuple[ArmModel, ArmModel, DriveModel]:
        """Seen poses with the speeds the last chunk should have led to by now."""
        wrist_turn = rotation_between(self._home_quat, sight.eef_quat)
        rows = sight.tick - self._forecast_tick
        if 0 < rows <= len(self._forecast):
            hand, wrist, base = self._forecast[rows - 1]
            speeds = hand.velocity, wrist.velocity, base.velocity, base.wanted
        else:
            speeds = np.zeros(3), np.zeros(3), np.zeros(3), np.zeros(3)
        return (
            ArmModel(sight.eef, speeds[0]),
            ArmModel(wrist_turn, speeds[1]),
            DriveModel(sight.base, speeds[2], speeds[3]),
        )

    def _chunk(
        self, target: Aim, hand: ArmModel, wrist: ArmModel, base: DriveModel, tick: int
    ) -> Actions:
        """Roll the models forward under the feedback laws and write down the commands."""
        rows = np.zeros((self._horizon, ACTION_DIM), dtype=np.float32)
        self._forecast, self._forecast_tick = [], tick
        for row in rows:
            rates = base_rates(base, target.base)
            drag = arm_drag(float(rates[2]), hand.position)
            move = hand_delta(ARM_GAIN * (target.eef - hand.position) + drag)
            rotate = -ARM_GAIN * wrist.position
            arm = np.clip(np.append(move, rotate) / ARM_FULL_SCALE, -1.0, 1.0)
            row[0:6] = arm
            row[6] = target.gripper
            row[7:10] = base_output(rates, float(base.pose[2] + base.velocity[2] * TICK_S / 2))
            row[11] = MODE_ARM
            done = arm * ARM_FULL_SCALE
            hand = ArmModel(hand.position, hand.velocity)
            wrist = ArmModel(wrist.position, wrist.velocity)
            base = DriveModel(base.pose, base.velocity, base.wanted)
            hand.advance(done[:3] - drag)
            wrist.advance(done[3:])
            base.advance(rates)
            base.wanted = rates
            self._forecast.append((hand, wrist, base))
        return rows


class OraclePolicy(OracleSteps):
    """The whole task, which never says that it is done."""

    def infer(self, observation: Observation) -> Actions:
        """As `OracleSteps`."""
        answer = super().infer(observation)
        assert not isinstance(answer, Done)
        return answer
