"""Walks the matrix of party, key and kind of message against live processes of one deployment."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import ExitStack, closing, contextmanager
from dataclasses import dataclass, field
from functools import cache, partial
from pathlib import Path
from typing import Any

from bench.equipment.live_robot import wait_for
from fairlead.deploy.deployment import Deployment
from fairlead.wire.endpoints import Endpoints
from tests.access.live_party import WAIT_S, Found, LiveParty, all_came
from tests.access.party import Party, Passed, every_key, wildcards
from tests.cli.command import fairlead_here

MESSAGES = frozenset({"put", "delete", "query", "reply", "token"})


class Table:
    """Who may do what, as `fairlead acl show` prints it.

    Args:
        keys: on which somebody tries something.
    """

    def __init__(self, file: Path, keys: Sequence[str]) -> None:
        done = fairlead_here("acl", "show", str(file), "--json", state=file.parent)
        assert done.returncode == 0, done.stderr
        self._rows: list[dict[str, Any]] = json.loads(done.stdout)["rows"]
        self._keys = keys
        self._passed = cache(self._pass)

    def allowed(self, sender: str, receiver: str) -> frozenset[Passed]:
        """What one party may send to another, with the answers to its queries."""
        return self._passed(sender, receiver)

    def may(self, name: str, what: str, kind: str) -> list[str]:
        """Keys of a kind that a party may ``write`` or ``read``, at somebody else's."""
        rows = [one for one in self._rows if name in one[what] and one["kind"] == kind]
        return [
            key
            for key in self._keys
            if any(_has(one["key"], key) and key not in one["except"] for one in rows)
        ]

    def _pass(self, sender: str, receiver: str) -> frozenset[Passed]:
        return frozenset(self._each(sender, receiver))

    def _each(self, sender: str, receiver: str) -> Iterator[Passed]:
        word = {"published": "put", "query": "query", "token": "token"}
        for one in self._rows:
            if sender in one["write"] and receiver in one["read"]:
                for key in self._keys:
                    if _has(one["key"], key) and key not in one["except"]:
                        yield Passed(sender, receiver, word[one["kind"]], key)
                        if one["kind"] == "query":
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
        steps: who did something, and which kinds of message did not come through as breaches.
    """

    breaches: set[Passed] = field(default_factory=set)
    lost: set[Passed] = field(default_factory=set)
    links: int = 0
    steps: dict[str, frozenset[str]] = field(default_factory=dict)
    right: int = 0

    def __str__(self) -> str:
        lines = [
            f"{len(self.steps)} steps, {self.right} messages as the table says, "
            f"{len(self.breaches)} breaches, {len(self.lost)} lost, {self.links} links of strangers"
        ]
        for what, found in (("breach", self.breaches), ("lost", self.lost)):
            lines += [f"  {what}: {' '.join(one)}" for one in sorted(found)[:10]]
        return "\n".join(lines)

    def take(self, step: str, breaches: set[Passed], kinds: frozenset[str]) -> None:
        """What one step found.

        Args:
            kinds: those that come through where access is open.
        """
        assert step not in self.steps, step
        self.steps[step] = kinds - {one.message for one in breaches}
        self.breaches |= breaches

    @property
    def stopped(self) -> dict[str, frozenset[str]]:
        """Of each step, the kinds of message of which access control let no breach through."""
        return {step: kinds for step, kinds in self.steps.items() if kinds}


class Walker:
    """Live processes of every party of a deployment, and sessions that keep to no rule.

    Args:
        nth: on which of the keys they try it: each so-many-th.
    """

    def __init__(self, file: Path, deployment: Deployment, nth: int = 1) -> None:
        self._file, self.deployment, self.parties = file, deployment, deployment.parties
        self._nth, self._keys = nth, every_key(self.parties)[::nth]
        self._allowed = Table(file, self._keys).allowed
        self._found, self.walk = Found(), Walk()
        self._live: dict[str, LiveParty] = {}

    @contextmanager
    def running(self) -> Iterator[None]:
        """Every party as a process."""
        try:
            for name in self.parties.names:
                self._live[name] = LiveParty([str(self._file), name, str(self._nth)], self._found)
            for one in self._live.values():
                one.wait_ready()
            yield
        finally:
            for one in self._live.values():
                one.close()

    @contextmanager
    def _away(self, name: str) -> Iterator[None]:
        """A service's process ends, and begins anew: no second link has its id."""
        self._live.pop(name).close()
        yield
        self._live[name] = LiveParty([str(self._file), name, str(self._nth)], self._found)
        self._live[name].wait_ready()

    def honest(self, name: str) -> None:
        """One live process acts; all others keep to the rules too."""
        dials = self.parties.dials
        linked = [one for one in self.parties.names if dials(name, one) or dials(one, name)]
        expected = {p for one in linked for p in self._allowed(name, one)}
        self._say([name], "act")
        self._compare(f"{name} acts", expected, partial(_always, name))
        self._rest([name])

    def dialler(self, name: str, access: Mapping[str, Any]) -> None:
        """A party that keeps to no rule dials every service and acts; then these act.

        Args:
            access: what it proves itself with, to those it dials.
        """
        services = list(self.parties.services)
        if name in services:
            services.remove(name)
        known = [s for s in services if self.parties.dials(name, s)]
        forth = {p for s in known for p in self._allowed(name, s)}
        back = {p for s in known for p in self._allowed(s, name)}
        with ExitStack() as stack:
            if name in self.parties.services:
                stack.enter_context(self._away(name))
            sessions = [self._dialling(name, service, access) for service in services]
            for session in sessions:
                stack.enter_context(closing(session))
                session.act()
            mine = {session.name for session in sessions}
            self._compare(
                f"who dials as {name}",
                {_at(p, name) for p in forth},
                lambda at: at if at in mine else f"{name}@{at}",
            )
            for session in sessions:
                session.rest()
            self._say(services, "act")
            self._compare(
                f"to whoever dials as {name}",
                {_at(p, name) for p in back},
                lambda at: at.partition("@")[2],
                only="@",
            )
            self._rest(services)

    def _dialling(self, name: str, service: str, access: Mapping[str, Any]) -> Party:
        # A client sends everything that it says, a peer only what others say that they want.
        listen = self.deployment.listen(service)
        if not self.parties.dials(name, service):  # to that one the id is whom it dials
            access = {part: value for part, value in access.items() if part != "id"}
        one = Endpoints(connect=[listen], mode="client", access=access)
        return self._lawless(f"{name}@{service}", one)

    def _lawless(self, name: str, endpoints: Endpoints) -> Party:
        many = [*self._keys, *wildcards(self.parties)]
        return Party(name, endpoints.config(), many, many, self._found.add)

    def stranger(self, name: str, access: Mapping[str, Any]) -> None:
        """One that is no party dials every service and acts; then these act."""
        services = self.parties.services
        listens = [self.deployment.listen(service) for service in services]
        with closing(self._lawless(name, Endpoints(connect=listens, access=access))) as one:
            one.act()
            self._compare(f"who dials with {name}", set(), partial(_always, name))
            one.rest()
            self._say(services, "act")
            step = f"to whoever dials with {name}"
            self._compare(step, set(), partial(_always, "a service"), only=name)
            self._rest(services)
            self.walk.links += len(one.neighbours)

    def listener(self, name: str, access: Mapping[str, Any]) -> None:
        """A service ends, and somebody who keeps to no rule stands in its place and acts.

        Then those act, one by one, that dial the service.
        """
        self._live.pop(name).close()
        diallers = [one for one in self._live if self.parties.dials(one, name)]
        listen = self.deployment.listen(name)
        with closing(self._lawless(name, Endpoints(listen=[listen], access=access))) as impostor:
            wait_for(lambda: len(impostor.neighbours) == len(diallers), f"all dial {name}", WAIT_S)
            self._found.settled(all_came)
            impostor.act()
            expected = {p for one in diallers for p in self._allowed(name, one)}
            self._compare(f"in the place of {name}", expected, partial(_always, name))
            impostor.rest()
            for one in diallers:
                self._say([one], "act")
                back = set(self._allowed(one, name))
                step = f"{one} to whoever is in the place of {name}"
                self._compare(step, back, partial(_always, one), only=name)
                self._rest([one])

    def _rest(self, names: Iterable[str]) -> None:
        for name in names:
            self._live[name].rest()

    def _say(self, names: Iterable[str], word: str) -> None:
        for name in names:
            self._live[name].say(word)

    def _compare(
        self, step: str, expected: set[Passed], sender_of: Callable[[str], str], only: str = ""
    ) -> None:
        # Of a token beside one of the same key, which has just been taken back, nobody is told.
        kinds = MESSAGES - {"token"} if only else MESSAGES
        wanted = set() if self.deployment.access == "closed" else kinds

        def mine(passed: set[Passed]) -> set[Passed]:
            return {p for p in passed if only in f"{p.sender} {p.receiver}"}

        def is_enough(passed: set[Passed]) -> bool:
            found = mine(passed)
            return expected <= found and wanted <= {p.message for p in self._breaches(found)}

        seen = mine(self._found.settled(is_enough, sender_of))
        self.walk.lost |= expected - seen
        self.walk.right += len(expected & seen)
        self.walk.take(step, self._breaches(seen - expected), kinds)

    def _breaches(self, passed: set[Passed]) -> set[Passed]:
        return {p for p in passed if not self._is_right(p)}

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
        return passed._replace(sender=sender, receiver=receiver) in self._allowed(*both)


def _always(name: str, _: str) -> str:
    return name


def _at(passed: Passed, name: str) -> Passed:
    """The same, by the names that a dialler's sessions have: one for each service."""
    if passed.sender == name:
        return passed._replace(sender=f"{name}@{passed.receiver}")
    return passed._replace(receiver=f"{name}@{passed.sender}")
