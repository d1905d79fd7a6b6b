"""One number of the compiled gate file, with its unit and where it comes from."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class EffectiveLimit:
    """One enforced number.

    Attributes:
        where: ``joint NAME``, ``part NAME``, ``part NAME MODE``, ``self-collision``, ``base``,
            ``volume NAME``, ``zone NAME`` or ``protocol``.
        name: the limit, as in the compiled gate file.
        value: in ``unit``; a tuple where there is one number per joint of the part, axis or
            corner; words where the limit is a choice.
        source: where the number comes from.
    """

    where: str
    name: str
    value: float | tuple[float, ...] | str
    unit: str
    source: str
