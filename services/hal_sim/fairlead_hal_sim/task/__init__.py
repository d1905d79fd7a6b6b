"""Tasks of fairlead's own; importing this registers ``MobilePickPlace`` and ``ReachCube``."""

import fairlead_hal_sim.quiet_robosuite  # noqa: F401  # before anything of robosuite
from fairlead_hal_sim.task.mobile_pick_place import MobilePickPlace
from fairlead_hal_sim.task.reach_cube import ReachCube
from fairlead_hal_sim.task.scene import Scene, sample_scene

__all__ = ["MobilePickPlace", "ReachCube", "Scene", "sample_scene"]
