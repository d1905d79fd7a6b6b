"""What cannot be printed is told by its bytes, as the gate does."""

from __future__ import annotations

import logging

import pytest

from fairlead.wire.printable import LineFormatter, printable


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("a\nINFO b", "a\\x0aINFO b"),
        ("\x1b[2J", "\\x1b[2J"),
        ("\x00\x1f \x7f", "\\x00\\x1f \\x7f"),
        ("\x85\xa0", "\\xc2\\x85\xa0"),
        ("\u202e!", "\\xe2\\x80\\xae!"),
        ("\u2066", "\\xe2\\x81\\xa6"),
        ("\u200f\u2010", "\\xe2\\x80\\x8f\u2010"),
        ("é€\u2027\u2065\u206a", "é€\u2027\u2065\u206a"),
    ],
)
def test_control_characters_are_told_by_their_bytes(text: str, told: str) -> None:
    assert printable(text) == told


def test_a_message_stays_one_line_and_a_traceback_keeps_its_own() -> None:
    try:
        raise ValueError("two\nlines")
    except ValueError as error:
        info = (type(error), error, error.__traceback__)
    record = logging.LogRecord("hal", logging.INFO, "", 0, "by %s", ("x\nERROR hal: no",), info)
    record.created = 1_795_420_440.123
    line, *rest = LineFormatter().format(record).split("\n")
    assert line == "2026-11-23T07:54:00.123Z INFO hal: by x\\x0aERROR hal: no"
    assert rest[0] == "Traceback (most recent call last):"
