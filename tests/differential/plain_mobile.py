"""Numbers of `panda_mobile` for chunks whose rows are always good."""

from __future__ import annotations

import numpy as np

COMPOSITE_PART, COMPOSITE = 3, 12
REST = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, -1.5, 0.0, 1.5, 0.0, 0.04, 0.02, -0.02, 0.1])
"""rad and m, inside all bounds."""
