"""What one episode computed, as bytes, so that comparing is exact."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass
class EpisodeTrace:
    """One episode.

    observations: float64 layout vectors, one per policy call.
    pictures: one JSON object per policy call: by name, the hash of what the policy got.
    actions: float32 ``[H, dim]``, one per policy call.
    packed: float32 vectors given to ``env.step``, one per tick after the reset.
    qpos, qvel: float64 simulator state before each of those steps.
    held: whether any part held in that tick; empty where nobody asked.
    succeeded: the task's own check at the end.
    """

    observations: list[bytes] = field(default_factory=list)
    pictures: list[bytes] = field(default_factory=list)
    actions: list[bytes] = field(default_factory=list)
    packed: list[bytes] = field(default_factory=list)
    qpos: list[bytes] = field(default_factory=list)
    qvel: list[bytes] = field(default_factory=list)
    held: list[bool] = field(default_factory=list)
    succeeded: bool = False

    def until(self, tick: int) -> EpisodeTrace:
        """Vectors of the ticks before ``tick``, states before each and, if there, at ``tick``."""
        return EpisodeTrace(
            packed=self.packed[:tick], qpos=self.qpos[: tick + 1], qvel=self.qvel[: tick + 1]
        )
