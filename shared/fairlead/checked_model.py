"""Data from a file into a frozen pydantic model, or one error with all that is wrong."""

from __future__ import annotations

import difflib
import re
import types
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Annotated, Any, TypeVar, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from fairlead.errors import ConfigError

Model = TypeVar("Model", bound=BaseModel)

Place = tuple[int | str, ...]
"""Keys and indices that lead to a value."""

Locate = Callable[[Place], str]
"""Says what to write before a complaint about the value at a place, such as its line."""


def nowhere(place: Place) -> str:
    """What is known of the line of data that come from no file."""
    return ""


_KINDS = dict.fromkeys(("list_type", "tuple_type"), "a list")
_KINDS |= dict.fromkeys(("dict_type", "model_type"), "`key: value` lines") | {"string_type": "text"}
"""What pydantic asks for, in the words of a file; other kinds of Python's it calls by these too."""

_SCALARS = (str, int, float, type(None))
"""What an error repeats; a whole block would not help."""


class MisfitError(ConfigError):
    """Data do not fit their model."""

    def __init__(self, who: str, problems: Sequence[tuple[Place, str]], locate: Locate) -> None:
        text = "".join(f"\n  {locate(place)}{said}" for place, said in problems)
        super().__init__(f"{who}: {len(problems)} problem(s):{text}")
        self._who, self._problems = who, problems

    def located(self, locate: Locate) -> MisfitError:
        """The same by somebody who knows where the data come from."""
        return MisfitError(self._who, self._problems, locate)


def checked_model(
    who: str,
    model: type[Model],
    data: Mapping[str, Any],
    locate: Locate = nowhere,
) -> Model:
    """``data`` as ``model``.

    Args:
        who: the file or the option block, as errors call it.

    Raises:
        MisfitError: naming every field that does not fit; for an unknown key also the valid
            ones and the one that was probably meant.
    """
    try:
        checked = model.model_validate(dict(data))
        problems = list(_other_kinds((), data, checked))
    except ValidationError as error:
        items = error.errors()
        problems = [
            p for item in items if not _follows(item, items) for p in _problems(item, model)
        ]
    if problems:
        told = [(_told_place(data, place, text), _dotted(place) + text) for place, text in problems]
        raise MisfitError(who, told, locate)
    return checked


def _dotted(place: Place) -> str:
    return "".join(f"{part}." for part in place)[:-1] + ": " if place else ""


_TOLD = re.compile(r"(?:([a-z ]+) )?'([^']+)'(?:: )?|([^\s':]+): ")
"""How a complaint may begin: ``part 'arm': ``, ``joint 'x' is``, ``seam.blend_ticks: ``."""


def _told_place(data: Any, place: Place, said: str) -> Place:
    """The place that a complaint about ``place`` goes on to name, as far as the data has it."""
    told, value = _follow(data, place)
    while begun := _TOLD.match(said):
        kind, name, dotted = begun.groups()
        steps = dotted.split(".") if dotted else [f"{kind}s".replace(" ", "_"), name]
        led, value_there = _follow(value, steps)
        if not led:
            break
        told, value, said = (*told, *led), value_there, said[begun.end() :]
    return told or place


def _follow(value: Any, steps: Iterable[int | str]) -> tuple[Place, Any]:
    """Those of some steps that lead on from a value, and what they lead to.

    A name leads to the item of a list that has it, or is it.
    """
    led: Place = ()
    for step in steps:
        inside: Iterable[tuple[int | str, Any]] = ()
        if isinstance(value, Mapping):
            inside = value.items()
        elif isinstance(value, list | tuple):
            inside = enumerate(value)
        for key, one in inside:
            has_name = isinstance(step, str) and isinstance(value, list | tuple)
            name = one.get("name") if isinstance(one, Mapping) else one
            if str(key) == str(step) or (has_name and name == step):
                led, value = (*led, key), one
                break
    return led, value


