"""Edits of a configuration in one place; paths are keys and indices with dots between them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

Change = Callable[[dict[str, Any]], object]


def _at(file: Any, path: str) -> tuple[Any, Any]:
    *way, last = path.split(".")
    for step in way:
        file = file[int(step) if step.isdigit() else step]
    return file, int(last) if last.isdigit() else last


def put(path: str, value: Any) -> Change:
    """Set what is at the path, or add the key."""

    def change(file: dict[str, Any]) -> None:
        place, key = _at(file, path)
        place[key] = value

    return change


def drop(path: str) -> Change:
    """Take out what is at the path."""

    def change(file: dict[str, Any]) -> None:
        place, key = _at(file, path)
        del place[key]

    return change


def again(path: str) -> Change:
    """Append the first entry of the list at the path once more."""

    def change(file: dict[str, Any]) -> None:
        place, key = _at(file, path)
        place[key].append(place[key][0])

    return change
