"""The HAL of SO-101 arms, ``run: hal_so101`` in a deployment file; calibration; leader arms.

What the tools may import is below; robots are connected through `fairlead.hal`.
"""

from fairlead_hal_so101.guided_calibration import calibrate
from fairlead_hal_so101.limp_arm import LimpArm
from fairlead_hal_so101.servo_bus import LostAnswerError

__all__ = ["LimpArm", "LostAnswerError", "calibrate"]
