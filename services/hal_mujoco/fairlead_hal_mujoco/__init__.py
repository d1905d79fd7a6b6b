"""The HAL of plain MuJoCo models, ``run: hal_mujoco`` in a deployment file.

Robots are connected through `fairlead.hal`; what is public here is asked by tools.
"""

from fairlead_hal_mujoco.refusals import model_problems

__all__ = ["model_problems"]
