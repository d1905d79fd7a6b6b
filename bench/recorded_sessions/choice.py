"""Which of many sessions are kept: all that is shown anywhere, in as few bytes as it takes."""

from __future__ import annotations

import random
from collections.abc import Sequence

from bench.recorded_sessions.session import Session


def choose(
    sessions: Sequence[Session], always: Sequence[Session], most_bytes: int
) -> list[Session]:
    """``always``, then what shows most that is new for its bytes, then others by lot.

    Nothing is taken that does not fit into ``most_bytes``; the same sessions give the same choice.
    """
    kept: list[Session] = []
    seen: set[str] = set()
    left = sorted(sessions, key=lambda session: session.name)
    used = 0

    def take(session: Session) -> None:
        nonlocal used
        kept.append(session)
        seen.update(session.shows)
        used += session.size

    for session in always:
        take(session)
    while True:
        left = [
            session for session in left if session not in kept and used + session.size <= most_bytes
        ]
        worth = {
            index: len(session.shows - seen) / session.size for index, session in enumerate(left)
        }
        if not worth or max(worth.values()) == 0.0:
            break
        take(left[max(worth, key=lambda index: worth[index])])
    random.Random(len(left)).shuffle(left)
    for session in left:
        if used + session.size <= most_bytes:
            take(session)
    return kept
