"""What a state layout is: the order of the numbers in the vector that a policy was trained on.

A layout is one `Layout` object behind an entry point in ``fairlead.layouts``. Its function reads
the joints and transforms of one tick by the names of a skill's bindings, through `LayoutInputs`;
it knows no robot, no transport and no clock.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, Protocol

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.plugins import LAYOUTS
from fairlead.skill.bindings import PoseBinding, QuaternionSign, StateContractBindings

__all__ = ["Layout", "LayoutField", "LayoutInputs", "load_layout"]

ParentBinding = Literal["base_frame", "world_frame"]
FieldKind = Literal[
    "position",
    "quaternion",
    "axis-angle",
    "gripper",
    "gripper velocities",
    "joints",
    "joint velocities",
    "ratios",
]

_WIDTHS: dict[FieldKind, int] = {
    "position": 3,
    "quaternion": 4,
    "axis-angle": 3,
    "gripper": 2,
    "gripper velocities": 2,
    "joints": 7,
    "joint velocities": 7,
    "ratios": 7,
}


class LayoutInputs(Protocol):
    """Joints and transforms of one tick, read by the names of a skill's bindings.

    Every method raises `LayoutError` for a binding that names nothing, and for a frame or joint
    that is missing or too old. Order and sign of quaternions are those bound.
    """

    def position3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """Where ``child`` is in ``parent``: shape ``[3]`` [m]."""

    def quaternion4(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """How ``child`` is turned in ``parent``: shape ``[4]``, unit quaternion."""

    def driven_quaternion4(self, child: PoseBinding, sign: QuaternionSign) -> FloatArray:
        """How ``child`` is turned in ``world_frame``: shape ``[4]``, unit quaternion.

        Its sign is the product's of odom in the world (w >= 0), the base in odom (w >= 0) and
        ``child`` in the base: it stays as the base turns, as a simulator's does.

        Args:
            sign: of ``child`` in the base.
        """

    def axis_angle3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """How ``child`` is turned in ``parent``: shape ``[3]``, unit axis times angle [rad]."""

    def pose7(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """Position [m] and unit quaternion of one frame: shape ``[7]``."""

    def planar3(self, parent: ParentBinding, child: PoseBinding) -> FloatArray:
        """x, y [m] and yaw about z [rad], in (-pi, pi]: shape ``[3]``."""

    def joints(self) -> FloatArray:
        """Positions of the bound joints in their order, else of the layout's own [rad or m]."""

    def joint_velocities(self) -> FloatArray:
        """Velocities of the same joints [rad/s or m/s]."""

    def gripper2(self) -> FloatArray:
        """Both fingers [m]: two joints as measured, or one joint v as ``[v, -v]``."""

    def gripper_velocities2(self) -> FloatArray:
        """Velocities of the same fingers [m/s]."""

    def in_world(self, frame: str) -> LayoutInputs:
        """The same with ``world_frame`` bound to ``frame``."""


@dataclass(frozen=True)
class LayoutField:
    """One field of a layout that a simulator knows the truth of.

    Attributes:
        name: what it is: ``base_to_eef position``.
        first: index of its first number in the vector.
        bindings: the bindings it is made from.
    """

    name: str
    kind: FieldKind
    first: int
    bindings: tuple[str, ...]

    @property
    def width(self) -> int:
        """How many numbers of the vector this field has."""
        return _WIDTHS[self.kind]

    @property
    def is_rotation(self) -> bool:
        """Whether it is compared as an angle."""
        return self.kind in ("quaternion", "axis-angle")


@dataclass(frozen=True)
class Layout:
    """One layout.

    Attributes:
        content: what is in the vector, in a line for people.
        dim: numbers in the vector; None for a layout that nothing assembles.
        assemble: the vector of one tick, float64, shape ``[dim]``; raises `LayoutError`.
        example: bindings to start from.
        required: binding fields it cannot do without.
        optional: those it reads beside them and its joints; all others are refused.
        joint_names: joints of a joint-space layout unless the bindings name others.
        gripper_qpos_joints: likewise its fingers.
        fields: what ``fairlead layout verify`` compares with the simulator.
    """

    content: str
    dim: int | None
    assemble: Callable[[LayoutInputs], FloatArray] | None
    example: StateContractBindings = field(default_factory=StateContractBindings)
    required: tuple[str, ...] = ()
    optional: tuple[str, ...] = ()
    joint_names: tuple[str, ...] = ()
    gripper_qpos_joints: tuple[str, ...] = ()
    fields: tuple[LayoutField, ...] = ()

    def bound_joints(self, bindings: StateContractBindings) -> tuple[str, ...]:
        """The joints a joint-space layout reads, in its order; fingers are not among them."""
        return bindings.joint_names or self.joint_names

    def bound_gripper(self, bindings: StateContractBindings) -> tuple[str, ...]:
        """The joints it reads its fingers from."""
        return bindings.gripper_qpos_joints or self.gripper_qpos_joints

    def missing(self, bindings: StateContractBindings) -> list[str]:
        """Every field it needs that ``bindings`` leaves empty, in its order."""
        return [name for name in self.required if not getattr(bindings, name)]

    @property
    def read(self) -> tuple[str, ...]:
        """Every binding field it looks at."""
        joints = ("joint_names", "gripper_qpos_joints")
        own = (name for name in joints if getattr(self, name) and name not in self.required)
        return (*self.required, *self.optional, *own)


def load_layout(name: str, who: str = "") -> Layout:
    """The layout of a name, imported from the package that registers it.

    Args:
        who: who asks for it, as the error begins.

    Raises:
        ConfigError: nobody registers it, with the names there are; or what is behind it is no
            layout, naming the package.
    """
    if name in _loaded:
        return _loaded[name]
    plugin = LAYOUTS.find(name, who)
    found = plugin.load()
    if not isinstance(found, Layout):
        raise plugin.refuse("a fairlead.layout.Layout", found)
    if found.dim is not None and (type(found.dim) is not int or found.dim < 1):
        raise ConfigError(expected(f"{plugin.who}: dim", "at least 1, or None", repr(found.dim)))
    if (found.dim is None) != (found.assemble is None):
        raise ConfigError(f"{plugin.who}: expected dim and assemble, or neither of them")
    fields = tuple(StateContractBindings.model_fields)
    if unknown := [one for one in (*found.required, *found.optional) if one not in fields]:
        what = f"{plugin.who}: required and optional"
        raise ConfigError(expected(what, "binding fields", ", ".join(unknown), fields))
    return _loaded.setdefault(name, found)


_loaded: dict[str, Layout] = {}  # asked for in every tick
