"""One run of a gate as far as it is worth keeping, and what it shows."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from bench.recorded_sessions.decision_log import (
    BOOT,
    END,
    GAP,
    HEADER,
    HEADER_BYTES,
    STEP,
    TIMER,
    LogRecord,
    read_log,
    step_facts,
    write_log,
)
from fairlead.errors import MessageError
from fairlead.messages import GateStatus, Message, Refusal, Verdict, decode

VERDICT, STATUS, REFUSAL = 2, 4, 6  # OutputKind
M = TypeVar("M", bound=Message)


@dataclass(frozen=True)
class Session:
    """The beginning of a run, up to ``most_bytes``.

    name: where it comes from. config: the configuration that decided. shows: what happened in it.
    """

    name: str
    config: str
    records: tuple[LogRecord, ...]
    shows: frozenset[str]

    @property
    def size(self) -> int:
        """Bytes it takes in a log."""
        return sum(len(record.body) + 9 for record in self.records)


def read_session(path: Path, name: str, config: str, most_bytes: int) -> Session | None:
    """A log's session; None if nothing can be replayed of it."""
    kept, size = [], 0
    for record in read_log(path, most_bytes + HEADER_BYTES)[1:]:
        size += len(record.body) + 9
        if record.type == GAP or size > most_bytes:
            break
        if record.type in (BOOT, STEP, TIMER):
            kept.append(record)
    if not kept or kept[0].type != BOOT:
        return None
    return Session(name, config, tuple(kept), frozenset(shown(kept)))


def shown(records: Sequence[LogRecord]) -> Iterator[str]:
    """What is seen in records, in words."""
    for record in records:
        if record.type == STEP:
            facts = step_facts(record)
            yield f"event {facts.kind}"
            for kind, payload in facts.outputs:
                yield from _said(kind, payload)


def _said(kind: int, payload: bytes) -> Iterator[str]:
    yield f"output {kind}"
    if kind == VERDICT and (verdict := _message(Verdict, payload)):
        yield f"verdict {verdict.outcome} {verdict.code}"
        yield f"verdict {verdict.code} of {verdict.part} {verdict.axis}"
    if kind == STATUS and (status := _message(GateStatus, payload)):
        yield f"state {status.state} {' '.join(status.cause.split()[:2])}"
    if kind == REFUSAL and (refusal := _message(Refusal, payload)):
        yield f"refusal {refusal.reason[:16]}"


def _message(of: type[M], payload: bytes) -> M | None:
    try:
        return decode(of, payload)
    except MessageError:
        return None


def write_sessions(
    path: Path, config_file: str, text: str, sessions: Sequence[Session], kind: str
) -> None:
    """A log of sessions, one after the other, all decided by the configuration ``text``."""
    header = {
        "robot": json.loads(text)["robot"],
        "profile": "sim",
        "gate": "",
        "started": "",
        "config_file": config_file,
        "config": text,
    }
    records = [LogRecord(HEADER, json.dumps(header).encode())]
    records += [record for session in sessions for record in session.records]
    records.append(LogRecord(END, f"{len(sessions)} {kind} sessions".encode()))
    write_log(path, records)
