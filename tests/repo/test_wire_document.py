"""docs/wire-format.md says what the code does: every message, field, order, type and number."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from fairlead import messages
from fairlead.messages import (
    MESSAGE_TYPES,
    RECORD_TYPES,
    GateState,
    Hold,
    Message,
    Record,
)
from fairlead.modes import ControlMode
from tests.repo.wire_types import rows

TEXT = (Path(__file__).parents[2] / "docs" / "wire-format.md").read_text()


ENTRY = re.compile(r"^(?:(\d+) )?([A-Z]\w+)(?:: .*)?\n((?:    .*\n)*)", re.M)
DESCRIBED = [
    (tag, name, re.findall(r"^    (\w+) +(.+?)(?: {2,}(.*))?$", fields, re.M))
    for block in re.findall(r"^```text\n(.*?)^```", TEXT, re.M | re.S)
    for tag, name, fields in ENTRY.findall(block)
]


@pytest.mark.parametrize("kind", [*MESSAGE_TYPES, *RECORD_TYPES], ids=lambda kind: kind.__name__)
def test_the_text_of_a_type_lists_its_id_version_and_fields_in_wire_order(kind: type) -> None:
    [(tag, fields)] = [(tag, fields) for tag, name, fields in DESCRIBED if name == kind.__name__]
    head = [("type", tag), ("version", "1")] if tag else []
    assert head + [(name, wire) for name, wire, _ in fields] == rows(kind)


def test_a_field_without_words_has_the_type_and_meaning_it_has_everywhere() -> None:
    common = set(re.findall(r"^([a-z_]+) {2,}(.+?) {2,}\S", TEXT, re.M))
    records = {kind.__name__ for kind in RECORD_TYPES}
    bare = {(name, wire) for *_, fields in DESCRIBED for name, wire, words in fields if not words}
    speaking = {one for one in bare if '"' in one[1] or one[1].strip("[]") in records | {"bool"}}
    assert bare - speaking
    assert bare - speaking - common == set()


def test_the_document_describes_no_type_that_does_not_exist() -> None:
    described = [name for _, name, _ in DESCRIBED]
    assert described == [kind.__name__ for kind in (*MESSAGE_TYPES, *RECORD_TYPES)]


def test_the_catalogue_has_every_type_there_is() -> None:
    assert set(MESSAGE_TYPES) == set(Message.__subclasses__())
    assert set(RECORD_TYPES) == set(Record.__subclasses__())


def test_type_ids_are_unique_and_ascend() -> None:
    ids = [tag for kind in MESSAGE_TYPES if isinstance(tag := kind.__struct_config__.tag, int)]
    assert len(ids) == len(MESSAGE_TYPES)
    assert ids == sorted(set(ids))


@pytest.mark.parametrize(
    ("numbers", "label"),
    [
        (Hold, lambda one: f"| {one.value} {one.name} |"),
        (GateState, lambda one: f"| {one.value} {one.name} |"),
        (ControlMode, lambda one: f"| {one.value} | {one.yaml_name} |"),
        (messages.Outcome, lambda one: f"{one.value} {one.name.lower()}"),
        (messages.Decision, lambda one: f"{one.value} {one.name.lower()}"),
    ],
)
def test_every_number_with_a_name_is_listed(numbers, label) -> None:  # type: ignore[no-untyped-def]
    for one in numbers:
        assert label(one) in TEXT


def test_the_widths_of_the_control_modes_are_those_of_the_code() -> None:
    table = dict(re.findall(r"^\| \d+ \| (\w+) \| (joints|\d*) *\|", TEXT, re.M))
    for mode in ControlMode:
        if mode in (ControlMode.JOINT_TRAJECTORY, ControlMode.FOOT_PLACEMENT):
            assert table[mode.yaml_name] == ""
        else:
            wanted = "joints" if mode.is_joint_mode else str(mode.width(11))
            assert table[mode.yaml_name] == wanted
