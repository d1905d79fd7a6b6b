"""What is wrong in a YAML file is told with its line and column."""

from __future__ import annotations

from pathlib import Path

import pytest
from pydantic import BaseModel, ConfigDict, Field

from fairlead.errors import ConfigError
from fairlead.yaml_file import load_yaml


class Lamp(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    watts: float = Field(gt=0)
    on: bool = True


class Room(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)

    name: str
    lamps: tuple[Lamp, ...] = ()
    size_m: tuple[float, float] = (1.0, 1.0)
    by_name: dict[str, Lamp | float] = Field(default_factory=dict)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name: a\nlamps:\n  - watts: 1\n  - watts: -3\n", ["4:5: lamps.1.watts: Input should be"]),
        ("name: a\nlamps: [{watts: 1, no: 2}]\n", ["2:20: lamps.0.no: unknown key"]),
        ("name: a\nlamps:\n  - on: true\n", ["3:5: lamps.0.watts: is missing"]),
        ("name: a\nsize_m: [1]\n", ["2:1: size_m.1: is missing"]),
        ("# room\nlamps: []\n", [" name: is missing"]),
        ("name: a\nlamps:\n  - {watts: true}\n", ["3:6: lamps.0.watts: expected a number"]),
        (
            "name: a\nby_name:\n  desk:\n    watts: 0\n",  # neither a lamp nor a number
            ["4:5: by_name.desk.Lamp.watts: Input", "3:3: by_name.desk.float: Input"],
        ),
    ],
)
def test_each_problem_names_its_line_and_column(text: str, told: list[str], tmp_path: Path) -> None:
    heading, *lines = refusal(text, tmp_path).splitlines()
    assert heading == f"{tmp_path}/room.yaml: {len(told)} problem(s):"
    for line, start in zip(lines, told, strict=True):
        assert line.startswith(f"  {tmp_path}/room.yaml:{start}")


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("name: a\nlamps: []\nname: b\n", "3:1: not valid YAML: key 'name' is given twice, "
         "first in line 1"),
        ("name:\n  a: 1\n b: 2\n", "3:2: not valid YAML: did not find expected key (while "
         "parsing a block mapping, which begins in line 1)"),
        ("name: a\nlamps: !!int x\n", "2:8: not valid YAML: a tag that its value is not: "),
    ],
)  # fmt: skip
def test_a_file_that_is_no_yaml_names_the_line(text: str, told: str, tmp_path: Path) -> None:
    assert refusal(text, tmp_path).startswith(f"{tmp_path}/room.yaml:{told}")


def refusal(text: str, folder: Path) -> str:
    path = folder / "room.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ConfigError) as caught:
        load_yaml(path, Room)
    return str(caught.value)


def test_aliases_that_stand_for_more_than_can_be_read_or_for_themselves_are_refused(
    tmp_path: Path,
) -> None:
    file = tmp_path / "room.yaml"
    bomb = "".join(
        f"l{n}: &l{n} [{', '.join([f'*l{n - 1}'] * 10 if n else ['1'] * 10)}]\n" for n in range(10)
    )
    tower = "".join(f"l{n}: &l{n} [{f'*l{n - 1}' if n else '1'}]\n" for n in range(200))
    most = "expected at most 100000 items, also behind aliases, 100 within each other, got "
    for text, told in (
        (bomb, most),
        (
            tower,
            most,
        ),
        ("name: &n [*n]\n", f"{file}:1:7: not valid YAML: an alias of what it stands in"),
    ):
        file.write_text(text, encoding="utf-8")
        with pytest.raises(ConfigError) as caught:
            load_yaml(file, Room)
        assert told in str(caught.value)
    file.write_text("name: a\nby_name: {one: &one {watts: 3}, two: *one}\n", encoding="utf-8")
    assert load_yaml(file, Room).by_name["two"] == Lamp(watts=3)
