"""The schema of the wire, `fairlead.messages`, explains itself."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator

import pytest

from fairlead import messages
from fairlead.keys import Keys
from fairlead.messages import MESSAGE_TYPES, RECORD_TYPES, Message, Record
from fairlead.wire.topics import short_key, topics

COMMON = dict(re.findall(r"^    ([a-z_]+) {2,}(\w+) {2,}\S", messages.__doc__ or "", re.M))
RECORDS = "|".join(kind.__name__ for kind in RECORD_TYPES)
SPEAKING = re.compile(rf"Literal\[|bool$|(?:tuple\[)?(?:{RECORDS})\b|V1")
"""A type that says by itself what it can be."""


def fields_without_words(kind: type) -> Iterator[tuple[str, str]]:
    """Name and type of each field that has no comment beside it."""
    lines = re.findall(r"^    (\w+): (.+)$", inspect.getsource(kind), re.M)
    declared = {name: text.partition("  # ") for name, text in lines}
    for name in kind.__struct_fields__:  # type: ignore[attr-defined]
        wire, _, words = declared[name]
        if not words and not SPEAKING.match(wire):
            yield name, wire


@pytest.mark.parametrize("kind", [*MESSAGE_TYPES, *RECORD_TYPES], ids=lambda kind: kind.__name__)
def test_a_field_without_words_has_the_type_and_meaning_it_has_everywhere(kind: type) -> None:
    assert set(fields_without_words(kind)) <= COMMON.items()


def test_every_common_meaning_is_used() -> None:
    bare = {one for kind in MESSAGE_TYPES for one in fields_without_words(kind)}
    assert COMMON.items() <= bare | {("mode", "U8")}


def test_every_published_message_begins_with_its_key() -> None:
    keys = Keys("robot")
    for topic in topics(keys):
        [said] = re.findall(r"^`([^`]+)`:", topic.kind.__doc__ or "")
        assert re.sub("<[a-z]+>", "*", said) == short_key(keys, topic.key_expr)


def test_the_catalogue_has_every_type_there_is() -> None:
    assert set(MESSAGE_TYPES) == set(Message.__subclasses__())
    assert set(RECORD_TYPES) == set(Record.__subclasses__())


def test_type_ids_are_unique_and_ascend() -> None:
    ids = [tag for kind in MESSAGE_TYPES if isinstance(tag := kind.__struct_config__.tag, int)]
    assert len(ids) == len(MESSAGE_TYPES)
    assert ids == sorted(set(ids))
