"""Walks the matrix of party, key and kind of message against live processes of one deployment."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any

from bench.equipment.live_robot import wait_for
from fairlead.deploy.access import Parties, rights
from fairlead.deploy.deployment import Deployment
from fairlead.wire.endpoints import Endpoints
from tests.access.live_party import WAIT_S, Found, LiveParty
from tests.access.party import Party, Passed, every_key, wildcards


def allowed(parties: Parties, sender: str, receiver: str) -> Iterator[Passed]:
    """What the table lets one party send to another, but for the answers to a query."""
    word = {"published": "put", "query": "query", "token": "token"}
    for one in rights(parties):
        if sender in one.write and receiver in one.read:
            for key in every_key(parties):
                if _has(one.key, key) and key not in one.but:
                    yield Passed(sender, receiver, word[one.kind], key)
                    if one.kind == "query":
                        yield Passed(receiver, sender, "reply", key)


def _has(pattern: str, key: str) -> bool:
    chunks, theirs = pattern.split("/"), key.split("/")
    return len(chunks) == len(theirs) and all(
        mine in ("*", other) for mine, other in zip(chunks, theirs, strict=True)
    )


@dataclass
class Walk:
    """What was found.

    Attributes:
        breaches: what nobody had a right to.
        lost: what somebody had a right to, and what did not come.
        links: those that strangers got.
    """

    breaches: set[Passed] = field(default_factory=set)
    lost: set[Passed] = field(default_factory=set)
    links: int = 0
    steps: int = 0
    right: int = 0

    def __str__(self) -> str:
        lines = [
            f"{self.steps} steps, {self.right} messages as the table says, {len(self.breaches)} "
            f"breaches, {len(self.lost)} lost, {self.links} links of strangers"
        ]
        for what, found in (("breach", self.breaches), ("lost", self.lost)):
            lines += [f"  {what}: {' '.join(one)}" for one in sorted(found)[:10]]
        return "\n".join(lines)


class Walker:
    """Live processes of every party of a deployment, and sessions that keep to no rule."""

    def __init__(self, file: Path, deployment: Deployment) -> None:
        self._file, self.deployment, self.parties = file, deployment, deployment.parties
        self._keys, names = every_key(self.parties), self.parties.names
        self._table = {
            p for one in names for other in names for p in allowed(self.parties, one, other)
        }
        self._found, self.walk = Found(), Walk()
        self._live: dict[str, LiveParty] = {}

    @contextmanager
    def running(self) -> Iterator[None]:
        """Every party as a process."""
        with ExitStack() as stack:
            for name in self.parties.names:
                live = LiveParty([str(self._file), name], self._found)
                self._live[name] = stack.enter_context(closing(live))
            for one in self._live.values():
                one.wait_ready()
            yield

    def honest(self, name: str) -> None:
        """One live process acts; all others keep to the rules too."""
        dials = self.parties.dials
        linked = [one for one in self.parties.names if dials(name, one) or dials(one, name)]
        expected = {p for one in linked for p in allowed(self.parties, name, one)}
        self._say([name], "act")
        self._compare(expected, partial(_always, name))
        self._say([name], "rest")

    def dialler(self, name: str, access: Mapping[str, Any]) -> None:
        """A party that keeps to no rule dials every service and acts; then these act.

        Args:
            access: what it proves itself with.
        """
        services = list(self.parties.services)
        known = [s for s in services if self.parties.dials(name, s)]
        forth = {p for s in known for p in allowed(self.parties, name, s)}
        back = {p for s in known for p in allowed(self.parties, s, name)}
        with ExitStack() as stack:
            sessions = [self._dialling(name, service, access) for service in services]
            for session in sessions:
                stack.enter_context(closing(session))
                session.act()
            mine = {session.name for session in sessions}
            self._compare(
                {_at(p, name) for p in forth}, lambda at: at if at in mine else f"{name}@{at}"
            )
            for session in sessions:
                session.rest()
            self._say(services, "act")
            self._compare({_at(p, name) for p in back}, lambda at: at.partition("@")[2], only="@")
            self._say(services, "rest")

    def _dialling(self, name: str, service: str, access: Mapping[str, Any]) -> Party:
        # A client sends everything that it says, a peer only what others say that they want.
        listen = self.deployment.services[service].listen
        one = Endpoints(connect=[listen], mode="client", access=access)
        return self._lawless(f"{name}@{service}", one)

    def _lawless(self, name: str, endpoints: Endpoints) -> Party:
        many = [*self._keys, *wildcards(self.parties)]
        return Party(name, endpoints.config(), many, many, self._found.add)

    def stranger(self, name: str, access: Mapping[str, Any]) -> None:
        """One that is no party dials every service and acts; then these act."""
        services = self.parties.services
        listens = [self.deployment.services[service].listen for service in services]
        with closing(self._lawless(name, Endpoints(connect=listens, access=access))) as one:
            one.act()
            self._compare(set(), partial(_always, name))
            one.rest()
            self._say(services, "act")
            self._compare(set(), partial(_always, "a service"), only=name)
            self._say(services, "rest")
            self.walk.links += len(one.neighbours)

    def listener(self, name: str, access: Mapping[str, Any]) -> None:
        """A service ends, and somebody who keeps to no rule stands in its place and acts.

        Then those act, one by one, that dial the service.
        """
        self._live.pop(name).close()
        diallers = [one for one in self._live if self.parties.dials(one, name)]
        listen = self.deployment.services[name].listen
        with closing(self._lawless(name, Endpoints(listen=[listen], access=access))) as impostor:
            wait_for(lambda: len(impostor.neighbours) == len(diallers), f"all dial {name}", WAIT_S)
            self._found.settled((), str)
            impostor.act()
            expected = {p for one in diallers for p in allowed(self.parties, name, one)}
            self._compare(expected, partial(_always, name))
            impostor.rest()
            for one in diallers:
                self._say([one], "act")
                back = set(allowed(self.parties, one, name))
                self._compare(back, partial(_always, one), only=name)
                self._say([one], "rest")

    def _say(self, names: Iterable[str], word: str) -> None:
        for name in names:
            self._live[name].say(word)

    def _compare(
        self, expected: set[Passed], sender_of: Callable[[str], str], only: str = ""
    ) -> None:
        passed = self._found.settled(expected, sender_of)
        seen = {p for p in passed if only in f"{p.sender} {p.receiver}"}
        self.walk.lost |= expected - seen
        self.walk.right += len(expected & seen)
        self.walk.breaches |= {p for p in seen - expected if not self._is_right(p)}
        self.walk.steps += 1

    def _is_right(self, passed: Passed) -> bool:
        """Whether somebody had the right to it: a service sends on what its clients may say."""
        sender, _, at_sender = passed.sender.partition("@")
        receiver, _, at_receiver = passed.receiver.partition("@")
        links = ((sender, at_sender), (receiver, at_receiver))
        if not all(name in self.parties.names for name, _ in links) or not all(
            self.parties.dials(name, service) for name, service in links if service
        ):
            return False
        both = (sender, receiver) if passed.message != "reply" else (receiver, sender)
        return passed._replace(sender=sender, receiver=receiver) in set(
            allowed(self.parties, *both)
        )


def _always(name: str, _: str) -> str:
    return name


def _at(passed: Passed, name: str) -> Passed:
    """The same, by the names that a dialler's sessions have: one for each service."""
    if passed.sender == name:
        return passed._replace(sender=f"{name}@{passed.receiver}")
    return passed._replace(receiver=f"{name}@{passed.sender}")
