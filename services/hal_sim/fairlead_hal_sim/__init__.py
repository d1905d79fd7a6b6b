"""The HAL of robosuite simulators, ``run: hal_sim`` in a deployment file.

Nothing in here is for others to import; robots are connected through `fairlead.hal`.
"""

__all__: list[str] = []
