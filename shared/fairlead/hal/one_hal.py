"""One HAL per robot and per state folder: a second one is told who is first."""

from __future__ import annotations

import fcntl
from pathlib import Path
from typing import TextIO

from fairlead.errors import ConfigError, NoAnswerError
from fairlead.keys import Keys
from fairlead.messages import HalStatus, StatusQuery, decode
from fairlead.wire.bus import Bus

ANSWER_WAIT_S = 0.5


def lock_state_folder(service: str, folder: Path) -> TextIO:
    """Hold a folder for this process; the lock ends with the process, however it ends.

    Raises:
        ConfigError: if another process holds it.
    """
    path = folder / "hal.lock"
    file = path.open("a")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        file.close()
        raise ConfigError(
            f"{service}: another HAL still uses {folder}; see: fairlead ps, then: fairlead down"
        ) from None
    return file


def refuse_second_hal(service: str, bus: Bus, keys: Keys) -> None:
    """Look for a HAL of the same robot that this session can reach.

    Raises:
        ConfigError: naming the session of the HAL that answered.
    """
    try:
        reply = bus.query(keys.hal_status, StatusQuery(), ANSWER_WAIT_S)
    except NoAnswerError:
        return
    other = decode(HalStatus, reply)
    raise ConfigError(
        f"{service}: robot {keys.robot} already has a HAL (session {other.session:x}, "
        f"tick {other.tick}); see: fairlead ps, then: fairlead down"
    )
