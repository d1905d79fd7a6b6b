"""The skills a runner offers, each as its folder says when a goal asks for it."""

from __future__ import annotations

import asyncio
import logging
import os
import socket
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

from fairlead.errors import ConfigError, RefusedError, expected
from fairlead.paths import rskill_dir
from fairlead.robot.gate_file import source_digests
from fairlead.robot.manifest import RobotManifest, load_robot
from fairlead.skill.admission import Admission
from fairlead.skill.manifest import (
    SkillManifest,
    find_backend,
    load_skill,
    locate_in_skill,
    skill_ids,
)
from fairlead_skill_runner.options import RunnerOptions
from fairlead_skill_runner.policy_worker import PolicyWorker

Stamp = tuple[object, ...]


@dataclass(frozen=True)
class _Loaded:
    stamp: Stamp
    worker: PolicyWorker


class OfferedSkills:
    """Manifests and policy processes, read anew when files of a skill or the robot have changed.

    Args:
        source: the runner's name.
        profile: the robot's safety profile that holds.
    """

    def __init__(
        self, source: str, options: RunnerOptions, robot: RobotManifest, profile: str
    ) -> None:
        self._source, self._options = source, options
        self._robot, self._profile = robot, profile
        self._robot_files = source_digests(robot)
        self._log = logging.getLogger(source)
        self._workers: dict[str, _Loaded] = {}
        self._admissions: dict[str, Admission] = {}

    def at_start(self) -> dict[str, SkillManifest]:
        """What is on offer now; what cannot be is said in the log.

        Raises:
            ConfigError: for a skill that the options name, or for options that do not fit it.
        """
        found: dict[str, SkillManifest] = {}
        for name in self._options.skills or skill_ids():
            try:
                skill = load_skill(name)
                if self._offers(skill):
                    find_backend(self._options.policy(skill), locate_in_skill(name))
                    found[name] = skill
            except ConfigError as error:
                if self._options.skills is not None:
                    raise
                self._log.error("skill %s is left out: %s", name, error)
        self._options.check_servers(found)
        if not found:
            self._log.warning(
                "no skill is made for %s; make one: fairlead skill new, "
                "fairlead skill install --link",
                self._robot.id,
            )
        return found

    def find(self, name: str) -> Admission:
        """A skill held against the robot, anew if the files of either have changed.

        Raises:
            RefusedError: it is not on offer, with those that are.
            ConfigError: a manifest does not fit.
        """
        self._follow_robot()
        listed = self._options.skills
        known = name in (skill_ids() if listed is None else listed)
        skill = load_skill(name) if known else None
        if skill is None or not self._offers(skill):
            what = expected("goal", "a skill on offer", repr(name), self._names())
            raise RefusedError(self._source, what, f"fairlead skill ls --robot {self._robot.id}")
        held = self._admissions.get(name)
        if held is None or held.skill.skill_hash != skill.skill_hash:
            held = self._admissions[name] = Admission(skill, self._robot)
        return held

    async def worker(self, skill: SkillManifest) -> PolicyWorker:
        """The policy's process of its last goal, or a new one if a file has changed since.

        Not while a goal of the skill runs.

        Raises:
            ConfigError: no installed package has its policy backend.
        """
        stamp = await asyncio.to_thread(_stamp, skill), self._robot_files
        loaded = self._workers.get(skill.id)
        if loaded is None or loaded.stamp != stamp:
            policy = self._options.policy(skill)
            plugin = find_backend(policy, locate_in_skill(skill.id))
            if loaded is not None:
                self._log.info(
                    "skill %s or the robot has changed: its policy is loaded anew", skill.id
                )
                await loaded.worker.close()
            worker = PolicyWorker(
                plugin, skill, policy.options, self._robot.id, self._profile,
                self._options.added_latency_ms / 1e3,
            )  # fmt: skip
            loaded = self._workers[skill.id] = _Loaded(stamp, worker)
        return loaded.worker

    def share_a_policy(self, one: SkillManifest, other: SkillManifest) -> bool:
        """Whether they are the same skill, or ask the same server.

        Resolves the names of hosts, so it may take a while.
        """
        hosts = [
            _hosts(self._options.policy(skill).options.get("address")) for skill in (one, other)
        ]
        return one.id == other.id or not hosts[0].isdisjoint(hosts[1])

    async def close(self) -> None:
        """End every policy's process; a call that still runs fails."""
        for loaded in self._workers.values():
            await loaded.worker.close()

    def _follow_robot(self) -> None:
        files = source_digests(self._robot)
        if files != self._robot_files:
            self._robot = load_robot(self._robot.id)
            self._robot_files = files
            self._admissions.clear()

    def _offers(self, skill: SkillManifest) -> bool:
        return self._options.skills is not None or self._robot.id in skill.embodiments

    def _names(self) -> list[str]:
        if self._options.skills is not None:
            return list(self._options.skills)
        found = []
        for name in skill_ids():
            try:
                if self._offers(load_skill(name)):
                    found.append(name)
            except ConfigError:
                continue  # said in the log when the runner started
        return found


def _hosts(address: object) -> set[tuple[str, int]]:
    """Numbers and port of the hosts that an address names; of one unknown its own words."""
    if not isinstance(address, str):
        return set()
    try:
        named = urlsplit(address)
        port = named.port or (443 if named.scheme == "wss" else 80)
        found = socket.getaddrinfo(named.hostname or "", port, type=socket.SOCK_STREAM)
    except (OSError, ValueError):
        return {(address, 0)}
    return {(str(one[-1][0]), port) for one in found}


def _stamp(skill: SkillManifest) -> Stamp:
    """Changes with the manifest and with any file of the skill's folder that is not hidden."""
    folder = rskill_dir(skill.id)
    return (skill.skill_hash, str(folder.resolve()), *sorted(_edits(folder)))


def _edits(folder: Path) -> Iterator[tuple[str, int]]:
    """When each file was written; one may go while this looks."""
    for place, folders, files in os.walk(folder):
        folders[:] = [one for one in folders if not one.startswith(".")]  # an environment is large
        for path in (Path(place, one) for one in files if not one.startswith(".")):
            with suppress(FileNotFoundError):
                if path.suffix != ".pyc":
                    yield str(path), path.stat().st_mtime_ns
