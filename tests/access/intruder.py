"""Sessions that try what is not theirs on services that run: what they hear, and who answers.

``python -m tests.access.intruder FILE [UID]``: the file has their configurations, by name, and the
keys on which each publishes and asks; all hear everything. A line with a name lets that one act;
then it prints ``acted``. When no line comes any more, what they heard and how many links they had
is printed as data. With a user's id it is that user's process before it opens anything.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import zenoh

NOBODY = 65534
ANSWER_S = 0.5
NO_ANSWER = b"Timeout"
WAIT_S = 60.0


class Said(NamedTuple):
    """Keys on which an intruder publishes, and on which it asks."""

    put: Sequence[str]
    ask: Sequence[str]


class Heard(NamedTuple):
    """What came to an intruder: put, token or reply."""

    message: str
    key: str


class Intruder:
    """One session; hears everything from its beginning."""

    def __init__(self, name: str, config: Mapping[str, Any], said: Said) -> None:
        self._nonsense = b"\xff" + name.encode()
        self.heard: set[Heard] = set()
        self.links = 0
        self._said, self._kept = said, list[Any]()
        try:
            self._session = zenoh.open(zenoh.Config.from_json5(json.dumps(config)))
        except zenoh.ZError:  # a client that gets no link
            self._said = Said((), ())
            return
        put = zenoh.handlers.Callback(self._on("put"), indirect=False)
        token = zenoh.handlers.Callback(self._on("token"), indirect=False)
        for key in {"**", *said.put, *said.ask}:
            self._kept.append(self._session.declare_subscriber(key, put))
        self._kept.append(self._session.liveliness().declare_subscriber("**", token, history=True))

    def act(self) -> None:
        """Publish nonsense and ask, on every key."""
        for key in self._said.put:
            self._session.put(key, self._nonsense)
        for key in self._said.ask:
            for reply in self._session.get(key, payload=self._nonsense, timeout=ANSWER_S):
                if reply.err is None or reply.err.payload.to_bytes() != NO_ANSWER:
                    self.heard.add(Heard("reply", key))
        if self._said.put:
            info = self._session.info
            self.links = len([*info.peers_zid(), *info.routers_zid()])

    def _on(self, message: str) -> Callable[[zenoh.Sample], None]:
        def on_sample(sample: zenoh.Sample) -> None:
            if sample.payload.to_bytes() != self._nonsense:
                self.heard.add(Heard(message, str(sample.key_expr)))

        return on_sample


@dataclass(frozen=True)
class Found:
    """Of one intruder."""

    heard: frozenset[Heard]
    links: int


class Intruders:
    """Them all, in a process of their own.

    Args:
        configs: by name.
        said: by name, what each tries.
        user: whose process it is; None: the caller's.
    """

    def __init__(
        self,
        file: Path,
        configs: Mapping[str, Mapping[str, Any]],
        said: Mapping[str, Said],
        user: int | None = None,
    ) -> None:
        file.write_text(json.dumps({"configs": configs, "said": said}), encoding="utf-8")
        words = [sys.executable, "-m", "tests.access.intruder", str(file)]
        self._process = subprocess.Popen(
            words if user is None else [*words, str(user)],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, bufsize=1,
        )  # fmt: skip
        self._expect("ready")

    def act(self, name: str) -> None:
        """Returns once it has tried everything."""
        assert self._process.stdin is not None
        self._process.stdin.write(f"{name}\n")
        self._expect("acted")

    def end(self) -> dict[str, Found]:
        """What each has found, by name."""
        out, _ = self._process.communicate(timeout=WAIT_S)
        return {
            name: Found(frozenset(Heard(*each) for each in heard), links)
            for name, (heard, links) in json.loads(out).items()
        }

    def close(self) -> None:
        """End the process, whatever it does."""
        self._process.kill()
        self._process.wait(WAIT_S)

    def _expect(self, word: str) -> None:
        assert self._process.stdout is not None
        assert self._process.stdout.readline() == f"{word}\n"


def main(file: str, *user: str) -> None:
    content = json.loads(Path(file).read_text(encoding="utf-8"))
    for one in map(int, user):
        os.setgroups([])
        os.setresgid(one, one, one)
        os.setresuid(one, one, one)
    said = {name: Said(*theirs) for name, theirs in content["said"].items()}
    found = {name: Intruder(name, one, said[name]) for name, one in content["configs"].items()}
    print("ready", flush=True)
    for line in sys.stdin:
        found[line.strip()].act()
        print("acted", flush=True)
    print(json.dumps({name: (sorted(one.heard), one.links) for name, one in found.items()}))
    sys.stdout.flush()
    os._exit(0)  # a session that got no link takes its time to close


if __name__ == "__main__":
    main(*sys.argv[1:])
