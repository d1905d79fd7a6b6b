"""The HAL of robosuite simulators: a process, started by ``python -m fairlead_hal_sim``.

Nothing in here is for others to import; robots are connected through `fairlead.hal`.
"""

__all__: list[str] = []
