"""``robots/<id>/capsules.yaml``: the robot's shape, and which of its parts are kept apart.

``fairlead robot capsules`` makes the file; a person reviews it and commits it. Every pair of
capsules is either checked or says why not: nothing is left out by oversight.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Annotated

from pydantic import Field, model_validator

from fairlead.errors import ConfigError
from fairlead.paths import robot_dir
from fairlead.robot.manifest import RobotManifest
from fairlead.robot.mode_limits import Point, Positive, SafetyBlock
from fairlead.yaml_file import load_yaml

Index = Annotated[int, Field(ge=0)]
MAX_CAPSULES = 48
MAX_PAIRS = 512


class Capsule(SafetyBlock):
    """All points within ``radius_m`` of the segment from ``a_m`` to ``b_m`` in a link's frame."""

    link: str
    a_m: Point
    b_m: Point
    radius_m: Annotated[Positive, Field(le=10.0)]


class UncheckedLinks(SafetyBlock):
    """Two links whose capsules are not kept apart, and why that is no loss."""

    links: tuple[str, str]
    why: str = Field(min_length=1, pattern=r"\S")


class CapsuleFile(SafetyBlock):
    """The whole file.

    checked_pairs: indices into ``capsules``, the smaller one first.
    never_checked: every pair of links with capsules that has no checked pair.
    """

    source: str
    capsules: tuple[Capsule, ...] = Field(min_length=1, max_length=MAX_CAPSULES)
    checked_pairs: tuple[tuple[Index, Index], ...] = Field(max_length=MAX_PAIRS)
    never_checked: tuple[UncheckedLinks, ...] = ()

    @model_validator(mode="after")
    def _every_pair_is_decided(self) -> CapsuleFile:
        problems = [*self._pair_problems()] or [*self._open_questions()]
        if problems:
            raise ValueError("\n".join(problems))
        return self

    def _pair_problems(self) -> Iterator[str]:
        seen = set()
        for first, second in self.checked_pairs:
            if not first < second < len(self.capsules):
                yield (
                    f"checked_pairs: expected two capsules in ascending order below "
                    f"{len(self.capsules)}, got [{first}, {second}]"
                )
            elif self.capsules[first].link == self.capsules[second].link:
                yield f"checked_pairs: [{first}, {second}] are both on {self.capsules[first].link}"
            if (first, second) in seen:
                yield f"checked_pairs: [{first}, {second}] is there twice"
            seen.add((first, second))

    def _open_questions(self) -> Iterator[str]:
        links = dict.fromkeys(capsule.link for capsule in self.capsules)
        checked = {self._links(*pair) for pair in self.checked_pairs}
        excused = [frozenset(entry.links) for entry in self.never_checked]
        for entry in self.never_checked:
            for link in entry.links:
                if link not in links:
                    yield f"never_checked: {link!r} has no capsule (valid: {', '.join(links)})"
        for one, other in combinations(links, 2):
            pair = frozenset((one, other))
            count = excused.count(pair) + (pair in checked)
            if count != 1:
                yield (
                    f"expected {one} and {other} in checked_pairs or once in never_checked, "
                    f"got them {'in neither' if count == 0 else 'more than once'}"
                )

    def _links(self, first: int, second: int) -> frozenset[str]:
        return frozenset((self.capsules[first].link, self.capsules[second].link))


def load_capsules(robot: RobotManifest) -> CapsuleFile:
    """The capsules that ``robot.yaml`` names.

    Raises:
        ConfigError: naming the file and everything in it that does not fit.
    """
    path = robot_dir(robot.id) / robot.capsules
    if not path.is_file():
        raise ConfigError(
            f"robot {robot.id}: no file {path}; make it with: fairlead robot capsules {robot.id}"
        )
    return load_yaml(path, CapsuleFile)
