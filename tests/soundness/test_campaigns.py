"""Short forms of the campaigns; the long ones are ``python -m tests.soundness``."""

from __future__ import annotations

import json
from itertools import islice
from pathlib import Path

import numpy as np
import pytest

from bench.measure_limits.driven_robot import DrivenRobot
from bench.measure_limits.episodes import episode
from fairlead.paths import gate_config
from tests.soundness.kinematic_campaign import KinematicCampaign
from tests.soundness.lockstep_loop import LockstepLoop
from tests.soundness.results import Amount, run
from tests.soundness.simulated_campaign import SimulatedCampaign

PATH_CODES = {24, 30, 31, 32, 33, 34}


def silent(what: str) -> None:
    """Nobody waits for it."""


def test_the_fixed_arm_stays_where_it_may_be_and_its_demonstration_is_released() -> None:
    found = run("panda", Amount(chunks=240, rows=60, episodes=1), silent)
    assert found.kinematic.chunks == 240 and found.kinematic.rows > 500
    assert not found.kinematic.breaches, found.kinematic.told
    assert PATH_CODES & {*found.kinematic.refused, *found.kinematic.truncated}
    assert not found.simulated.breaches, found.simulated.told
    usability = found.usability
    assert usability.chunks >= 8 and usability.ticks == 60
    assert not (usability.refused or usability.truncated or usability.stops), usability.told


def campaign(robot: str, config: Path | None = None) -> KinematicCampaign:
    driven = DrivenRobot(robot)
    seen = list(islice(episode(driven, 0), 20))
    around = np.stack([tick.before.positions for tick in seen])
    return KinematicCampaign(driven.robot, [tick.commands for tick in seen], around, config)


def test_two_arms_stay_clear_of_each_other() -> None:
    found = campaign("dual_panda").run(120, silent)
    assert found.rows > 200
    assert not found.breaches, found.told


@pytest.mark.simulator
def test_the_mobile_robot_stays_where_it_may_be() -> None:
    found = campaign("panda_mobile").run(120, silent)
    assert found.rows > 200
    assert not found.breaches, found.told


def test_a_gate_whose_bounds_are_too_wide_is_noticed(tmp_path: Path) -> None:
    file = json.loads(gate_config("panda", "sim").read_text())
    for joint in file["joints"]:
        joint["bounds"]["lower"] -= 1.0
        joint["bounds"]["upper"] += 1.0
    wide = tmp_path / "gate.sim.json"
    wide.write_text(json.dumps(file))
    assert campaign("panda", wide).run(120, silent).breaches["bounds"] > 0


def test_a_robot_beyond_its_box_is_noticed_in_the_simulator() -> None:
    loop = LockstepLoop(DrivenRobot("panda"))
    try:
        loop.file["workspace"]["volumes"][0]["lower"] = [0.0, 0.0, 1.0]
        found = SimulatedCampaign(loop, []).run(20, silent)
    finally:
        loop.close()
    assert found.breaches["workspace"] > 0
    assert found.told
