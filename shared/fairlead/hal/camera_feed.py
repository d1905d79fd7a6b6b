"""How the HAL host gets camera frames without rendering on its own thread."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from fairlead.messages import Image


class CameraFeed(Protocol):
    """Renders snapshots of the backend somewhere else (a process, a device)."""

    @property
    def failure(self) -> str:
        """Why there will be no more frames; "" while all is well."""

    def request(self, session: int, tick: int, cameras: Sequence[str], snapshot: bytes) -> bool:
        """Ask for frames of ``tick``. False if the feed is still busy and will not."""

    def take(self, timeout_s: float) -> Image | None:
        """The next finished frame; None if there is none in time, or no feed any more."""

    def close(self) -> None:
        """End the renderer; frames still under way are lost."""
