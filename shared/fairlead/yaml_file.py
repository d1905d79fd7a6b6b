"""Read a YAML file into a frozen pydantic model, or say in one error what is wrong; write one."""

from __future__ import annotations

import re
from collections.abc import Iterator
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar

import yaml
from pydantic import BaseModel

from fairlead.checked_model import Locate, Place, checked_model
from fairlead.errors import ConfigError
from fairlead.regular_file import regular

Model = TypeVar("Model", bound=BaseModel)

_DEEPEST = 100  # blocks or brackets within each other
_MOST_NODES = 100_000
_NULL, _MERGE = "tag:yaml.org,2002:null", "tag:yaml.org,2002:merge"
_PLAIN = {
    "bool": r"true|True|TRUE|false|False|FALSE",
    "int": r"[-+]?(?:0|[1-9][0-9]*)",
    "float": (
        r"[-+]?(?:(?:0|[1-9][0-9]*)(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][-+]?[0-9]+)?"
        r"|[-+]?\.(?:inf|Inf|INF)|\.(?:nan|NaN|NAN)"
    ),
}
"""What a word without quotes may mean. Plain YAML also takes `on` as true, 010 as 8, 1:30 as 90."""


class _PlainLoader(yaml.CSafeLoader):
    """Refuses a mapping that has the same key twice, and merge keys; knows `_PLAIN` only."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[object, object]:
        seen: dict[object, yaml.Mark] = {}
        for key_node, _ in node.value:
            key = self._key(key_node)
            if key in seen:
                first = f"first in line {seen[key].line + 1}"
                raise yaml.MarkedYAMLError(
                    problem=f"key {key!r} is given twice, {first}", problem_mark=key_node.start_mark
                )
            seen[key] = key_node.start_mark
        return super().construct_mapping(node, deep=deep)

    def construct_object(self, node: yaml.Node, deep: bool = False) -> object:
        try:
            value: object = super().construct_object(node, deep=deep)
        except (ValueError, KeyError, AttributeError, TypeError) as error:  # what !!int says
            raise yaml.MarkedYAMLError(
                problem=f"a tag that its value is not: {error}", problem_mark=node.start_mark
            ) from None
        return value

    def _key(self, node: yaml.Node) -> object:
        problem = None
        if not isinstance(node, yaml.ScalarNode):
            problem = "expected a word as key"
        elif node.tag == _MERGE:
            problem = "merge keys (<<) are not taken: write the keys out, or name a whole block"
        if problem is not None:
            raise yaml.MarkedYAMLError(problem=problem, problem_mark=node.start_mark)
        key: object = self.construct_object(node, deep=True)
        return key


_PlainLoader.yaml_implicit_resolvers = {
    first: [(tag, pattern) for tag, pattern in known if tag in (_NULL, _MERGE)]
    for first, known in yaml.CSafeLoader.yaml_implicit_resolvers.items()
}
for _kind, _pattern in _PLAIN.items():
    _PlainLoader.add_implicit_resolver(
        f"tag:yaml.org,2002:{_kind}", re.compile(f"(?:{_pattern})$"), list("-+.0123456789tTfF")
    )


def load_yaml(path: Path, model: type[Model]) -> Model:
    """Load ``path`` as ``model``.

    Raises:
        ConfigError: naming the file and every field that does not fit, with line, column and the
            valid keys.
    """
    data, root = _read(path)
    if not isinstance(data, dict):
        got = "nothing" if data is None else type(data).__name__
        raise ConfigError(f"{path}: expected `key: value` lines, got {got}")
    return checked_model(str(path), model, data, lambda place: _where(path, root, place))


def locator(path: Path) -> Locate:
    """Says ``file:line:column: `` of what is at a place in a file, read when it is asked."""

    def locate(place: Place) -> str:
        try:
            root = _read(path)[1]
        except ConfigError:  # it is gone, or broken since
            root = None
        return _where(path, root, place)

    return locate


def _where(path: Path, node: yaml.Node | None, place: Place) -> str:
    """``file:line:column: `` of the key or item at ``place``, else of the block it should be in."""
    mark = None
    for step in place:  # one that leads nowhere is pydantic's: a kind that it tried
        if isinstance(node, yaml.MappingNode):
            for key, value in node.value:
                if key.value == str(step):
                    mark, node = key.start_mark, value
                    break
        elif isinstance(node, yaml.SequenceNode) and step in range(len(node.value)):
            node = node.value[int(step)]
            mark = node.start_mark
    return f"{path}: " if mark is None else f"{path}:{mark.line + 1}:{mark.column + 1}: "


def _read(path: Path) -> tuple[object, yaml.Node | None]:
    """What the file says, and the nodes it was made of, which know their lines."""
    try:
        text = regular(path).read_text(encoding="utf-8")
        _check_depth(path, text)
        loader = _PlainLoader(text)
        root = loader.get_single_node()
        _check_aliases(path, root)
        return None if root is None else loader.construct_document(root), root
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: not a text file in UTF-8") from None
    except yaml.MarkedYAMLError as error:
        raise ConfigError(_story(path, error)) from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{path}: not valid YAML: {error}") from None


def _check_depth(path: Path, text: str) -> None:
    """Nodes are built by recursion that only ends with the memory; events come one by one."""
    depth = 0
    for event in yaml.parse(text, _PlainLoader):
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST:
            raise ConfigError(f"{path}: not valid YAML: brackets within brackets, too deep")


def _check_aliases(path: Path, root: yaml.Node | None) -> None:
    """Ten aliases in each of ten lines stand for ten thousand million items.

    What an alias stands for has begun before it, so this goes no deeper than the text does.
    """
    known: dict[int, tuple[int, int]] = {}  # how many items a node stands for, and how deep

    def measure(node: yaml.Node) -> tuple[int, int]:
        found = known.get(id(node))
        if found == (0, 0):
            raise yaml.MarkedYAMLError(
                problem="an alias of what it stands in", problem_mark=node.start_mark
            )
        if found is None:
            known[id(node)] = (0, 0)
            below = [measure(one) for one in _below(node)]
            count = 1 + sum(one for one, _ in below)
            found = known[id(node)] = count, 1 + max((deep for _, deep in below), default=0)
        return found

    count, depth = (0, 0) if root is None else measure(root)
    if count > _MOST_NODES or depth > _DEEPEST:
        raise ConfigError(
            f"{path}: not valid YAML: expected at most {_MOST_NODES} items, also behind aliases, "
            f"{_DEEPEST} within each other, got {count} and {depth}"
        )


def _below(node: yaml.Node) -> Iterator[yaml.Node]:
    if isinstance(node, yaml.SequenceNode):
        yield from node.value
    elif isinstance(node, yaml.MappingNode):
        yield from chain.from_iterable(node.value)


def _story(path: Path, error: yaml.MarkedYAMLError) -> str:
    mark, began = error.problem_mark, error.context_mark
    where = f":{mark.line + 1}:{mark.column + 1}" if mark else ""
    context = f" ({error.context}, which begins in line {began.line + 1})" if began else ""
    return f"{path}{where}: not valid YAML: {error.problem}{context}"


class RowDumper(yaml.SafeDumper):
    """Numbers and names in a row stand on one line, as people write them."""

    def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
        """On one line, unless there are rows in it."""
        plain = all(not isinstance(item, list | dict) for item in sequence)
        return super().represent_sequence(tag, sequence, flow_style=plain)
