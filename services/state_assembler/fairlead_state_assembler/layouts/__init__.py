"""Every layout, one file each. Importing this package registers them all."""

from fairlead_state_assembler.layouts import human300_16d, mobile_pick_30d

__all__ = ["human300_16d", "mobile_pick_30d"]
