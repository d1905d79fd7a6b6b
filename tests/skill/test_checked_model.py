"""One error for everything in a file or option block that does not fit."""

from __future__ import annotations

from typing import Annotated

import pytest
from pydantic import BaseModel, ConfigDict, Field

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError


class Closed(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Lamp(Closed):
    colour: str = "white"
    kind: str = Field(default="led", alias="class")


class Room(Closed):
    width_m: float = Field(gt=0)
    lamp: Lamp | None = None
    lamps: tuple[Lamp, ...] = ()
    size_m: tuple[float, float] = (0.0, 0.0)
    tags: tuple[str, ...] = Field(default=("x",), min_length=1)
    by_name: dict[str, Annotated[Lamp, "named"]] = Field(default_factory=dict)


def refusal(**data: object) -> str:
    with pytest.raises(ConfigError) as caught:
        checked_model("room.yaml", Room, {"width_m": 1.0} | data)
    return str(caught.value)


def test_what_fits_is_handed_back() -> None:
    room = checked_model("room.yaml", Room, {"width_m": 2, "lamp": {"class": "neon"}})
    assert (room.width_m, room.lamp) == (2.0, Lamp(**{"class": "neon"}))


LAMP_KEYS = "unknown key, did you mean colour? (valid: colour, class)"


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ({"widht_m": 1}, "widht_m: unknown key, did you mean width_m? "
         "(valid: width_m, lamp, lamps, size_m, tags, by_name)"),
        ({"zzz": 1}, "zzz: unknown key (valid: width_m, lamp, lamps, size_m, tags, by_name)"),
        ({"lamp": {"color": "red"}}, f"lamp.color: {LAMP_KEYS}"),
        ({"lamps": [{}, {"color": "red"}]}, f"lamps.1.color: {LAMP_KEYS}"),
        ({"by_name": {"desk": {"color": "red"}}}, f"by_name.desk.color: {LAMP_KEYS}"),
    ],
)  # fmt: skip
def test_an_unknown_key_is_named_with_the_valid_ones_at_its_place(
    data: dict[str, object], text: str
) -> None:
    assert refusal(**data) == f"room.yaml: 1 problem(s):\n  {text}"


def test_every_problem_has_its_line_and_says_what_came() -> None:
    with pytest.raises(ConfigError) as caught:
        checked_model("room.yaml", Room, {"lamp": 3, "lamps": [{"colour": 5}]})
    assert str(caught.value).splitlines() == [
        "room.yaml: 3 problem(s):",
        "  width_m: is missing",
        "  lamp: expected `key: value` lines, got 3",
        "  lamps.0.colour: expected text, got 5",
    ]
    assert "width_m: Input should be greater than 0, got -1" in refusal(width_m=-1)


@pytest.mark.parametrize(
    ("data", "text"),
    [
        ({"lamps": "desk"}, "lamps: expected a list, got 'desk'"),
        ({"lamps": {"desk": 1}}, "lamps: expected a list, got `key: value` lines"),
        ({"lamp": []}, "lamp: expected `key: value` lines, got a list"),
        ({"by_name": [1]}, "by_name: expected `key: value` lines, got a list"),
        ({"size_m": [1]}, "size_m.1: is missing"),
        ({"size_m": [1, 2, 3]}, "size_m: expected at most 2 items, got 3"),
        ({"tags": []}, "tags: expected at least 1 item, got 0"),
        ({"lamp": {"colour": ["red"]}}, "lamp.colour: expected text, got a list"),
    ],
)
def test_other_kinds_are_said_in_the_words_of_a_file(data: dict[str, object], text: str) -> None:
    assert refusal(**data) == f"room.yaml: 1 problem(s):\n  {text}"
