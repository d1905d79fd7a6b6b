"""Transforms for a notebook: a table instead of a buffer."""

from collections.abc import Mapping

import pinocchio as pin

from fairlead.errors import LayoutError


class FixedTransforms:
    """Knows exactly the pairs it is given."""

    def __init__(self, poses: Mapping[tuple[str, str], pin.SE3]) -> None:
        self._poses = poses

    def pose(self, parent: str, child: str) -> pin.SE3:
        if (parent, child) not in self._poses:
            raise LayoutError("no such frame", kind="missing_frame", name=child, parent=parent)
        return self._poses[(parent, child)]