def _other_kinds(place: Place, raw: Any, checked: Any) -> Iterator[tuple[Place, str]]:
    """What pydantic would turn into something else: `true` into 1, "010" into 10, 1 into true."""
    if isinstance(checked, bool):
        if not isinstance(raw, bool):
            yield place, f"expected true or false, got {raw!r}"
    elif isinstance(checked, int | float):
        if isinstance(raw, bool | str):
            yield place, f"expected a number, got {raw!r}"
    elif isinstance(checked, BaseModel) and isinstance(raw, Mapping):
        for name, field in type(checked).model_fields.items():
            key = field.alias or name
            if key in raw:
                yield from _other_kinds((*place, key), raw[key], getattr(checked, name))
    elif isinstance(checked, Mapping) and isinstance(raw, Mapping):
        for key, value in checked.items():
            yield from _other_kinds((*place, key), raw.get(key), value)
    elif isinstance(checked, list | tuple) and isinstance(raw, list | tuple):
        for index, (one, value) in enumerate(zip(raw, checked, strict=False)):
            yield from _other_kinds((*place, index), one, value)


def _problems(item: ErrorDetails, model: type[BaseModel]) -> list[tuple[Place, str]]:
    """One of pydantic's errors; a validator of ours may have found several."""
    place, got = item["loc"], item["input"]
    if item["type"] == "extra_forbidden":
        return [(place, _unknown_key(str(place[-1]), _keys_at(model, place[:-1])))]
    if item["type"] == "missing":
        return [(place, "is missing")]
    if item["type"] == "value_error":  # one of our validators, which says what it got
        return [(place, text) for text in item["msg"].removeprefix("Value error, ").splitlines()]
    if kind := _KINDS.get(item["type"]):
        python = type(got).__name__
        named = repr(got) if isinstance(got, _SCALARS) else _KINDS.get(f"{python}_type", python)
        return [(place, f"expected {kind}, got {named}")]
    if item["type"] in ("too_short", "too_long"):  # a list or a block; of a text it is another
        most, met = item["ctx"].get("max_length"), item["ctx"]["actual_length"]
        bound = f"at least {item['ctx']['min_length']}" if most is None else f"at most {most}"
        return [(place, f"expected {bound} item{'s' * (not bound.endswith(' 1'))}, got {met}")]
    return [(place, item["msg"] + (f", got {got!r}" if isinstance(got, _SCALARS) else ""))]


def _follows(item: ErrorDetails, items: Sequence[ErrorDetails]) -> bool:
    """Whether a list is too short only because something in it is wrong."""
    place = item["loc"]
    inner = (one["loc"] for one in items)
    return item["type"] == "too_short" and any(
        len(one) > len(place) and one[: len(place)] == place for one in inner
    )


def _unknown_key(key: str, valid: Sequence[str]) -> str:
    close = difflib.get_close_matches(key, valid, n=1)
    meant = f", did you mean {close[0]}?" if close else ""
    return f"unknown key{meant} (valid: {', '.join(valid)})"


def _keys_at(model: type[BaseModel], place: Sequence[int | str]) -> list[str]:
    """The keys that are valid where ``place`` leads to."""
    found = [
        field.alias or name
        for block in _models_at(model, place)
        for name, field in block.model_fields.items()
    ]
    return list(dict.fromkeys(found))


def _models_at(kind: Any, place: Sequence[int | str]) -> Iterator[type[BaseModel]]:
    """Every model that may stand at ``place`` inside a value of type ``kind``."""
    origin, inner = get_origin(kind), get_args(kind)
    if origin is Annotated:
        yield from _models_at(inner[0], place)
    elif origin in (Union, types.UnionType):
        for one in inner:
            yield from _models_at(one, place)
    elif isinstance(kind, type) and issubclass(kind, BaseModel):
        if not place:
            yield kind
        for name, field in kind.model_fields.items():
            if place and place[0] in (name, field.alias):
                yield from _models_at(field.annotation, place[1:])
    elif inner and place:  # a mapping's values, or a sequence's items
        yield from _models_at(inner[-1] if issubclass(origin, Mapping) else inner[0], place[1:])
