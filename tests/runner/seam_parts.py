"""Rows of one part, as tests of seams have them."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from fairlead.messages import ActionPart, pack_floats
from fairlead.modes import ControlMode

BLEND = 3


def part(mode: ControlMode, values: npt.ArrayLike, index: int = 0) -> ActionPart:
    block = pack_floats(np.asarray(values, dtype=np.float64))
    return ActionPart(part=index, mode=mode, frame_id="", values=block, active=(0, 1))
