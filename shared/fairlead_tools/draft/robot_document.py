"""robot.yaml as a document: what the files say, and careful assumptions for the rest."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from fairlead.hal.setpoints import TRAVEL_SHARE
from fairlead_tools.draft.joints import DraftJoint
from fairlead_tools.draft.parts import DraftPart, grips

_LAG = {"rad": 0.1, "m": 0.01}  # what a servo may be behind at full speed
_SLACK = {"rad": 0.02, "m": 0.002}
_STILL = {"rad": 0.02, "m": 0.01}
_MEASURE = "reckoned for the simulator, measure it on the robot"
_PROTOCOL: Mapping[str, Any] = {
    "horizon_max": 64, "age_max_ticks": 10, "chunk_rate_max_hz": 20.0, "seq_jump_max": 1000,
    "state_timeout_ms": 250, "heartbeat_timeout_realtime_ms": 300,
    "heartbeat_timeout_lockstep_ms": 2000, "lease_interval_ms": 25, "idle_disarm_s": 30,
    "stops_to_latch": 3, "stop_window_s": 60, "bad_frames_limit": 5,
    "bad_frames_window_ticks": 20, "stuck_ticks": 5,
    "step_deadline_us": 100000,
}  # fmt: skip


@dataclass(frozen=True)
class DraftRobot:
    """What is known of a robot so far.

    frames: ``body:NAME`` or ``site:NAME`` of each link that the model has. bare: links without
    capsules, and why. reach: corners of the box that its tools reach [m].
    open: keys of robot.yaml that a person has to look at, and why.
    tool_steps: by part, how far its tool may be told to move in a period [m, rad].
    singularity_limits: by part, of its tool's Jacobian [m].
    """

    id: str
    period_ms: float
    base_frame: str
    joints: Sequence[DraftJoint]
    parts: Sequence[DraftPart]
    home: Mapping[str, float]
    home_source: str
    base_body: str = ""
    frames: Mapping[str, str] = field(default_factory=dict)
    bare: Mapping[str, str] = field(default_factory=dict)
    reach: tuple[Sequence[float], Sequence[float]] = ((-1.0,) * 3, (1.0,) * 3)
    clearance_m: float = 0.01
    open: Mapping[str, str] = field(default_factory=dict)
    tool_steps: Mapping[str, tuple[float, float]] = field(default_factory=dict)
    singularity_limits: Mapping[str, float] = field(default_factory=dict)

    @property
    def commanded(self) -> list[DraftJoint]:
        """In wire order: part by part."""
        return [one for part in self.parts for one in part.joints]

    @property
    def passive(self) -> list[DraftJoint]:
        """The joints that are measured only."""
        return [one for one in self.joints if not one.commanded]

    def role(self, joint: DraftJoint) -> str:
        """The role of a joint in robot.yaml."""
        owner = [part.role for part in self.parts if joint in part.joints]
        return owner[0] if owner else "gripper" if grips(joint) else "arm"

    def document(self) -> dict[str, Any]:
        """All of robot.yaml."""
        passive = [self._joint(one) for one in self.passive]
        simulator = {
            "base_body": self.base_body,
            "joints": {one.name: list(one.model_joints) for one in self.joints},
            "frames": dict(self.frames),
        }
        safety = self._safety()
        return {
            "id": self.id,
            "description": f"{self.id}.urdf",
            "capsules": "capsules.yaml",
            "control_period_ms": self.period_ms,
            "base_frame": self.base_frame,
            "to_confirm": {**dict(self._open()), **self.open},
            "joints": [self._joint(one) for one in self.commanded],
            **({"passive_joints": passive} if passive else {}),
            "parts": [self._part(one) for one in self.parts],
            "end_effectors": self._end_effectors(),
            "home": {"positions": dict(self.home), "source": self.home_source},
            **({"simulator": simulator} if self.base_body else {}),
            **({"no_collision_geometry": dict(self.bare)} if self.bare else {}),
            "safety": safety,
        }

    def _open(self) -> Iterator[tuple[str, str]]:
        for joint in self.joints:
            key = "passive_joints" if not joint.commanded else "joints"
            for what, why in joint.open.items():
                yield f"{key}.{joint.name}.{_KEYS[what][joint.unit]}", why
        yield "home", f"{self.home_source}: fairlead home moves the robot there"
        for tool in dict.fromkeys(self._effector(part) for part in self.parts):
            yield f"end_effectors.{tool}.tool_frame", "chosen by the links' names and place"
        for joint in self.joints:
            yield f"safety.hardware.measured.{joint.name}", _MEASURE
        for part in self.parts:
            yield f"safety.hardware.parts.{part.name}", _MEASURE
        yield "safety.hardware.self_collision", "own choice: more than encoders and capsules err"
        yield "safety.hardware.workspace", "all that the tools reach: set your site's"
        yield "safety.hardware.protocol.stop_ramp_ms", _MEASURE
        yield "safety.hardware.protocol.step_deadline_us", "ten times a gate step on your machine"

    def _joint(self, joint: DraftJoint) -> dict[str, Any]:
        bounds = {} if joint.lower is None else {"lower": joint.lower, "upper": joint.upper}
        numbers = bounds | {
            "velocity": joint.velocity, "acceleration": joint.acceleration, "effort": joint.effort,
        }  # fmt: skip
        assumed = f"; assumed: {', '.join(joint.open)}" if joint.open else ""
        return {
            "name": joint.name, "role": self.role(joint), "type": joint.type,
            **{_KEYS[what][joint.unit]: value for what, value in numbers.items()},
            "source": f"{joint.source}{assumed}",
        }  # fmt: skip

    def _part(self, part: DraftPart) -> dict[str, Any]:
        modes = ["gripper_position"] if part.opens else ["joint_position"]
        return {
            "name": part.name, "joints": [one.name for one in part.joints], "simulator_part": "",
            "hold": "keep_command" if part.opens else "keep_position",
            "modes": [
                *modes,
                *(["joint_velocity"] if part.role == "arm" else []),
                *(["cartesian_delta"] if part.moves_tool else []),
            ],
            "end_effector": self._effector(part),
        }  # fmt: skip

    def _effector(self, part: DraftPart) -> str:
        arms = [one for one in self.parts if one.tool == part.tool]
        return f"tool_of_{arms[0].name}" if arms[0].role == "arm" else arms[0].name

    def _end_effectors(self) -> list[dict[str, Any]]:
        found: dict[str, dict[str, Any]] = {}
        for part in self.parts:
            name = self._effector(part)
            entry = found.setdefault(
                name, {"name": name, "tool_frame": part.tool, "actuated": False}
            )
            if part.role == "gripper" and len(part.joints) == 1:
                entry |= {"gripper_joint": part.joints[0].name, "actuated": True}
        return list(found.values())

    def _safety(self) -> dict[str, Any]:
        shared = {
            "tighter_joints": self._tighter(),
            "measured": {one.name: self._measured(one) for one in self.joints},
            "parts": {part.name: self._limits(part) for part in self.parts},
            "self_collision": {"clearance_m": self.clearance_m, "source": "own choice"},
            "workspace": self._workspace(),
            "protocol": {**_PROTOCOL, "stop_ramp_ms": self._ramp_ms()},
        }
        return {
            "sim": {"lockstep_allowed": True, **shared},
            "hardware": {"lockstep_allowed": False, **shared},
        }

    def _ramp_ms(self) -> int:
        """A stop lets a gripper finish its stroke."""
        slowest = max((one.lag_s for one in self.joints), default=0.0)
        hands = [part.joints[0] for part in self.parts if part.opens]
        stroke_s = max((one.span / (TRAVEL_SHARE * self._speed(one)) for one in hands), default=0.0)
        return min(60000, max(1500, round(1000.0 * (0.5 + stroke_s + 6.0 * slowest))))

    def _speed(self, joint: DraftJoint) -> float:
        """As fast as its servo follows closely enough: else chunks are refused at their seams."""
        allowed = [joint.velocity, self._across(joint)]
        allowed += [_rounded(_LAG[joint.unit] / joint.lag_s)] if joint.lag_s else []
        return min(allowed)

    def _across(self, joint: DraftJoint) -> float:
        """Just less than its whole range in a period."""
        if joint.lower is None:
            return math.inf
        return _rounded(0.999 * joint.span / (self.period_ms * 1e-3))

    def _acceleration(self, joint: DraftJoint) -> float:
        return _rounded(joint.acceleration * self._speed(joint) / joint.velocity)

    def _tighter(self) -> dict[str, Any]:
        return {
            one.name: {
                "velocity_per_s": self._speed(one),
                "acceleration_per_s2": self._acceleration(one),
                "source": f"the model's servo lags by {one.lag_s:.2g} s"
                if self._speed(one) < self._across(one)
                else "less than its whole range in a period",
            }
            for one in self.commanded
            if self._speed(one) < one.velocity
        }

    def _step(self, joint: DraftJoint) -> float:
        return min(_rounded(self._speed(joint) * self.period_ms * 1e-3), joint.span)

    def _lag(self, joint: DraftJoint) -> float:
        return self._speed(joint) * joint.lag_s + joint.sag

    def _measured(self, joint: DraftJoint) -> dict[str, Any]:
        step, span = self._step(joint), joint.span
        tolerance = self._lag(joint) + step + _SLACK[joint.unit]
        always = {
            "jump_per_tick": min(_rounded(4.0 * step), span),
            "standstill_per_s": min(_STILL[joint.unit], _rounded(self._speed(joint) / 2.0)),
            **({} if joint.lower is None else {"tolerance": min(_rounded(tolerance), span)}),
        }
        if not joint.commanded:
            return {**always, "source": "assumed"}
        return {
            **always,
            "contact_limit": _rounded(1.05 * joint.effort),
            "encoder_step": 1.0e-11,
            "dead_band_per_tick": _rounded(0.1 * step),
            "stop_lag_s": _rounded(joint.lag_s + self.period_ms * 1e-3),
            "source": "reckoned from the model's servo",
        }

    def _limits(self, part: DraftPart) -> dict[str, Any]:
        joints = part.joints
        if part.opens:
            told: dict[str, Any] = {
                "lower": joints[0].lower, "upper": joints[0].upper,
                "step_limit": joints[0].span, "slip_limit": None,
            }  # fmt: skip
            opening = {f"{key}_{joints[0].unit}": value for key, value in told.items()}
            opening["source"] = "the joint's range; steps admit a full stroke"
            return {"transitions": "any", "gripper_position": opening}
        tracking = [
            min(one.span, _rounded(3.0 * self._lag(one) + 2.0 * self._step(one) + _SLACK[one.unit]))
            for one in joints
        ]
        position = {
            "step_limits": [self._step(one) for one in joints], "tracking_limits": tracking,
            "source": "velocity x period; tracking: three times the lag of the model's servo",
        }  # fmt: skip
        if part.role != "arm":
            return {"transitions": "any", "joint_position": position}
        period_s = self.period_ms * 1e-3
        velocity = {
            "step_limits": [_rounded(self._acceleration(one) * period_s) for one in joints],
            "gain": [0.0, 1.0], "tracking_limits": [self._speed(one) for one in joints],
            "source": "acceleration x period; gain and tracking: wide, not measured",
        }  # fmt: skip
        told = {"joint_position": position, "joint_velocity": velocity}
        if not part.moves_tool:
            return {"transitions": "any", **told}
        delta = {**told, "cartesian_delta": self._delta(part)}
        limit = self.singularity_limits.get(part.name, 0.05)
        return {"singularity_limit": limit, "transitions": "any", **delta}

    def _delta(self, part: DraftPart) -> dict[str, Any]:
        linear, angular = (_rounded(one) for one in self.tool_steps.get(part.name, (0.01, 0.05)))
        return {
            "frames": [self.base_frame],
            "linear_limit_m": linear, "angular_limit_rad": angular,
            "linear_step_limit_m": linear, "angular_step_limit_rad": angular,
            "gain": [0.0, 1.2],
            "linear_tracking_m": 2.0 * linear, "angular_tracking_rad": 2.0 * angular,
            "source": "a quarter of what its joints can do; gain and tracking: wide, not measured",
        }  # fmt: skip

    def _workspace(self) -> dict[str, Any]:
        lower, upper = self.reach
        box = {"name": "reach", "kind": "keep_in", "lower_m": list(lower), "upper_m": list(upper)}
        return {"volumes": [box], "margin_m": 0.0, "source": "all that the tools reach"}


_KEYS = {
    "lower": {"rad": "lower_rad", "m": "lower_m"},
    "upper": {"rad": "upper_rad", "m": "upper_m"},
    "velocity": {"rad": "velocity_rad_s", "m": "velocity_m_s"},
    "acceleration": {"rad": "acceleration_rad_s2", "m": "acceleration_m_s2"},
    "effort": {"rad": "effort_nm", "m": "effort_n"},
}


def _rounded(value: float) -> float:
    return float(f"{value:.4g}")
