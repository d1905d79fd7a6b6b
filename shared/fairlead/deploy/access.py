"""Who may write and read what: the one table, and what of it each session enforces.

Every service and tool has a name. On one host it proves it, by its password, to those it dials; a
service is known by its session's id, too. Each session lets through, in both directions, what
`TABLE` gives to both ends of a link, and nothing else. `fairlead.deploy.routed_access` has what a
router and its clients let through.
"""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from fairlead.keys import Keys, of_person

Role = Literal["hal", "safety", "state_assembler", "runner", "localiser", "operator"]
Kind = Literal["published", "query", "token"]

OPERATOR = "operator"
"""Whose name the command line and all Python clients have that no person's certificate names."""

DIAL_ORDER: Sequence[Role] = ("hal", "safety", "state_assembler", "runner")
"""A service dials those of the roles before its own, so that the HAL knows everybody by password:
also the gate."""


@dataclass(frozen=True)
class Row:
    """A key of the robot, ``*`` for any one chunk, and who may do what with it.

    Attributes:
        writers: who publishes, asks, or declares the token.
        readers: who subscribes, answers, or watches the token.
        own: which of them have the key in which ``*`` is their name; the operator has those of
            nobody's name.
        person: a command; where a deployment lists people, each of them has a key of their own for
            it, one chunk longer, and no tool the key itself.
    """

    key: str
    kind: Kind
    writers: Sequence[Role]
    readers: Sequence[Role]
    own: Literal["", "writer", "reader"] = ""
    person: bool = False


SERVICES: Sequence[Role] = DIAL_ORDER
ALL: Sequence[Role] = (*SERVICES, "operator")
ASKERS: Sequence[Role] = ("runner", "operator")
HEARERS: Sequence[Role] = ("safety", "operator")

TABLE = (
    Row("state/joints", "published", ("hal",), ALL),
    Row("tf/*", "published", ("hal", "state_assembler", "localiser"),
        ("state_assembler", "localiser", *HEARERS), own="writer"),  # `hal check` as the gate
    Row("camera/*", "published", ("hal",), ASKERS),
    Row("camera/*/shared/*", "token", ("hal",), ASKERS),
    Row("state/layout/*", "published", ("state_assembler",), ASKERS),
    Row("action/candidate/*", "published", ASKERS, HEARERS, own="writer"),
    Row("action/safe/*", "published", ("safety",), ("hal", "operator")),
    Row("safety/lease", "published", ("safety",), ALL),
    Row("safety/verdict/*", "published", ("safety",), ASKERS),
    Row("safety/status", "published", ("safety",), ALL),
    Row("safety/status", "query", ASKERS, ("safety",)),
    Row("safety/stop", "published", ("hal", *HEARERS), ALL),
    Row("safety/cmd/arm", "query", ("operator",), ("safety",), person=True),
    Row("safety/cmd/disarm", "query", ("operator",), ("safety",), person=True),
    Row("safety/cmd/reset", "query", ("operator",), ("safety",), person=True),
    Row("safety/cmd/claim/*", "query", ASKERS, ("safety",), own="writer", person=True),
    Row("safety/cmd/release/*", "query", ASKERS, ("safety",), own="writer"),
    Row("hal/status", "published", ("hal",), ALL),
    Row("hal/status", "query", ("runner", *HEARERS), ("hal",)),
    Row("hal/cmd/reset_episode", "query", ("operator",), ("hal",), person=True),
    Row("hal/session/*", "token", ("hal",), ("hal",)),
    Row("task/state", "published", ("hal",), ASKERS),
    Row("skill/*/goal", "query", ("operator",), ("runner",), own="reader", person=True),
    Row("skill/*/cancel", "query", ("operator",), ("runner",), own="reader", person=True),
    Row("skill/*/load", "query", ("operator",), ("runner",), own="reader", person=True),
    Row("skill/*/feedback", "published", ("runner",), ("operator",), own="writer"),
    Row("skill/*/feedback", "query", ("operator",), ("runner",), own="reader"),
    Row("skill/*/heartbeat", "published", ASKERS, HEARERS, own="writer"),
    Row("alive/*", "token", SERVICES, ALL, own="writer"),
    Row("want/layout/*", "token", ASKERS, ("state_assembler",)),
)  # fmt: skip


@dataclass(frozen=True)
class Parties:
    """Everybody who may have a session, by name.

    Attributes:
        services: those that are dialled, in the order of `DIAL_ORDER`.
        others: those that only dial.
        people: those of them that are persons: operators of whom each has a name of their own.
    """

    keys: Keys
    services: Mapping[str, Role]
    others: Mapping[str, Role]
    people: Sequence[str] = ()

    @property
    def names(self) -> list[str]:
        """All of them."""
        return [*self.services, *self.others]

    def role(self, name: str) -> Role:
        """What a party is."""
        return self.services[name] if name in self.services else self.others[name]

    def before(self, name: str) -> list[str]:
        """Whom a service dials."""
        names = list(self.services)
        return names[: names.index(name)]

    def dials(self, one: str, other: str) -> bool:
        """Whether it is ``one`` that dials ``other``."""
        if one in self.others:
            return other in self.services
        return other in self.services and other in self.before(one)


@dataclass(frozen=True)
class Rights:
    """Who may do what with one key of a deployment.

    Attributes:
        write: names of those who publish, ask, or declare the token.
        read: names of those who subscribe, answer, or watch the token.
        family: that of the table.
        heard: the key with which readers may do so.
        but: keys that ``key`` has but that are somebody's own.
    """

    key: str
    kind: Kind
    write: Sequence[str]
    read: Sequence[str]
    family: str
    heard: str
    but: Sequence[str]


