"""A robot and this process take turns: the robot's policy answers only when it may."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from multiprocessing.connection import Connection, Listener
from pathlib import Path

import yaml

from fairlead.paths import repo_root

POLICY = repo_root() / "bench" / "equipment" / "turn_policy.py"
LOOK_AGAIN_S = 0.1


class Turns:
    """Our end of the connection to a skill's policy.

    Args:
        folder: of skills (``FAIRLEAD_SKILLS``); a copy of ``skill`` is made there, under another
            name, with the same policy behind `turn_policy.TurnPolicy`.
    """

    def __init__(self, folder: Path, skill: str) -> None:
        self.skill = f"{skill}-in-turns"
        self._listener = Listener(str(folder / "turns.sock"), "AF_UNIX")
        self._policy: Connection | None = None
        self._write_skill(folder / self.skill, skill)

    def _write_skill(self, copy: Path, skill: str) -> None:
        text = (repo_root() / "rskills" / skill / "rskill.yaml").read_text(encoding="utf-8")
        manifest = yaml.safe_load(text)
        options = {"policy": manifest["policy"], "address": self._listener.address}
        manifest["id"] = self.skill
        manifest["policy"] = {
            "backend": "python",
            "options": {
                "file": POLICY.name, "class": "TurnPolicy", "options": options, "probe": False,
            },
        }  # fmt: skip
        copy.mkdir(parents=True)
        (copy / "rskill.yaml").write_text(yaml.safe_dump(manifest), encoding="utf-8")
        shutil.copy(POLICY, copy)

    def wait_asked(self, ended: Callable[[], bool]) -> bool:
        """Wait until the policy is asked for rows; False if the goal has ended instead."""
        if self._policy is None:
            self._policy = self._listener.accept()
        while not self._policy.poll(LOOK_AGAIN_S):
            if ended():
                return False
        self._policy.recv_bytes()
        return True

    def let_go(self) -> None:
        """It may answer now."""
        assert self._policy is not None, "it has been asked"
        self._policy.send_bytes(b"")

    def close(self) -> None:
        """The policy answers at once from now on."""
        if self._policy is not None:
            self._policy.close()
        self._listener.close()
