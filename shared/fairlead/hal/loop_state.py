"""What the tick loop keeps from tick to tick: when the next is due, and the episode. Pure."""

from __future__ import annotations

from fairlead.messages import ResetEpisode, ResetEpisodeReply


class PeriodClock:
    """Ticks every ``period_ns``; a late tick moves all later ones (slips), never bursts.

    Attributes:
        overruns: ticks that began later than they were due because work took too long.
    """

    def __init__(self, period_ns: int, now_ns: int) -> None:
        self._period_ns = period_ns
        self._due_ns = now_ns
        self.overruns = 0

    def start_tick(self, now_ns: int) -> int:
        """Nanoseconds still to wait before the next tick may begin (0: begin now)."""
        self._due_ns += self._period_ns
        if now_ns > self._due_ns:
            self._due_ns = now_ns
            self.overruns += 1
        return self._due_ns - now_ns

    def restart(self, now_ns: int) -> None:
        """After a deliberate break (an episode reset) the next tick is a period from now."""
        self._due_ns = now_ns


class Episode:
    """Which tick an episode began at, and how far its reset has come.

    A reset is announced, begun and finished. The tick that carries it out is held; the one after
    it is the episode's first.

    Attributes:
        first_tick: first tick measured in this episode.
        resetting: the request being carried out, None when there is none.
        announced_ns: when `resetting` was told to the gate, if the backend is not reset yet.
    """

    def __init__(self) -> None:
        self.first_tick = 1
        self.resetting: ResetEpisode | None = None
        self.announced_ns: int | None = None
        self._held_ticks = 0

    def announce(self, request: ResetEpisode, now_ns: int) -> None:
        """From now on the HAL says that it resets; the old episode stands until `begin`."""
        self.resetting, self.announced_ns = request, now_ns

    def abandon(self) -> None:
        """It is not reset after all: the old episode goes on."""
        self.resetting = self.announced_ns = None

    def begin(self, tick: int) -> None:
        """The backend was reset in period ``tick``."""
        self.announced_ns = None
        self.first_tick = tick + 1
        self._held_ticks = 0

    @property
    def must_step(self) -> bool:
        """A reset steps at least one held tick, standing still or not."""
        return self.comes_to_rest and self._held_ticks == 0

    @property
    def comes_to_rest(self) -> bool:
        """Whether the backend was reset, and is stepped until it stands still."""
        return self.resetting is not None and self.announced_ns is None

    def stepped(self) -> None:
        """One period was carried out."""
        if self.comes_to_rest:
            self._held_ticks += 1

    def finish(self, tick: int) -> ResetEpisodeReply:
        """The robot stands still at ``tick``: the reset is over."""
        self.resetting = None
        return ResetEpisodeReply(
            tick=tick, episode_tick=self.first_tick, held_ticks=self._held_ticks
        )
