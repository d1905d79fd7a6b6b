"""The mobile pick-and-place task; importing it registers ``MobilePickPlace`` by name."""

import fairlead_hal_sim.quiet_robosuite  # noqa: F401  # before anything of robosuite
from fairlead_hal_sim.task.mobile_pick_place import MobilePickPlace
from fairlead_hal_sim.task.scene import Scene, sample_scene

__all__ = ["MobilePickPlace", "Scene", "sample_scene"]
