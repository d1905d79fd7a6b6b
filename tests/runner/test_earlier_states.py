"""States at the deltas of a contract, as pictures have them: gathered, sent on, or missing."""

from __future__ import annotations

import msgspec
import numpy as np
import pytest

from fairlead.policy import Observation
from fairlead.skill.manifest import SkillManifest
from fairlead_skill_runner.observation_buffer import ObservationBuffer
from fairlead_skill_runner.policy_server import PolicyServer
from fairlead_skill_runner.policy_wire import Infer, decode_request, encode
from tests.runner.broken_policies import Misbehaving
from tests.runner.scripted_robot import SKILL, layout


def remembering(*deltas: int) -> SkillManifest:
    data = SKILL.model_dump(mode="json")
    data["state_contract"] |= {"deltas": deltas}
    return SkillManifest.model_validate(data)


def gathered(skill: SkillManifest, *ticks: int, periods: int = 1) -> ObservationBuffer:
    box = ObservationBuffer(skill, "pick", {}, exact=True, has_task=False, periods=periods)
    for tick in ticks:
        box.add_layout(layout(tick))
    return box


def test_states_are_those_at_the_deltas_in_rows_of_the_policy_and_reach_its_process() -> None:
    box = gathered(remembering(-2, -1, 0), *range(3, 9), periods=2)
    seen = box.gather().observation
    assert seen.states[:, 5].tolist() == [4, 6, 8]
    assert box.gather().oldest_tick == 8, "earlier states are as old as they are meant to be"
    request = decode_request(encode(Infer.of(seen)))
    assert isinstance(request, Infer)
    np.testing.assert_array_equal(request.observation().states, seen.states)


def test_without_deltas_there_is_the_state_of_now() -> None:
    seen = gathered(SKILL, 7, 8).gather().observation
    assert seen.states.shape == (1, 30)
    np.testing.assert_array_equal(Observation(1, seen.state, "").states, seen.states)


def test_before_the_first_state_of_a_goal_or_an_episode_there_is_that_one_again() -> None:
    box = gathered(remembering(-2, 0), 7)
    assert box.gather().observation.states[:, 0].tolist() == [7, 7]
    box.add_layout(msgspec.structs.replace(layout(8), episode_tick=8))
    assert box.gather().observation.states[:, 0].tolist() == [8, 8]


def test_a_state_that_was_lost_is_waited_for_and_never_made_up() -> None:
    box = gathered(remembering(-1, 0), 5, 7)
    assert box.missing(7) == "layout mobile_pick_30d of tick 6"
    box.add_layout(layout(6))
    assert box.missing(7) == "", "it came late"


def test_the_hash_of_a_skill_that_wants_none_is_what_it_was() -> None:
    assert remembering(0).skill_hash == SKILL.skill_hash != remembering(-1, 0).skill_hash
    assert "deltas" not in SKILL.state_contract.model_dump()


def test_a_client_of_serve_policy_sends_all_of_them() -> None:
    skill = remembering(-1, 0)
    server = PolicyServer(skill, Misbehaving(skill), ("state", "prompt"), None, print)
    states = np.arange(60.0).reshape(2, 30)
    seen = server._observation({"state": states}, 1)
    np.testing.assert_array_equal(seen.states, states)
    with pytest.raises(Exception, match="expected state as 2 x 30 finite numbers, got float64"):
        server._observation({"state": states[0]}, 1)
