"""The HAL of a robot without physics, ``run: hal_kinematic`` in a deployment file.

Nothing in here is for others to import; robots are connected through `fairlead.hal`.
"""

__all__: list[str] = []