def rights(parties: Parties) -> Iterator[Rights]:
    """The table with the names of a deployment: one for each key and kind."""

    def full(key: str) -> str:
        return f"{parties.keys.namespace}/{parties.keys.robot}/{key}"

    for row in TABLE:
        write = [name for name in parties.names if parties.role(name) in row.writers]
        read = [name for name in parties.names if parties.role(name) in row.readers]
        owners: dict[str, list[str]] = {}
        for name in read if row.own == "reader" else write:
            is_own = row.own and parties.role(name) != "operator"
            own = row.key.replace("*", name) if is_own else row.key
            owners.setdefault(own, []).append(name)
        for key, names in owners.items():
            both = (write, names) if row.own == "reader" else (names, read)
            heard = key if row.own == "reader" else row.key
            but = [own for own in owners if key == row.key != own]
            if row.person and parties.people and OPERATOR in both[0]:
                family, heard = (full(of_person(one, "*")) for one in (row.key, heard))
                for one in parties.people:
                    mine, others = full(of_person(key, one)), [full(of_person(k, one)) for k in but]
                    yield Rights(mine, row.kind, [one], both[1], family, heard, others)
                continue
            others = [full(own) for own in but]
            yield Rights(full(key), row.kind, *both, full(row.key), full(heard), others)


_MESSAGES: Mapping[Kind, tuple[tuple[str, ...], tuple[str, ...]]] = {
    "published": (("put",), ("declare_subscriber",)),
    "query": (("query",), ("declare_queryable", "reply")),
    "token": (("liveliness_token",), ("liveliness_query", "declare_liveliness_subscriber")),
}
"""What the writer of a row sends to its reader, and what the reader to the writer."""


@dataclass(frozen=True)
class Grant:
    """What one party may send to another.

    Attributes:
        messages: as Zenoh calls them.
        but: keys that are not meant, though ``key`` has them.
    """

    sender: str
    receiver: str
    messages: tuple[str, ...]
    key: str
    but: Sequence[str] = ()


def grants(parties: Parties, namesakes: bool = False) -> Iterator[Grant]:
    """Everything that anybody may send to anybody else.

    Args:
        namesakes: also to another process of the same name: two tools, a HAL that starts twice.
    """
    for one in rights(parties):
        forth, back = _MESSAGES[one.kind]
        for writer in one.write:
            for reader in one.read:
                if namesakes or writer != reader:
                    yield Grant(writer, reader, forth, one.key, one.but)
                    yield Grant(reader, writer, back, one.heard)


@dataclass(frozen=True)
class Secrets:
    """What proves names.

    Attributes:
        passwords: by name.
        file: where they are, as Zenoh reads them: ``name:password``.
    """

    passwords: Mapping[str, str]
    file: Path

    def session_id(self, service: str) -> str:
        """By which those that dial a service know it; Zenoh's ids have no zeros in front."""
        digest = hashlib.sha256(f"session of {self.passwords[service]}".encode())
        return f"f{digest.hexdigest()[:31]}"


def session_access(parties: Parties, own: str, secrets: Secrets) -> dict[str, Any]:
    """The part of a Zenoh configuration that makes a session one of this party's.

    It has a password in it: it goes into no log and on no command line.
    """
    every = list(grants(parties))
    subjects: list[tuple[dict[str, Any], list[dict[str, Any]]]] = []
    for other in parties.names:
        sent = [one for one in every if (one.sender, one.receiver) == (own, other)]
        got = [one for one in every if (one.sender, one.receiver) == (other, own)]
        subject: dict[str, Any] = {"id": other}
        if other in parties.services:
            subject["zids"] = [secrets.session_id(other)]
        if not parties.dials(own, other):
            subject["usernames"] = [other]
        subjects.append((subject, [*rules(sent, "egress"), *rules(got, "ingress")]))
    proof = {
        "user": own,
        "password": secrets.passwords[own],
        "dictionary_file": str(secrets.file),
    }
    control = access_control(subjects)
    transport = {"auth": {"usrpwd": proof}, "unicast": {"max_links": 1}}
    access: dict[str, Any] = {"transport": transport, "access_control": control}
    return access | ({"id": secrets.session_id(own)} if own in parties.services else {})


def access_control(
    subjects: Iterable[tuple[Mapping[str, Any], Sequence[Mapping[str, Any]]]],
) -> dict[str, Any]:
    """A part of a Zenoh configuration: what passes to and from those it names, and nothing else.

    Args:
        subjects: each with its rules; one without any gets nothing.
    """
    control: dict[str, Any] = {
        "enabled": True,
        "default_permission": "deny",
        "rules": [],
        "subjects": [],
        "policies": [],
    }
    for subject, theirs in subjects:
        if not theirs:
            continue
        name = subject["id"]
        named = [{"id": f"{name} {number}", **rule} for number, rule in enumerate(theirs)]
        control["rules"] += named
        control["subjects"].append(subject)
        control["policies"].append({"subjects": [name], "rules": [rule["id"] for rule in named]})
    return control


def rules(those: Iterable[Grant], flow: Literal["egress", "ingress"]) -> Iterator[dict[str, Any]]:
    """What may pass, as Zenoh's rules of one end of a link."""
    keys: dict[tuple[str, tuple[str, ...]], list[str]] = {}
    for grant in those:
        keys.setdefault(("allow", grant.messages), []).append(grant.key)
        keys.setdefault(("deny", grant.messages), []).extend(grant.but)
    for (permission, messages), found in keys.items():
        if found:
            yield {
                "permission": permission,
                "messages": list(messages),
                "flows": [flow],
                "key_exprs": list(dict.fromkeys(found)),
            }
