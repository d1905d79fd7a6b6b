"""Walks the same matrix where all are clients of a router, on two hosts."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import Any

from bench.equipment.live_robot import wait_for
from fairlead.deploy.deployment import Deployment
from fairlead.paths import ACCESS_VARIABLE
from fairlead.wire.endpoints import Endpoints
from tests.access.live_party import Found, LiveParty, all_came
from tests.access.party import Passed, endpoints_of, every_key, wildcards
from tests.access.walk import MESSAGES, Table, Walk
from tests.system.two_networks import TwoNetworks

LAWLESS = "!"
"""Behind the name of a session that keeps to no rule, but proves that it is who it says."""


class RoutedWalker:
    """A live process of every party, one with sessions that keep to no rule, and the router.

    Args:
        access: folder of each host with what is there to prove names.
        others: files of the robots that have the same router.
        nth: on which of the keys they try it: each so-many-th.
    """

    def __init__(
        self,
        network: TwoNetworks,
        file: Path,
        deployment: Deployment,
        access: Mapping[str, Path],
        others: Sequence[Path],
        nth: int = 1,
    ) -> None:
        self._network, self._file, self._access = network, file, access
        self._routed = [file, *others]
        self.deployment, self.parties = deployment, deployment.parties
        self._nth, self._keys = nth, every_key(self.parties)[::nth]
        self._table = Table(file, self._keys).allowed
        self._found, self.walk = Found(), Walk()
        self._live: dict[str, LiveParty] = {}
        self._strangers: list[str] = []

    @contextmanager
    def running(self, strangers: Mapping[str, Endpoints]) -> Iterator[None]:
        """Everybody, until the walk is over."""
        self._strangers = list(strangers)
        places = {name: host for host, name in self._places()}
        with ExitStack() as stack:
            stack.enter_context(self._router())
            for name in self.parties.names:
                arguments = [str(self._file), name, str(self._nth)]
                stack.enter_context(closing(self._start(name, arguments, places[name])))
            file = self._file.with_name("lawless.json")
            file.write_text(json.dumps(self._lawless(strangers)), encoding="utf-8")
            stack.enter_context(closing(self._start(LAWLESS, [str(file)], "gpu")))
            for one in self._live.values():
                one.wait_ready()
            self._found.settled(all_came)
            yield

    def _places(self) -> Iterable[tuple[str, str]]:
        for name in self.parties.names:
            spec = self.deployment.services.get(name)
            yield (spec.host if spec is not None else "gpu"), name

    @contextmanager
    def _router(self) -> Iterator[None]:
        words = [sys.executable, "-m", "fairlead_tools.cli.main", "router", *map(str, self._routed)]
        log = self._file.with_name("router.log")
        with log.open("wb") as out, subprocess.Popen(
            [*self._network.on("robot"), *words],
            stdout=out, stderr=out, env=os.environ | self._environment("robot"),
        ) as process:  # fmt: skip
            try:
                wait_for(lambda: "ready" in log.read_text(encoding="utf-8"), "the router is ready")
                yield
            finally:
                process.kill()

    def _environment(self, host: str) -> dict[str, str]:
        return {ACCESS_VARIABLE: str(self._access[host])}

    def _start(self, name: str, arguments: list[str], host: str) -> LiveParty:
        first, environment = self._network.on(host), self._environment(host)
        self._live[name] = LiveParty(arguments, self._found, first, environment)
        return self._live[name]

    def _lawless(self, strangers: Mapping[str, Endpoints]) -> dict[str, Any]:
        router = [self.deployment.router_endpoint]
        configs = {name: one.config() for name, one in strangers.items()}
        for name in self.parties.names:
            access = endpoints_of(self.deployment, name).access
            proof = {key: part for key, part in access.items() if key == "transport"}
            one = Endpoints(connect=router, mode="client", access=proof)
            configs[name + LAWLESS] = one.config()
        keys = [*self._keys, *wildcards(self.parties)]
        return {"keys": keys, "configs": configs}

    def honest(self, name: str) -> None:
        """A live process acts; all others of every name hear it, whether they keep to rules."""
        self._act(name, name, "")

    def lawless(self, name: str) -> None:
        """One acts that proves its name and keeps to no rule."""
        self._act(name + LAWLESS, LAWLESS, f" {name}{LAWLESS}")

    def strange(self) -> None:
        """Each acts that has no right to anything; then it is counted who of them has a link."""
        for name in self._strangers:
            self._live[LAWLESS].say(f"act {name}")
            self._compare(name, set())
            self._live[LAWLESS].rest(f"rest {name}")
        for name in self._strangers:
            self._live[LAWLESS].say(f"count {name}")
        passed = self._found.settled(all_came)
        self.linked = {p.receiver for p in passed if p.message == "link"}
        self.walk.links = len(self.linked)

    def _act(self, actor: str, process: str, word: str) -> None:
        self._live[process].say(f"act{word}")
        everybody = [one + end for one in self.parties.names for end in ("", LAWLESS)]
        expected = {
            p
            for other in everybody
            if other != actor
            for p in self._allowed(actor, other)
        }  # fmt: skip
        self._compare(actor, expected)
        self._live[process].rest(f"rest{word}")

    def _allowed(self, sender: str, receiver: str) -> Iterator[Passed]:
        for one in self._table(sender.rstrip(LAWLESS), receiver.rstrip(LAWLESS)):
            forth = (receiver, sender) if one.message == "reply" else (sender, receiver)
            yield one._replace(sender=forth[0], receiver=forth[1])

    def _compare(self, actor: str, expected: set[Passed]) -> None:
        wanted = set() if self.deployment.access == "closed" else MESSAGES

        def is_enough(passed: set[Passed]) -> bool:
            return expected <= passed and wanted <= {p.message for p in passed - expected}

        seen = self._found.settled(is_enough, lambda _: actor)
        self.walk.lost |= expected - seen
        self.walk.right += len(expected & seen)
        self.walk.take(actor, seen - expected, MESSAGES)
