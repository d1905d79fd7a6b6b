"""The state vector a policy was trained on: a layout with its bindings, or joints side by side."""

from __future__ import annotations

from typing import Self

from pydantic import BaseModel, ConfigDict, field_validator, model_validator

from fairlead.errors import ConfigError
from fairlead.layout import Layout, load_layout
from fairlead.plugins import LAYOUTS
from fairlead.skill.bindings import StateContractBindings
from fairlead.skill.joint_field import JointField, joint_field_problems


class StateContract(BaseModel):
    """The state vector a policy was trained on: its size, and what each number is.

    Attributes:
        layout: what the numbers mean, for a vector with poses in it; or
        joints: for one of joints alone, what is side by side in it.
        bindings: which frames and joints of the robot fill a layout.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    layout: str | None = None
    dim: int
    bindings: StateContractBindings = StateContractBindings()
    joints: tuple[JointField, ...] = ()

    @field_validator("layout")
    @classmethod
    def _known_layout(cls, value: str | None) -> str | None:
        if value is not None:
            try:
                load_layout(value)
            except ConfigError as error:
                raise ValueError(str(error)) from None
        return value

    @property
    def layout_name(self) -> str:
        """What messages and errors call it."""
        return self.layout or "joints"

    @model_validator(mode="after")
    def _check_layout(self) -> Self:
        if self.layout is None or self.joints:
            problems = self._joint_space_problems()
        else:
            problems = self._layout_problems(self.layout)
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _joint_space_problems(self) -> list[str]:
        if not self.joints:
            return [f"expected layout or joints, got neither (layouts {LAYOUTS.choices()})"]
        given = {"layout": self.layout, "bindings": self.bindings.model_dump(exclude_defaults=True)}
        problems = [f"{name}: not allowed beside joints" for name, value in given.items() if value]
        return problems + joint_field_problems(self.dim, self.joints)

    def _layout_problems(self, name: str) -> list[str]:
        layout = load_layout(name)
        problems = []
        if layout.dim is not None and self.dim != layout.dim:
            problems.append(f"dim: expected {layout.dim} for layout {name}, got {self.dim}")
        missing = layout.missing(self.bindings)
        if missing:
            problems.append(f"bindings: layout {name} also needs {', '.join(missing)}")
        return problems + _unread(name, layout, self.bindings)


def _unread(name: str, layout: Layout, bindings: StateContractBindings) -> list[str]:
    """What is bound in vain: it would be a surprise if it were ignored."""
    problems = []
    wanted, named = len(layout.joint_names), len(bindings.joint_names)
    if named not in (0, wanted):
        problems.append(f"joint_names: expected {wanted} for layout {name}, got {named}")
    reads_gripper = layout.gripper_qpos_joints or "gripper_qpos_joints" in layout.required
    if bindings.gripper_qpos_joints and not reads_gripper:
        problems.append(f"gripper_qpos_joints: layout {name} reads none")
    problems += [
        f"quaternion_signs: layout {name} has no rotation of {frame}"
        for frame in bindings.quaternion_signs
        if frame not in layout.required
    ]
    return problems
