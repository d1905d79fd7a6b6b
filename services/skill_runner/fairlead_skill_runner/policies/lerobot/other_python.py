"""The process of an interpreter that has LeRobot, and what it is asked."""

from __future__ import annotations

import os
import socket
import subprocess
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError, PolicyError
from fairlead_skill_runner.policies.lerobot import lerobot_side

WHO = "lerobot policy"
_END_TIMEOUT_S = 2.0


class OtherPython:
    """`lerobot_side` in an environment that never meets ours; it ends with the thread that made it.

    Raises:
        ConfigError: there is no such program.
    """

    def __init__(self, python: Path) -> None:
        self._python = python
        ours, theirs = socket.socketpair()
        with ours, theirs:
            words = [str(theirs.fileno()), str(os.getpid())]
            try:
                self._process = subprocess.Popen(
                    # -E: PYTHONPATH and the like are ours
                    [python, "-E", lerobot_side.__file__, *words],
                    pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL, stdout=2,
                    env={"HF_HUB_OFFLINE": "1"} | os.environ,
                )  # fmt: skip
            except OSError as error:
                raise ConfigError(
                    f"{WHO}: python: expected an interpreter that has lerobot, got {python}: "
                    f"{error.strerror}"
                ) from None
            self._pipe = ours.makefile("rwb")

    def load(self, checkpoint: Path, device: str | None, threads: int, rtc: bool) -> dict[str, Any]:
        """What the checkpoint says of itself; see `lerobot_side.Loaded.told`.

        Raises:
            PolicyError: it cannot be loaded there.
        """
        asked = {"load": str(checkpoint), "device": device, "threads": threads, "rtc": rtc}
        return self._ask("loading", asked)[0]

    def reset(self, seed: int) -> None:
        """A new episode, whose draws begin with the seed.

        Raises:
            PolicyError: as `load`.
        """
        self._ask("reset", {"seed": seed})

    def infer(self, prompt: str, arrays: Mapping[str, npt.NDArray[Any]]) -> npt.NDArray[np.float32]:
        """A chunk; the arrays are float32, or pictures in uint8 with the colours last.

        One may be ``action``, rows ``[n, dim]`` of earlier chunks that act meanwhile.

        Raises:
            PolicyError: the policy fails there.
        """
        kinds = [(name, str(one.dtype), one.shape) for name, one in arrays.items()]
        buffers = [one.tobytes() for one in arrays.values()]
        told, found = self._ask("inference", {"prompt": prompt, "arrays": kinds}, *buffers)
        return np.frombuffer(found[0], "<f4").reshape(told["shape"])

    def close(self) -> None:
        """End the process."""
        with suppress(OSError):
            self._pipe.close()
        self._ended()

    def _ask(
        self, what: str, asked: dict[str, Any], *buffers: bytes
    ) -> tuple[dict[str, Any], list[bytes]]:
        try:
            lerobot_side.send(self._pipe, asked, *buffers)
            answer = lerobot_side.receive(self._pipe)
        except OSError:
            answer = None
        except (ValueError, KeyError, TypeError) as error:
            raise PolicyError(f"{WHO}: {what}: {self._python} said no message: {error}") from None
        if answer is None:
            ended = f"{self._python} ended with status {self._ended()}"
            raise PolicyError(f"{WHO}: {what}: {ended}; it said why above")
        if "raised" in answer[0]:
            raise PolicyError(f"{WHO}: {what} failed: {answer[0]['raised']}")
        return answer

    def _ended(self) -> int:
        try:
            return self._process.wait(_END_TIMEOUT_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            return self._process.wait()
