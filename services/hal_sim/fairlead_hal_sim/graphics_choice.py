"""``MUJOCO_GL``, the operator's choice of a graphics library.

Read once, when this is imported: robosuite overwrites the variable later. Import it first.
"""

from __future__ import annotations

import ctypes.util
import os

VARIABLE = "MUJOCO_GL"
LIBRARIES = (("egl", "EGL"), ("osmesa", "OSMesa"))
"""Values that render without a screen, and the library each needs."""
ON_A_SCREEN = ("glfw", "glx")
OFF = ("disabled", "disable", "off", "false", "0")
CHOICE = os.environ.get(VARIABLE, "").strip().lower()
"""What the operator set; "" for nothing."""


def is_renderer(choice: str) -> bool:
    """Whether a value names something to render with."""
    return choice in ON_A_SCREEN or choice in dict(LIBRARIES)


def renderers() -> list[str]:
    """What to try, in this order: the operator's choice alone, else each library there is."""
    if CHOICE:
        return [CHOICE] if is_renderer(CHOICE) else []
    return [value for value, library in LIBRARIES if ctypes.util.find_library(library)]


def why_none() -> str:
    """Why nothing renders, and what would."""
    if CHOICE in OFF:
        return f"{VARIABLE}={CHOICE} switches rendering off"
    if CHOICE and not is_renderer(CHOICE):
        valid = ", ".join([value for value, _ in LIBRARIES] + [*ON_A_SCREEN, OFF[0]])
        return f"{VARIABLE}: expected a renderer, got {CHOICE!r} (valid: {valid})"
    return "no rendering library works; install libegl1 or libosmesa6"
