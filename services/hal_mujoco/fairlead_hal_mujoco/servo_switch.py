"""Position servos that can be sources of force for a while."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco


class ServoSwitch:
    """Turns ``<position>`` actuators into sources of force, and back.

    As a source of force an actuator's control is its force [N m or N]; the model's
    ``forcerange`` still bounds it. Everything else in the model stays: gravity compensation
    and damping of the joints act beside a commanded force.
    """

    def __init__(self, model: mujoco.MjModel) -> None:
        self._model = model
        self._gains = model.actuator_gainprm.copy()
        self._biases = model.actuator_biasprm.copy()
        self._limited = model.actuator_ctrllimited.copy()

    def to_force(self, servos: Sequence[int]) -> None:
        """Let the controls of these actuators be forces."""
        own = list(servos)
        self._model.actuator_gainprm[own, 0] = 1.0
        self._model.actuator_biasprm[own] = 0.0
        self._model.actuator_ctrllimited[own] = 0  # its range is one of positions

    def to_position(self, servos: Sequence[int]) -> None:
        """Let them be position servos again."""
        own = list(servos)
        self._model.actuator_gainprm[own] = self._gains[own]
        self._model.actuator_biasprm[own] = self._biases[own]
        self._model.actuator_ctrllimited[own] = self._limited[own]
