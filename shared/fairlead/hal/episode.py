"""The current episode of a simulator and the reset that is bringing up the next one."""

from __future__ import annotations

from fairlead.messages import ResetEpisode, ResetEpisodeReply


class Episode:
    """Which tick an episode began at, and whether its reset is still coming to rest.

    The tick that carries out a reset is held; the one after it is the episode's first.

    Attributes:
        first_tick: first tick measured in this episode.
        resetting: the request being carried out, None when there is none.
    """

    def __init__(self) -> None:
        self.first_tick = 1
        self.resetting: ResetEpisode | None = None
        self._held_ticks = 0

    def begin(self, request: ResetEpisode, tick: int) -> None:
        """The backend was reset in period ``tick``."""
        self.resetting = request
        self.first_tick = tick + 1
        self._held_ticks = 0

    @property
    def must_step(self) -> bool:
        """A reset steps at least one held tick, standing still or not."""
        return self.resetting is not None and self._held_ticks == 0

    def stepped(self) -> None:
        """One period was carried out."""
        if self.resetting is not None:
            self._held_ticks += 1

    def finish(self, tick: int) -> ResetEpisodeReply:
        """The robot stands still at ``tick``: the reset is over."""
        self.resetting = None
        return ResetEpisodeReply(
            tick=tick, episode_tick=self.first_tick, held_ticks=self._held_ticks
        )
