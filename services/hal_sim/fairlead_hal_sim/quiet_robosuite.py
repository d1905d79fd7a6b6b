"""Import robosuite without its start-up notes, and keep its loggers at ERROR.

Import this module before any module of robosuite: its notes about optional packages are
printed while it is being imported, and it insists on EGL, so that on a machine without a
complete EGL it could not be imported at all. Only a process that was told how to render
(MUJOCO_GL, and by a value that MuJoCo takes) loads a graphics library.

Raises on import:
    ConfigError: robosuite is not installed (a wheel of fairlead does without), and the command
        that installs it.
"""

from __future__ import annotations

import logging
import os
import sys

from fairlead.errors import ConfigError
from fairlead.paths import runtime_lock
from fairlead_hal_sim.graphics_choice import CHOICE, VARIABLE, is_renderer

_GRAPHICS = os.environ.get(VARIABLE)
if not is_renderer(CHOICE):
    os.environ[VARIABLE] = "disabled"
import mujoco  # noqa: E402, F401  # chooses its graphics library now, before robosuite does

logging.disable(logging.WARNING)
try:
    import robosuite
    from robosuite.utils.log_utils import ROBOSUITE_DEFAULT_LOGGER
except ModuleNotFoundError as error:
    raise ConfigError(
        f"hal_sim: the Python package {error.name} is not installed; install the locked set, which "
        f"has it: {sys.executable} -m pip install --no-deps -r {runtime_lock()}"
    ) from None
finally:
    logging.disable(logging.NOTSET)
    os.environ.pop(VARIABLE, None)  # robosuite's choice, not one for child processes
    if _GRAPHICS is not None:
        os.environ[VARIABLE] = _GRAPHICS

ROBOSUITE_DEFAULT_LOGGER.setLevel(logging.ERROR)

__all__ = ["robosuite"]
