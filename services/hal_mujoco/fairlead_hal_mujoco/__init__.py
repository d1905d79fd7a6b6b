"""The HAL of plain MuJoCo models: a process, started by ``python -m fairlead_hal_mujoco``.

Nothing in here is for others to import; robots are connected through `fairlead.hal`.
"""

__all__: list[str] = []
