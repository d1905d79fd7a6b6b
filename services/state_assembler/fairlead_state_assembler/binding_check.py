"""Read one binding that a layout cannot do without."""

from __future__ import annotations

from fairlead.bindings import StateContractBindings
from fairlead.errors import LayoutError


def bound(layout: str, bindings: StateContractBindings, name: str) -> str:
    """The frame bound to ``name``.

    Manifests without it are refused when they are loaded; this is for direct callers.

    Raises:
        LayoutError: ``missing_frame``, naming the layout and the binding.
    """
    frame = getattr(bindings, name)
    if not isinstance(frame, str) or not frame:
        raise LayoutError(
            f"layout {layout}: the bindings name no {name}", kind="missing_frame", name=name
        )
    return frame
