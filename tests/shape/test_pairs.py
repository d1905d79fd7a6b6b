"""Which pairs of capsules are kept apart, and what is said of the others."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import coal
import numpy as np
import pytest

from fairlead.messages import FloatArray
from fairlead.robot.capsules import Capsule
from fairlead.robot.description import description_tree
from fairlead.robot.link_poses import Poses, link_poses
from fairlead.robot.manifest import load_robot
from fairlead_tools.shape.capsule_pairs import (
    CROWDED,
    CapsulePair,
    PairRule,
    find_pairs,
    links_apart,
)
from fairlead_tools.shape.convex_part import ConvexPart
from fairlead_tools.shape.geometry import geometry_source, with_swept_fingers
from tests.shape.own_robot import NAME, own_robot

RULE = PairRule(clearance_m=0.01, drop_margin_m=None, samples=10_000)


def ball(link: str, radius_m: float, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Capsule:
    return Capsule(link=link, a_m=at, b_m=at, radius_m=radius_m)


def pairs_of(
    capsules: list[Capsule], rule: PairRule = RULE, links_m: float = 1.0
) -> dict[tuple[int, int], CapsulePair]:
    """Pairs of panda's, with links that are always so far apart themselves."""
    robot = load_robot("panda")

    def apart(poses: Mapping[str, Poses], first: str, second: str) -> FloatArray:
        return np.full(len(poses[first].translation), links_m)

    found = find_pairs(robot, description_tree(robot), capsules, rule, apart, lambda line: None)
    return {(pair.first, pair.second): pair for pair in found}


def why_not(pairs: dict[tuple[int, int], CapsulePair]) -> dict[tuple[int, int], str]:
    return {place: pair.why_not for place, pair in pairs.items()}


def test_links_of_one_body_and_neighbours_are_left_out_with_the_reason() -> None:
    # base_link carries link0 rigidly, link7 carries the hand; a finger counts as the hand.
    links = ["base_link", "panda_link0", "panda_link1", "panda_link6", "panda_link7", "panda_hand"]
    found = why_not(pairs_of([ball(link, 0.001) for link in links]))
    assert found == {
        (0, 1): "fixed to each other",
        (0, 2): "joined by panda_joint1",
        (1, 2): "joined by panda_joint1",
        (3, 4): "joined by panda_joint7",
        (3, 5): "joined by panda_joint7",
        (4, 5): "fixed to each other",
        **dict.fromkeys(
            [(0, 3), (0, 4), (0, 5), (1, 3), (1, 4), (1, 5), (2, 3), (2, 4), (2, 5)], ""
        ),
    }


def test_two_capsules_of_a_link_are_no_pair() -> None:
    both = [ball("panda_link1", 0.1), ball("panda_link1", 0.1, (0.0, 0.0, 0.1))]
    assert pairs_of(both) == {}


def test_what_is_always_near_is_left_out_and_says_how_near() -> None:
    # The centres of links 1 and 3 are always 0.316 m apart: 0.011 m and 0.009 m remain.
    wide, wider = ball("panda_link3", 0.205), ball("panda_link3", 0.207)
    (kept,) = pairs_of([ball("panda_link1", 0.1), wide]).values()
    (left,) = pairs_of([ball("panda_link1", 0.1), wider]).values()
    assert (kept.why_not, kept.near_share) == ("", 0.0)
    assert kept.least_m == pytest.approx(0.011, abs=1e-9)
    assert left.why_not == "always nearer than 0.01 m (10000 poses)"
    assert left.least_m == pytest.approx(0.009, abs=1e-9)
    assert left.near_share == 1.0


def test_what_is_never_near_is_left_out_only_on_request() -> None:
    # 0.316 m less 0.2 m of radii: never nearer than 0.116 m.
    capsules = [ball("panda_link1", 0.1), ball("panda_link3", 0.1)]
    margins = {None: "", 0.107: "", 0.105: "never nearer than 0.115 m (10000 poses)"}
    for margin_m, reason in margins.items():
        (pair,) = pairs_of(capsules, PairRule(0.01, margin_m, 10_000)).values()
        assert pair.why_not == reason


def test_a_pair_that_is_near_all_day_goes_if_the_links_never_touch() -> None:
    crowded = [ball("panda_link0", 0.3), ball("panda_link4", 0.3)]
    (pair,) = pairs_of(crowded, links_m=0.001).values()
    assert CROWDED < pair.near_share < 1.0
    assert pair.why_not.startswith(f"capsules near in {pair.near_share:.0%} of 10000 poses")
    (pair,) = pairs_of(crowded, links_m=-0.001).values()
    assert pair.why_not == ""


