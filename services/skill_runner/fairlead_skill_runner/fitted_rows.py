"""Where a slot asks for it: numbers of the policy clipped, or decided by a threshold.

As the environment did with which the policy was trained; slots that ask for nothing keep every bit.
What is not finite is kept as well: no clip and no threshold makes a command of it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from fairlead.policy import Actions
from fairlead.skill.routes import Route, SlotFit


def fitted(routes: Sequence[Route], rows: Actions) -> Actions:
    """The policy's rows as they go on, float32 ``[H, dim]``: the same array if no slot asks."""
    fits = [fit for route in routes for fit in route.fits]
    if not fits:
        return rows
    made = rows.copy()
    for fit in fits:
        block = rows[:, fit.sources]
        if fit.threshold is not None:
            changed = np.where(block >= fit.threshold, np.float32(1), np.float32(-1))
        else:
            assert fit.clip is not None
            changed = np.clip(block, *fit.clip)
        made[:, fit.sources] = np.where(np.isfinite(block), changed, block)
    return made


@dataclass
class _Count:
    numbers: int = 0
    changed: int = 0
    farthest: float = 0.0


@dataclass
class FitCounts:
    """How many numbers of one goal were not sent as the policy gave them."""

    routes: Sequence[Route]
    _counts: dict[SlotFit, _Count] = field(default_factory=dict)

    def add(self, raw: Actions, sent: Actions) -> None:
        """Count one answer."""
        for fit in (fit for route in self.routes for fit in route.fits):
            count = self._counts.setdefault(fit, _Count())
            before, after = raw[:, fit.sources], sent[:, fit.sources]
            differs = before != after
            count.numbers += before.size
            count.changed += int(differs.sum())
            beyond = np.abs(before[differs])
            if beyond.size and beyond.max() > abs(count.farthest):
                count.farthest = float(before[differs][np.argmax(beyond)])

    def words(self) -> str:
        """For the goal's result: slot by slot, what was changed; "" if nothing was."""
        told = []
        for fit, count in self._counts.items():
            if count.changed:
                how = "clipped" if fit.clip is not None else "decided by threshold"
                farthest = f", farthest {count.farthest:g}" if fit.clip is not None else ""
                told.append(f"{fit.slot}: {count.changed} of {count.numbers} {how}{farthest}")
        return "; ".join(told)
