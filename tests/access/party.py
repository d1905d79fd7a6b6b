"""One Zenoh session that tries everything and tells everything that comes of it.

``python -m tests.access.party DEPLOYMENT NAME NTH`` is a live process of a deployment: its session
is the one that a service or tool of that name opens. It prints ``ready``, acts or rests as the
lines say that it reads, and prints what it gets. ``python -m tests.access.party FILE`` has many
sessions that keep to no rule: the file has their keys and, by name, their configurations; a line
names who acts or rests.
"""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import zenoh

from fairlead.deploy.access import Parties, rights
from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.wire.endpoints import Endpoints

ANSWER_S = 10.0
STRANGERS: Mapping[str, Mapping[str, Any]] = {
    "a default peer": {},
    "a wrong password": {
        "transport": {"auth": {"usrpwd": {"user": "operator", "password": "0" * 64}}}
    },
    "an unknown name": {
        "transport": {"auth": {"usrpwd": {"user": "nobody", "password": "0" * 64}}}
    },
}


class Passed(NamedTuple):
    """A message that came through: put, delete, query, reply or token. A token has no sender."""

    sender: str
    receiver: str
    message: str
    key: str


def every_key(parties: Parties) -> list[str]:
    """Each key of the table, those of others, and what is none of the robot's."""
    own = {one.key.replace("*", "thing") for one in rights(parties)}
    own |= {key for one in rights(parties) for key in one.but if "*" not in key}
    own |= {one.family.replace("*", name) for one in rights(parties) for name in parties.names}
    space, robot = parties.keys.namespace, parties.keys.robot
    foreign = {f"{space}/{robot}/unknown", f"{space}/another/state/joints", f"other/{robot}/x"}
    return sorted(own | foreign)


def wildcards(parties: Parties) -> list[str]:
    """What has all keys, many of them, or the admin space."""
    robot = f"{parties.keys.namespace}/{parties.keys.robot}"
    return ["**", f"{robot}/**", f"{robot}/safety/*", f"{robot}/action/**", "@/**", "@/*/**"]


class Party:
    """Subscribes, answers and watches on every key from its beginning; tells what comes.

    Args:
        name: the sender that others are told.
        asked: keys on which it acts.
        heard: keys on which it listens.
        told: gets each message.
    """

    def __init__(
        self,
        name: str,
        config: dict[str, Any],
        asked: list[str],
        heard: list[str],
        told: Callable[[Passed], None],
    ) -> None:
        self.name, self._asked, self._told = name, asked, told
        self.session = zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
        self._kept: list[Any] = []
        for key in heard:
            self._kept += [
                self.session.declare_subscriber(key, _direct(self._on_sample)),
                self.session.declare_queryable(key, _direct(self._on_query)),
                self.session.liveliness().declare_subscriber(
                    key, _direct(self._on_token), history=True
                ),
            ]
        self._tokens: list[zenoh.LivelinessToken] = []

    def rest(self) -> None:
        """Take the tokens back."""
        while self._tokens:
            self._tokens.pop().undeclare()  # type: ignore[no-untyped-call]

    def act(self) -> None:
        """Put, delete, ask and declare a token, on every key; answers are told as they come."""
        for key in self._asked:
            if "*" not in key:
                self._tokens.append(self.session.liveliness().declare_token(key))
            self.session.put(key, self.name)
            self.session.delete(key, attachment=self.name)
            self.session.get(
                key,
                _direct(self._on_reply),
                payload=self.name,
                timeout=ANSWER_S,
                target=zenoh.QueryTarget.ALL,
                consolidation=zenoh.ConsolidationMode.NONE,
            )

    def count(self) -> None:
        """Tell of each link that there is."""
        for other in self.neighbours:
            self._told(Passed(str(other), self.name, "link", ""))

    @property
    def neighbours(self) -> list[object]:
        """Ids of those that there is a link with."""
        return [*self.session.info.peers_zid(), *self.session.info.routers_zid()]

    def close(self) -> None:
        self.session.close()  # type: ignore[no-untyped-call]

    def _tell(self, sender: str, message: str, key: object) -> None:
        own_admin_space = f"@/{self.session.zid()}/"
        if sender != self.name and not str(key).startswith(own_admin_space):
            self._told(Passed(sender, self.name, message, str(key)))

    def _on_sample(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            self._tell(sample.payload.to_string(), "put", sample.key_expr)
        elif sample.attachment is not None:
            self._tell(sample.attachment.to_string(), "delete", sample.key_expr)

    def _on_query(self, query: zenoh.Query) -> None:
        with query:
            if query.payload is not None:
                self._tell(query.payload.to_string(), "query", query.key_expr)
            query.reply(query.key_expr, self.name)

    def _on_token(self, sample: zenoh.Sample) -> None:
        if sample.kind == zenoh.SampleKind.PUT:
            self._tell("", "token", sample.key_expr)

    def _on_reply(self, reply: zenoh.Reply) -> None:
        if reply.ok is not None:
            self._tell(reply.ok.payload.to_string(), "reply", reply.ok.key_expr)


def _direct(told: Callable[[Any], None]) -> Any:
    """Called where the message comes: otherwise Zenoh starts a thread for each of thousands."""
    return zenoh.handlers.Callback(told, indirect=False)


def endpoints_of(deployment: Deployment, name: str) -> Endpoints:
    """Of a service, or of what only dials."""
    if name in deployment.services:
        return deployment.endpoints(name)
    return deployment.tool_endpoints(name)


def honest(file: str, name: str, nth: str) -> dict[str, Party]:
    """The session of a service or tool; it acts on each so-many-th key."""
    deployment = load_deployment(Path(file))
    parties = deployment.parties
    keys = every_key(parties)[:: int(nth)]
    families = {one.family for one in rights(parties)}
    config = endpoints_of(deployment, name).config()
    return {"": Party(name, config, keys, ["**", *sorted(families | set(keys))], _tell)}


def lawless(file: str) -> dict[str, Party]:
    """Sessions that keep to no rule."""
    content = json.loads(Path(file).read_text(encoding="utf-8"))
    keys = content["keys"]
    return {name: Party(name, one, keys, keys, _tell) for name, one in content["configs"].items()}


def main(*arguments: str) -> None:
    found = honest(*arguments) if len(arguments) == 3 else lawless(*arguments)
    _print("ready")
    for line in sys.stdin:
        word, _, name = line.strip().partition(" ")
        {"act": found[name].act, "rest": found[name].rest, "count": found[name].count}[word]()
        if word == "rest":
            _print("rested")
    for party in found.values():
        party.close()


def _tell(passed: Passed) -> None:
    _print(json.dumps(passed))


def _print(line: str) -> None:
    os.write(1, f"{line}\n".encode())  # in one piece: Zenoh calls on several threads


if __name__ == "__main__":
    main(*sys.argv[1:])