def test_a_pair_that_is_near_now_and_then_stays() -> None:
    (pair,) = pairs_of([ball("panda_link0", 0.12), ball("panda_hand", 0.12)], links_m=1.0).values()
    assert 0.0 < pair.near_share < CROWDED
    assert pair.why_not == ""


def test_links_are_as_far_apart_as_coal_measures_it() -> None:
    robot = load_robot("panda")
    tree, source = description_tree(robot), geometry_source(robot, None)
    rng = np.random.default_rng(9)
    joints = [link.joint for link in tree.links if link.joint is not None]
    positions = {name: rng.uniform(robot.joint(name).lower, robot.joint(name).upper, 300)
                 for name in joints}  # fmt: skip
    poses = link_poses(tree, positions)
    ours = links_apart(source, poses, ["panda_link5"], ["panda_hand"])
    # panda.xml: a capsule from (0, 0, -0.25) to (0, 0.05, -0.08), a box around (0, 0, 0.03).
    a, b = np.array([0.0, 0.0, -0.25]), np.array([0.0, 0.05, -0.08])
    z = (b - a) / np.linalg.norm(b - a)
    turned = np.column_stack([[1.0, 0.0, 0.0], np.cross(z, [1.0, 0.0, 0.0]), z])
    shapes = coal.Capsule(0.055, float(np.linalg.norm(b - a))), coal.Box(0.06, 0.2, 0.06)
    theirs = []
    for i in range(300):
        five, hand = poses["panda_link5"], poses["panda_hand"]
        first = coal.Transform3s(
            five.rotation[i] @ turned, five.rotation[i] @ ((a + b) / 2) + five.translation[i]
        )
        second = coal.Transform3s(
            hand.rotation[i], hand.rotation[i] @ [0.0, 0.0, 0.03] + hand.translation[i]
        )
        request, result = coal.DistanceRequest(), coal.DistanceResult()
        theirs.append(coal.distance(shapes[0], first, shapes[1], second, request, result))
    apart = np.array(theirs) > 0.0
    assert 0.1 < apart.mean() < 1.0
    np.testing.assert_allclose(ours[apart], np.array(theirs)[apart], atol=1e-4)
    assert (ours[~apart] <= 1e-4).all()


def test_a_finger_that_slides_counts_from_one_end_to_the_other_in_the_hand() -> None:
    robot = load_robot("panda")
    tip = {"panda_rightfinger": [ConvexPart(np.array([[0.0, 0.0, 0.05]]), 0.01)]}
    ((link, (piece,)),) = with_swept_fingers(robot, description_tree(robot), tip).items()
    # From shut to 0.04 m out along -y, 0.0584 m up in the hand.
    assert link == "panda_hand"
    assert piece.radius == 0.01
    wanted = [[0.0, -0.04, 0.1084], [0.0, 0.0, 0.1084]]
    np.testing.assert_allclose(sorted(piece.points.tolist()), wanted, atol=1e-12)


def test_a_finger_that_turns_is_everywhere_it_can_be(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    slide = "type: prismatic\n    lower_m: 0.0\n    upper_m: 0.04\n    velocity_m_s: 0.05\n"
    turn = "type: revolute\n    lower_rad: 0.0\n    upper_rad: 1.5\n    velocity_rad_s: 0.05\n"
    folder = own_robot(
        tmp_path,
        monkeypatch,
        yaml=(
            slide + "    acceleration_m_s2: 10.0\n    effort_n: 20.0\n",
            turn + "    acceleration_rad_s2: 10.0\n    effort_nm: 20.0\n",
        ),
    )
    urdf = folder / "panda.urdf"
    old = '<joint name="panda_finger_joint1" type="prismatic">'
    text = urdf.read_text().replace(old, old.replace("prismatic", "revolute"))
    urdf.write_text(text.replace('upper="0.04"', 'upper="1.5"'))
    robot = load_robot(NAME)
    finger = ConvexPart(np.array([[0.01, 0.0, 0.0], [0.0, 0.0, 0.05]]))
    geometry = with_swept_fingers(robot, description_tree(robot), {"panda_leftfinger": [finger]})
    assert list(geometry) == ["panda_hand"]
    # It turns about the hand's y, 0.0584 m up: its tip is on an arc there.
    for angle in np.linspace(0.0, 1.5, 31):
        tip = np.array([0.05 * np.sin(angle), 0.0, 0.0584 + 0.05 * np.cos(angle)])
        near = [
            min(np.linalg.norm(p + s * (q - p) - tip) for p in one.points for q in one.points
                for s in np.linspace(0.0, 1.0, 21)) - one.radius
            for one in geometry["panda_hand"]
        ]  # fmt: skip
        assert min(near) <= 1e-4
