"""Whether this machine has a library that draws without a screen."""

from __future__ import annotations

import ctypes.util

from fairlead_hal_sim.graphics_choice import LIBRARIES

CAN_RENDER = any(ctypes.util.find_library(library) for _, library in LIBRARIES)
