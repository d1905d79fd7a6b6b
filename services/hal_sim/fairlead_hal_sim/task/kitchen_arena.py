"""The room: floor, two walls, a counter and an open cabinet (``assets/kitchen.xml``)."""

from __future__ import annotations

from pathlib import Path

from robosuite.models.arenas import Arena
from robosuite.models.objects import MujocoXMLObject

ASSETS = Path(__file__).parent / "assets"


class KitchenArena(Arena):  # type: ignore[misc]  # robosuite ships no types
    """Static scenery; counter and cabinet are mocap bodies placed at every reset."""

    def __init__(self) -> None:
        super().__init__(str(ASSETS / "kitchen.xml"))


class Can(MujocoXMLObject):  # type: ignore[misc]  # robosuite ships no types
    """A 60 mm drinks can on a free joint; its frame is its centre, z along its axis."""

    def __init__(self, name: str) -> None:
        super().__init__(
            str(ASSETS / "can.xml"),
            name=name,
            joints=[{"type": "free", "damping": "0.0005"}],
            obj_type="all",
            duplicate_collision_geoms=False,
        )
