"""Short forms of the campaigns; the long ones are ``python -m bench.soundness``."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from bench.equipment.case import Measured
from bench.equipment.kinematics import Kinematics
from bench.soundness import gate_loop
from bench.soundness.attacks import ON_A_BASE, attacks_on
from bench.soundness.checkpoint_vectors import TICKS, ask
from bench.soundness.episodes import episode
from bench.soundness.gate_loop import GateLoop
from bench.soundness.kinematic_campaign import KinematicCampaign
from bench.soundness.results import Amount, run
from bench.soundness.simulated_campaign import SimulatedCampaign
from fairlead.paths import gate_config
from fairlead_tools.measure.driven_robot import DrivenRobot, Moment, Tick

Loop = GateLoop[DrivenRobot]
PATH_CODES = {24, 26, 30, 31, 32, 33, 34}
MALFORMED = set(range(1, 13))


def silent(what: str) -> None:
    """Nobody waits for it."""


@pytest.mark.processes
def test_the_fixed_arm_stays_where_it_may_be_and_its_demonstration_is_released() -> None:
    found = run("panda", Amount(chunks=240, rows=60, episodes=1), silent)
    assert found.kinematic.chunks == 240 and found.kinematic.rows > 500
    assert not found.kinematic.breaches, found.kinematic.told
    assert PATH_CODES & {*found.kinematic.refused, *found.kinematic.truncated}
    assert not found.simulated.breaches, found.simulated.told
    usability = found.usability
    assert usability.chunks > 1 and usability.succeeded == 1
    assert not (usability.refused or usability.truncated or usability.cut), usability.told
    assert not usability.stops, usability.told


@pytest.mark.processes
@pytest.mark.parametrize("robot", ["ur5e", "kinova3", "so101"])
def test_arms_of_five_to_seven_joints_do_so_too(robot: str) -> None:
    found = run(robot, Amount(chunks=60, rows=20, episodes=2), silent)
    assert found.kinematic.rows > 300 and not found.kinematic.not_reached
    assert not found.kinematic.breaches, found.kinematic.told
    assert not found.simulated.breaches, found.simulated.told
    usability = found.usability
    assert (usability.chunks > 4, usability.succeeded) == (True, 2)
    assert not (usability.refused or usability.truncated or usability.cut), usability.told
    assert not usability.stops, usability.told


def campaign(robot: str, config: Path | None = None) -> KinematicCampaign:
    driven = DrivenRobot(robot)
    seen = list(islice(episode(driven, 0), 20))
    around = np.stack([tick.before.positions for tick in seen])
    return KinematicCampaign(driven.robot, [tick.commands for tick in seen], around, config)


@pytest.mark.processes
def test_two_arms_stay_clear_of_each_other() -> None:
    two_arms = campaign("dual_panda")
    found = two_arms.run(120, silent)
    assert found.rows > 200 and found.by_kind["side by side"] > 10
    assert found.worst["self-collision"] > two_arms.arena.clearance - 1e-3
    assert found.in_realtime > 50 and found.rows - found.in_realtime > 50
    assert not found.breaches, found.told


@pytest.mark.processes
@pytest.mark.simulator
def test_the_mobile_robot_stays_where_it_may_be() -> None:
    found = campaign("panda_mobile").run(120, silent)
    assert found.rows > 200
    assert found.in_realtime > 50 and found.rows - found.in_realtime > 50
    assert not found.breaches, found.told


@pytest.mark.processes
def test_a_gate_whose_bounds_are_too_wide_is_noticed(tmp_path: Path) -> None:
    file = json.loads(gate_config("panda", "sim").read_text())
    for joint in file["joints"]:
        joint["bounds"]["lower"] -= 1.0
        joint["bounds"]["upper"] += 1.0
    wide = tmp_path / "gate.sim.json"
    wide.write_text(json.dumps(file))
    assert campaign("panda", wide).run(120, silent).breaches["bounds"] > 0


@pytest.mark.processes
def test_a_gate_whose_joints_may_be_too_fast_is_noticed(tmp_path: Path) -> None:
    file = json.loads(gate_config("ur5e", "sim").read_text())
    for joint in file["joints"]:
        if joint["velocity_limit"]:
            joint["velocity_limit"] *= 2.0
    fast = tmp_path / "gate.sim.json"
    fast.write_text(json.dumps(file))
    assert campaign("ur5e", fast).run(120, silent).breaches["joint speed"] > 0


@pytest.mark.processes
def test_a_gate_that_takes_what_still_brakes_for_standing_is_noticed(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stands: list[Moment] = []
    next_tick, measured = GateLoop._next, gate_loop._measured

    def note_hold(loop: GateLoop[Any], done: Tick, is_heard: bool = True) -> None:
        if done.commands:
            stands.clear()
        elif not stands:
            stands.append(done.before)
        next_tick(loop, done, is_heard)

    def as_the_hold_began(now: Moment, tick: int) -> Measured:
        if tick == 1:
            stands.clear()
        told = measured(stands[0] if stands else now, tick)
        if stands:
            told.velocities[:] = 0.0
        return told

    monkeypatch.setattr(GateLoop, "_next", note_hold)
    monkeypatch.setattr(gate_loop, "_measured", as_the_hold_began)
    found = campaign("panda").run(480, silent)
    assert found.after_hold > 500
    assert found.breaches["bounds"] > 0
    later = re.compile(r"in realtime(, stuck)?, then chunk")
    assert all(later.search(line) for line in found.told), found.told


@pytest.fixture(scope="module")
def fixed_arm() -> Iterator[Loop]:
    loop = GateLoop(DrivenRobot("panda"))
    yield loop
    loop.close()


@pytest.fixture(scope="module")
def two_arms() -> Iterator[Loop]:
    loop = GateLoop(DrivenRobot("dual_panda"))
    yield loop
    loop.close()


@pytest.mark.processes
def test_a_robot_beyond_its_box_is_noticed_in_the_simulator(
    fixed_arm: Loop,
) -> None:
    volume = fixed_arm.file["workspace"]["volumes"][0]
    before = volume["lower"]
    volume["lower"] = [0.0, 0.0, 1.0]
    found = SimulatedCampaign(fixed_arm).run(20, silent)
    volume["lower"] = before
    assert found.breaches["workspace"] > 0
    assert found.told[0].startswith("panda random 0: tick ")


@pytest.mark.processes
def test_a_joint_beyond_its_speed_is_noticed_and_named(two_arms: Loop) -> None:
    campaign = SimulatedCampaign(two_arms)
    campaign._fastest[:] = 0.01
    campaign.episode("full-scale", 3, most_ticks=20)
    assert campaign.found.breaches["joint speed"] > 0
    assert "_joint" in campaign.found.told[0]


@pytest.mark.processes
def test_an_episode_is_the_same_again(fixed_arm: Loop) -> None:
    first, again = SimulatedCampaign(fixed_arm), SimulatedCampaign(fixed_arm)
    for one in (first, again):
        one.episode("full-scale", 7, most_ticks=40)
    assert first.found == again.found
    assert first.found.rows > 10


@pytest.mark.processes
@pytest.mark.parametrize("robot", ["panda", "dual_panda"])
def test_every_attack_gets_rows_through_and_none_that_cannot_be_read(
    robot: str, fixed_arm: Loop, two_arms: Loop
) -> None:
    loop = fixed_arm if robot == "panda" else two_arms
    for attack in attacks_on(loop.driven.robot):
        campaign = SimulatedCampaign(loop)
        campaign.episode(attack, 1, most_ticks=12)
        found = campaign.found
        assert found.rows > 0, attack
        assert not {*found.refused, *found.truncated} & MALFORMED, (attack, found.refused)


@pytest.fixture(scope="module")
def mobile() -> Iterator[Loop]:
    loop = GateLoop(DrivenRobot("panda_mobile"))
    yield loop
    loop.close()


@pytest.mark.processes
@pytest.mark.simulator
@pytest.mark.parametrize(
    ("attack", "seed", "most_ticks"),
    [
        ("base-cycles", 1, 120),
        ("base-cycles", 4, 160),
        ("base-cycles", 580059, 100),  # at tick 88, where a hold pulls a pushed arm back fast
        ("full-scale", 3, 40),
        ("full-scale", 20442046, 200),  # at tick 191, a wrist faster than its goals asked
        ("switch-up", 10006, 20),
        ("flicker", 1, 40),
    ],
)
def test_episodes_that_broke_a_rule_once_do_not(
    mobile: Loop, attack: str, seed: int, most_ticks: int
) -> None:
    campaign = SimulatedCampaign(mobile)
    campaign.episode(attack, seed, most_ticks=most_ticks)
    assert campaign.found.rows > 0
    assert not campaign.found.breaches, campaign.found.told


@pytest.mark.processes
@pytest.mark.simulator
@pytest.mark.parametrize("beyond", [0.5, 1.5])
def test_what_was_executed_is_held_against_the_declared_box_not_the_gates_smaller_one(
    mobile: Loop, beyond: float
) -> None:
    """The tool beyond the gate's edge by a share of the margin: the declared one is further."""
    robot, now = mobile.driven.robot, mobile.driven.reset(0)
    margin_m = robot.profile("sim").workspace.margin_m
    kinematics = Kinematics(robot.description_path(), robot.measured_joint_names)
    place, _ = kinematics.pose(now.positions, "grip_site", robot.base_frame)
    box = mobile.file["workspace"]["volumes"][0]
    before = box["lower"]
    box["lower"] = [float(place[0]) + beyond * margin_m, *before[1:]]
    rooms = SimulatedCampaign(mobile)._rooms(now.positions, now.velocities)
    box["lower"] = before
    assert margin_m > 0.0
    assert rooms["workspace"] == pytest.approx((1.0 - beyond) * margin_m, abs=1e-9)


