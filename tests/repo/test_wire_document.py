"""The schema of the wire, `fairlead.messages`, explains itself; docs/wire-format.md its modes."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

from fairlead import messages
from fairlead.keys import Keys
from fairlead.messages import MESSAGE_TYPES, RECORD_TYPES, Message, Record
from fairlead.modes import ControlMode
from fairlead.wire.topics import short_key, topics

TEXT = (Path(__file__).parents[2] / "docs" / "wire-format.md").read_text()
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


def test_every_control_mode_is_listed() -> None:
    for one in ControlMode:
        assert re.search(rf"^- {one.value} {one.yaml_name}[,:] ", TEXT, re.M)


def test_the_widths_of_the_control_modes_are_those_of_the_code() -> None:
    listed = dict(re.findall(r"^- \d+ (\w+)(?:, (joints|\d+))?: ", TEXT, re.M))
    for mode in ControlMode:
        if mode in (ControlMode.JOINT_TRAJECTORY, ControlMode.FOOT_PLACEMENT):
            assert listed[mode.yaml_name] == ""
        else:
            wanted = "joints" if mode.is_joint_mode else str(mode.width(11))
            assert listed[mode.yaml_name] == wanted
