"""Recording in one process: the same bits as the episode that parity proves equal to a deployed."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError, PolicyError
from fairlead.messages import ResetEpisodeReply
from fairlead.paths import deployment_path
from fairlead.policy import Done, Observation
from fairlead.skill.manifest import load_skill
from fairlead_tools.learn import record as recording
from fairlead_tools.learn.record import Teacher, record
from fairlead_tools.parity import local_episode
from fairlead_tools.parity.local_episode import LocalEpisode, asked
from tests.learn.drawn import EXPERT
from tests.runner.broken_policies import (
    Doubles,
    Exits,
    Misbehaving,
    NotANumber,
    Raises,
    TooLong,
    WholeNumbers,
)

pytestmark = pytest.mark.simulator
DEPLOYMENT = load_deployment(deployment_path("panda_mobile_sim"))
RESET = ResetEpisodeReply(tick=2, episode_tick=1, held_ticks=1)


def test_a_recording_has_what_a_policy_in_one_process_sees_and_does_bit_for_bit() -> None:
    [one] = record(DEPLOYMENT, EXPERT, [5], 0.0, 16, lambda seed, tick: None)
    with closing(LocalEpisode(DEPLOYMENT, EXPERT, 5, RESET)) as local:
        assert local.act() and local.act()
        trace = local.trace
    assert [state.astype("<f8").tobytes() for state in one.states[::8]] == trace.observations
    assert [row.tobytes() for row in one.acted] == trace.packed[1:]
    assert not one.succeeded and len(one.states) == 16


def test_the_policy_that_a_deployment_has_for_a_skill_is_the_one_in_one_process() -> None:
    row = np.array([0.25] * 6 + [-1] + [0] * 4 + [-1], np.float32)
    constant = {"backend": "constant", "options": {"row": row.tolist()}}
    runner = DEPLOYMENT.services["runner"]
    options = runner.options | {"policies": {EXPERT.id: constant}}
    replaced = runner.model_copy(update={"options": options})
    services = DEPLOYMENT.services | {"runner": replaced}
    deployment = DEPLOYMENT.model_copy(update={"services": services})
    with closing(LocalEpisode(deployment, EXPERT, 5, RESET)) as local:
        assert local.act()
        assert local.trace.actions == [np.tile(row, (8, 1)).tobytes()]


def test_noise_moves_all_but_switches_and_is_the_seed_s() -> None:
    first, again = (
        next(record(DEPLOYMENT, EXPERT, [5], 0.4, 10, lambda seed, tick: None)) for _ in range(2)
    )
    assert first.acted.tobytes() == again.acted.tobytes()
    moved = (first.acted != first.rows).any(axis=0)
    assert moved.tolist() == [True] * 6 + [False] + [True] * 3 + [False] * 2
    assert np.abs(first.acted).max() <= 1


def test_a_skill_whose_cameras_the_deployment_lacks_is_refused_before_anything_starts() -> None:
    seen = load_skill("pi05-robocasa365-human300-nf4")
    with pytest.raises(ConfigError, match="needs camera 'robot0_agentview_left'"):
        next(record(DEPLOYMENT, seen, [5], 0.0, 16, lambda seed, tick: None))


@pytest.mark.parametrize(
    ("skill", "why"),
    [
        ("ur5e-tool-motion", "for every part; got others"),
        ("ur5e-reach", "does not offer arm joint_position"),
    ],
)
def test_rows_that_are_not_the_simulator_s_own_vector_are_refused(skill: str, why: str) -> None:
    deployment = load_deployment(deployment_path("ur5e_robosuite"))
    with pytest.raises(ConfigError, match="in its order and scale, for every part") as caught:
        next(record(deployment, load_skill(skill), [5], 0.0, 16, lambda seed, tick: None))
    assert why in str(caught.value)


SEEN = Observation(3, np.zeros(30), "")


def test_what_a_policy_returns_is_checked_as_in_a_deployment_and_kept() -> None:
    rows = asked("test", Doubles(EXPERT), EXPERT, SEEN)
    assert isinstance(rows, np.ndarray) and rows.dtype == np.float32
    policy = Misbehaving(EXPERT)
    rows = asked("test", policy, EXPERT, SEEN)
    policy.rows[:] = 9.0  # its own array, for the next answer
    assert isinstance(rows, np.ndarray) and not rows.any()
    assert isinstance(asked("test", Finishes(EXPERT), EXPERT, SEEN), Done)
    for kind, text in (
        (NotANumber, "finite float32 numbers, got nan in row 2 dimension 3"),
        (TooLong, r"expected actions as floats \[1 to 8, 12\], got float32 \[16, 12\]"),
        (WholeNumbers, "got int64"),
        (Raises, "skill oracle-counter-to-cabinet: infer failed in tick 3: ValueError: no such"),
        (Exits, "infer failed in tick 3: SystemExit: no token"),
    ):
        with pytest.raises(PolicyError, match=text):
            asked("test", kind(EXPERT), EXPERT, SEEN)


class Finishes(Misbehaving):
    def infer(self, observation: Observation) -> Done:  # type: ignore[override]
        return Done("it is there")


class CannotBegin(Misbehaving):
    def reset(self) -> None:
        raise ValueError("no such token")


def test_a_policy_that_fails_only_in_one_process_is_one_error(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(local_episode, "make_policy", lambda who, skill: Raises(skill))
    with (
        closing(LocalEpisode(DEPLOYMENT, EXPERT, 5, RESET)) as local,
        pytest.raises(PolicyError, match=r"^parity: skill .*: infer failed in tick 2: ValueE"),
    ):
        local.act()
    monkeypatch.setattr(recording, "make_policy", lambda who, skill: CannotBegin(skill))
    with pytest.raises(PolicyError, match="^dataset record: seed 5: reset failed: ValueError: no"):
        next(record(DEPLOYMENT, EXPERT, [5], 0.0, 16, lambda seed, tick: None))


def test_an_expert_whose_rows_mean_something_else_is_refused() -> None:
    teacher = Teacher(load_skill("oracle-reach-cube"))
    with pytest.raises(ConfigError, match="expected rate, horizon and action_contract of oracle-c"):
        next(record(DEPLOYMENT, EXPERT, [5], 0.0, 16, lambda seed, tick: None, teacher))
