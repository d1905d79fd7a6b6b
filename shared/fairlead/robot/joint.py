"""Joints of a robot as its manifest declares them: SI limits, units in the names."""

from __future__ import annotations

import math
from typing import Literal

from pydantic import BaseModel, ConfigDict, model_validator

_MOST = 1e6  # as the gate takes for a command; a limit beyond it is none
JointRole = Literal["base", "arm", "gripper", "torso", "hand", "head"]
JointType = Literal["revolute", "prismatic", "continuous"]


class Joint(BaseModel):
    """One joint, commanded or passive, with every limit it is held to.

    Turning joints give their limits in rad, sliding ones in m. Two kinds have no position limit
    of their own: a joint declared ``bounded_by: zones`` (a mobile base), and a joint of type
    ``continuous``, which turns without end and is measured and told over its turns. ``effort``
    and the rest say where their numbers come from in ``source``.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    role: JointRole
    type: JointType
    bounded_by: Literal["limits", "zones"] = "limits"
    lower_rad: float | None = None
    upper_rad: float | None = None
    velocity_rad_s: float | None = None
    acceleration_rad_s2: float | None = None
    effort_nm: float | None = None
    lower_m: float | None = None
    upper_m: float | None = None
    velocity_m_s: float | None = None
    acceleration_m_s2: float | None = None
    effort_n: float | None = None
    source: str

    @model_validator(mode="after")
    def _has_exactly_its_limits(self) -> Joint:
        if not self.source.strip():
            raise ValueError(f"joint {self.name!r}: source: expected words, got {self.source!r}")
        if self.bounded_by == "zones" and self.role != "base":
            raise ValueError(f"joint {self.name!r}: only joints of role base are bounded by zones")
        if self.type == "continuous" and self.role == "base" and self.bounded_by != "zones":
            raise ValueError(
                f"joint {self.name!r}: a base's continuous joint has no position limits, so it "
                "must be bounded by zones"
            )
        required, forbidden = self._limit_fields()
        missing = [name for name in required if getattr(self, name) is None]
        if missing:
            raise ValueError(f"joint {self.name!r} ({self.type}): missing {', '.join(missing)}")
        extra = [name for name in forbidden if getattr(self, name) is not None]
        if extra:
            raise ValueError(
                f"joint {self.name!r} ({self.type}, bounded by {self.bounded_by}): "
                f"{', '.join(extra)} does not apply (valid: {', '.join(required)})"
            )
        for name in required:
            if not math.isfinite(getattr(self, name)):
                raise ValueError(f"joint {self.name!r}: {name} is not finite")
            if abs(getattr(self, name)) > _MOST:
                raise ValueError(
                    f"joint {self.name!r}: expected {name} up to {_MOST:g}, got "
                    f"{getattr(self, name)}"
                )
        for name in required[-3:]:
            if getattr(self, name) <= 0.0:
                raise ValueError(
                    f"joint {self.name!r}: expected {name} above 0, got {getattr(self, name)}"
                )
        if self.has_bounds and self.lower >= self.upper:
            raise ValueError(
                f"joint {self.name!r}: inverted limits, lower {self.lower} is not below "
                f"upper {self.upper}"
            )
        return self

    def _limit_fields(self) -> tuple[list[str], list[str]]:
        """Names of the fields this joint must have, and of those it must not."""
        turning = ["lower_rad", "upper_rad", "velocity_rad_s", "acceleration_rad_s2", "effort_nm"]
        sliding = ["lower_m", "upper_m", "velocity_m_s", "acceleration_m_s2", "effort_n"]
        own, other = (sliding, turning) if self.type == "prismatic" else (turning, sliding)
        if self.has_bounds:
            return own, other
        return own[2:], own[:2] + other

    @property
    def has_bounds(self) -> bool:
        """False for joints that have no position limit by declaration."""
        return self.bounded_by == "limits" and self.type != "continuous"

    @property
    def unit(self) -> str:
        """``m`` or ``rad``."""
        return "m" if self.type == "prismatic" else "rad"

    @property
    def lower(self) -> float:
        """Lower position limit [rad or m]; only where `has_bounds`."""
        return self._limit("lower_m", "lower_rad")

    @property
    def upper(self) -> float:
        """Upper position limit [rad or m]; only where `has_bounds`."""
        return self._limit("upper_m", "upper_rad")

    @property
    def velocity_limit(self) -> float:
        """Largest speed [rad/s or m/s]."""
        return self._limit("velocity_m_s", "velocity_rad_s")

    @property
    def acceleration_limit(self) -> float:
        """Largest acceleration [rad/s2 or m/s2]."""
        return self._limit("acceleration_m_s2", "acceleration_rad_s2")

    @property
    def effort_limit(self) -> float:
        """Largest effort [N m or N]."""
        return self._limit("effort_n", "effort_nm")

    def _limit(self, sliding: str, turning: str) -> float:
        value = getattr(self, sliding if self.type == "prismatic" else turning)
        if value is None:
            raise ValueError(
                f"joint {self.name!r} has no position limit: it turns on, or zones bound it"
            )
        return float(value)
