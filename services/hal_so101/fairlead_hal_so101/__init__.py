"""The HAL of SO-101 arms, ``run: hal_so101`` in a deployment file, and its calibration.

What the tools may import is below; robots are connected through `fairlead.hal`.
"""

from fairlead_hal_so101.guided_calibration import calibrate

__all__ = ["calibrate"]
