"""The HAL of plain MuJoCo models, ``run: hal_mujoco`` in a deployment file.

Nothing in here is for others to import; robots are connected through `fairlead.hal`.
"""

__all__: list[str] = []