@pytest.mark.thorough
@pytest.mark.processes
@pytest.mark.simulator
def test_attacks_with_a_base_and_its_switch_get_rows_through(
    mobile: Loop,
) -> None:
    for attack in ON_A_BASE:
        campaign = SimulatedCampaign(mobile)
        campaign.episode(attack, 2, most_ticks=10)
        found = campaign.found
        assert found.rows > 0, attack
        assert not {*found.refused, *found.truncated} & MALFORMED, (attack, found.refused)


@pytest.mark.thorough
@pytest.mark.processes
@pytest.mark.simulator
def test_random_vectors_of_a_third_of_full_scale_get_through_while_the_switch_flickers(
    mobile: Loop,
) -> None:
    gentle, hard = (ask(mobile, scale, [0]) for scale in (0.3, 1.0))
    assert gentle.rows + gentle.held >= TICKS - 1
    assert gentle.refused <= gentle.chunks // 5
    assert gentle.rows > hard.rows > 0
    assert gentle.refused < hard.refused


@pytest.mark.processes
def test_two_arms_that_chase_each_other_have_a_claim_each(
    two_arms: Loop,
) -> None:
    campaign = SimulatedCampaign(two_arms)
    campaign.episode("chase", 2, most_ticks=30)
    assert campaign.found.chunks > campaign.found.rows > 10
