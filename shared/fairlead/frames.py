"""Names of the frames that every deployment has, whatever its robot."""

from __future__ import annotations

MAP = "map"
"""The world: a building, or a simulator's scene."""

ODOM = "odom"
"""Where the base's own measurements start from; a localiser says where it is in `MAP`."""
