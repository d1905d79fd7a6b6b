"""The golden files are current, complete, and what the Python codec reads and writes."""

from __future__ import annotations

import hashlib
import json
import subprocess
from pathlib import Path

import pytest

from fairlead.errors import MessageError
from fairlead.keys import Keys
from fairlead.messages import MESSAGE_TYPES, Message, decode, encode
from tests.golden import generate
from tests.golden.instances import MESSAGES

FOLDER = Path(__file__).resolve().parent
INDEX = json.loads((FOLDER / "index.json").read_text())
REFUSED = json.loads((FOLDER / "refused.json").read_text())
KEYS = json.loads((FOLDER / "keys.json").read_text())
TYPES: dict[str, type[Message]] = {kind.__name__: kind for kind in MESSAGE_TYPES}


@pytest.mark.processes
def test_check_finds_nothing_to_write_in_a_clean_tree() -> None:
    root = FOLDER.parent.parent
    done = subprocess.run(
        [root / "scripts" / "make-golden", "--check"], capture_output=True, text=True, timeout=60
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_check_names_a_changed_a_missing_and_a_leftover_file(tmp_path: Path) -> None:
    for name, data in generate.golden_files().items():
        (tmp_path / name).write_bytes(data)
    assert generate.differences(tmp_path) == []
    (tmp_path / "Arm.bin").write_bytes(b"\x00")
    (tmp_path / "Lease.bin").unlink()
    (tmp_path / "Old.bin").write_bytes(b"")
    assert generate.differences(tmp_path) == ["Arm.bin", "Lease.bin", "Old.bin"]


def test_every_message_type_has_a_rich_golden_file() -> None:
    assert {name for name in MESSAGES if "." not in name} == set(TYPES)


def test_a_rich_instance_has_no_two_equal_scalar_fields() -> None:
    for name in TYPES:
        message = MESSAGES[name]
        numbers = [
            value
            for field in message.__struct_fields__
            if field != "version"
            and isinstance(value := getattr(message, field), int | float | bytes)
            and not isinstance(value, bool)
            and value
        ]
        assert len(numbers) == len(set(numbers)), f"{name} cannot show a swapped field"


@pytest.mark.parametrize("row", INDEX, ids=lambda row: row["file"])
def test_golden_bytes_decode_to_the_instance_and_encode_to_themselves(row: dict[str, str]) -> None:
    data = (FOLDER / row["file"]).read_bytes()
    assert hashlib.sha256(data).hexdigest() == row["sha256"]
    message = decode(TYPES[row["type"]], data)
    assert message == MESSAGES[row["file"].removesuffix(".bin")] or "extremes" in row["file"]
    assert encode(message) == data


@pytest.mark.parametrize("row", REFUSED, ids=lambda row: f"{row['type']}: {row['defect']}")
def test_a_defective_frame_is_refused(row: dict[str, str]) -> None:
    with pytest.raises(MessageError):
        decode(TYPES[row["type"]], bytes.fromhex(row["hex"]))


@pytest.mark.parametrize("row", KEYS, ids=lambda row: row["key"])
def test_golden_key_is_what_the_key_module_builds(row: dict[str, str]) -> None:
    attribute = getattr(Keys(row["robot"], row["namespace"]), row["method"])
    assert (attribute(row["argument"]) if row["argument"] else attribute) == row["key"]
