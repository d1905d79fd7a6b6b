"""A robot's capsules from its geometry, the pairs that are kept apart, and the file of both."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from fairlead.errors import ConfigError, expected
from fairlead.messages import FloatArray
from fairlead.robot.capsule_distance import capsule_spans, pair_distances
from fairlead.robot.capsules import MAX_CAPSULES, MAX_PAIRS, Capsule
from fairlead.robot.description import DescriptionTree, description_tree
from fairlead.robot.gate_geometry import check_bare_links, is_swept
from fairlead.robot.link_poses import Poses, link_poses
from fairlead.robot.manifest import RobotManifest
from fairlead_tools.record.capsule_picture import RoundedHull
from fairlead_tools.shape.capsule_pairs import CapsulePair, PairRule, find_pairs, links_apart
from fairlead_tools.shape.convex_part import ConvexPart
from fairlead_tools.shape.fit import Fitted, fit_capsules, sticking_out
from fairlead_tools.shape.geometry import Geometry, GeometrySource, with_swept_fingers

_DIGITS = 4  # of lengths in m
_MOST_RADIUS_M = 2.0
_ROUNDING_M = 1e-9


@dataclass(frozen=True)
class RobotShape:
    """A robot and where its geometry comes from.

    say: gets a line of progress now and then.
    """

    robot: RobotManifest
    source: GeometrySource
    say: Callable[[str], None] = lambda line: None

    @cached_property
    def tree(self) -> DescriptionTree:
        """The links of its description."""
        return description_tree(self.robot)

    @cached_property
    def geometry(self) -> Geometry:
        """Pieces of each link, fingers given to what carries them."""
        return with_swept_fingers(self.robot, self.tree, self.source.geometry())

    def check_bare_links(self) -> None:
        """Whether robot.yaml says why of each link without geometry.

        Raises:
            ConfigError: naming each of which it does not.
        """
        who = f"robot capsules: {self.source.name}"
        check_bare_links(self.robot, self.tree, self.geometry, who)

    def fitted(self, most_per_link: int) -> tuple[Capsule, ...]:
        """Capsules around every link.

        Raises:
            ConfigError: more of them than the gate has room for.
        """
        found = tuple(
            _capsule(link, fit)
            for link, pieces in self._one_by_one()
            for fit in fit_capsules(pieces, most_per_link)
        )
        if len(found) > MAX_CAPSULES:
            raise ConfigError(
                f"robot capsules: expected at most {MAX_CAPSULES} capsules, got {len(found)}; "
                "lower --max-per-link"
            )
        return found

    def _one_by_one(self) -> Iterator[tuple[str, Sequence[ConvexPart]]]:
        for number, (link, pieces) in enumerate(self.geometry.items(), start=1):
            self.say(f"capsules of link {number} of {len(self.geometry)}: {link}")
            yield link, pieces

    def uncovered(self, capsules: Sequence[Capsule]) -> list[str]:
        """Links whose geometry reaches out of their capsules, with how far."""
        problems = []
        for link, pieces in self.geometry.items():
            own = [_fitted(one) for one in capsules if one.link == link]
            out = max(sticking_out(piece, own) for piece in pieces)
            if out > _ROUNDING_M:
                problems.append(f"{link} reaches {out:.4f} m out of its capsules")
        return problems

    def pairs(self, capsules: Sequence[Capsule], rule: PairRule) -> list[CapsulePair]:
        """Every pair of capsules on different links.

        Raises:
            ConfigError: more checked pairs than the gate has room for.
        """
        found = find_pairs(self.robot, self.tree, capsules, rule, self._links_apart, self.say)
        checked = sum(not pair.why_not for pair in found)
        if checked > MAX_PAIRS:
            raise ConfigError(
                f"robot capsules: expected at most {MAX_PAIRS} pairs, got {checked}; lower "
                "--max-per-link, or leave out those that are never near with --drop-margin-m"
            )
        return found

    def rest_distances(
        self, capsules: Sequence[Capsule], pairs: Sequence[CapsulePair]
    ) -> list[float]:
        """Distance of each pair where the robot rests [m]."""
        return self.least_distances(capsules, pairs, self.rest())

    def rest(self) -> dict[str, FloatArray]:
        """Joint positions at rest, shape ``[1]``.

        Those of ``home`` in robot.yaml, else the model's, else the nearest possible to 0.
        """
        found, home = {}, {} if self.robot.home is None else self.robot.home.positions
        for link in self.tree.links:
            if link.joint is not None:
                joint = self.robot.joint(link.joint)
                near = min(max(0.0, joint.lower), joint.upper) if joint.has_bounds else 0.0
                modelled = self.source.rest.get(link.joint, near)
                found[link.joint] = np.array([home.get(link.joint, modelled)])
        return found

    def least_distances(
        self,
        capsules: Sequence[Capsule],
        pairs: Sequence[CapsulePair],
        positions: Mapping[str, FloatArray],
    ) -> list[float]:
        """Smallest distance of each pair over joint positions ``[n]`` each [m]."""
        spans = capsule_spans(capsules, link_poses(self.tree, positions))
        return [
            float(pair_distances(capsules, spans, one.first, one.second).min()) for one in pairs
        ]

    def drawn(self, capsules: Sequence[Capsule]) -> tuple[list[RoundedHull], list[RoundedHull]]:
        """Pieces and capsules where they are at rest, for a picture."""
        poses = link_poses(self.tree, self.rest())
        pieces = [
            RoundedHull(link, _moved(poses[link], piece.points), piece.radius)
            for link, some in self.geometry.items()
            for piece in some
        ]
        around = [
            RoundedHull(
                one.link, _moved(poses[one.link], np.array([one.a_m, one.b_m])), one.radius_m
            )
            for one in capsules
        ]
        return pieces, around

    def _links_apart(self, poses: Mapping[str, Poses], first: str, second: str) -> FloatArray:
        return links_apart(
            self.source, poses, self._with_fingers(first), self._with_fingers(second)
        )

    def _with_fingers(self, link: str) -> list[str]:
        found = [link]
        for one in self.tree.links:
            if one.parent in found and is_swept(self.robot, self.tree, one):
                found.append(one.name)
        return found


def _capsule(link: str, fit: Fitted) -> Capsule:
    if fit.radius > _MOST_RADIUS_M:
        raise ConfigError(
            expected(
                f"link {link!r}: its shape", f"metres, at most {_MOST_RADIUS_M:g} m to each side",
                f'{fit.radius:.3g} m; of a mesh in mm: scale="0.001 0.001 0.001"',
            )
        )  # fmt: skip
    (ax, ay, az), (bx, by, bz) = (
        [round(float(value), _DIGITS) for value in end] for end in (fit.a, fit.b)
    )
    radius_m = round(fit.radius, _DIGITS)
    return Capsule(link=link, a_m=(ax, ay, az), b_m=(bx, by, bz), radius_m=radius_m)


def _moved(poses: Poses, points: FloatArray) -> FloatArray:
    """Points ``[n, 3]`` of a frame in its one pose."""
    return np.asarray(points @ poses.rotation[0].T + poses.translation[0])


def _fitted(capsule: Capsule) -> Fitted:
    return Fitted(np.array(capsule.a_m), np.array(capsule.b_m), capsule.radius_m)
