"""Policies behind servers: what is asked and answered; a real worker process, real sockets."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from fairlead.errors import ConfigError
from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from tests.runner.asked_policies import (
    PI05,
    RLDX,
    ROWS,
    Ask,
    bits,
    observation,
)
from tests.runner.policy_servers import (
    ANSWERS,
    OpenpiServer,
    RldxServer,
    openpi_actions,
    read_npy,
    read_openpi_array,
    rldx_actions,
    rldx_rows,
)

pytestmark = pytest.mark.processes


@pytest.mark.asyncio
async def test_openpi_server_gets_state_prompt_and_pictures_and_its_rows_come_back_bit_for_bit(
    openpi: Callable[[ANSWERS], OpenpiServer], worker: Ask
) -> None:
    server = openpi(lambda request, n: openpi_actions(ROWS))
    asked = worker(PI05, server.address)
    await asked.load()
    await asked.reset()
    seen = observation(load_skill(PI05))
    assert bits(await asked.infer(seen)) == ROWS.tobytes()
    warm_up, request = server.requests
    np.testing.assert_array_equal(
        read_openpi_array(warm_up["observation/state"]), np.full(16, 0.5, np.float32)
    )
    assert request.keys() == {"observation/state", "prompt", *seen.images}
    assert request["prompt"] == "put it there"
    np.testing.assert_array_equal(
        read_openpi_array(request["observation/state"]), seen.state.astype(np.float32)
    )
    for name, image in seen.images.items():
        np.testing.assert_array_equal(read_openpi_array(request[name]), image)
    assert server.connections == 2, "one for the warm-up, one for the episode"


@pytest.mark.asyncio
async def test_openpi_rows_of_float64_are_taken_as_float32(
    openpi: Callable[[ANSWERS], OpenpiServer], worker: Ask
) -> None:
    server = openpi(lambda request, n: openpi_actions(ROWS.astype(np.float64)))
    asked = worker(PI05, server.address)
    await asked.load()
    assert bits(await asked.infer(observation(load_skill(PI05)))) == ROWS.tobytes()


@pytest.mark.asyncio
async def test_rldx_server_gets_named_arrays_and_its_named_outputs_become_one_vector(
    rldx: Callable[[ANSWERS], RldxServer], worker: Ask
) -> None:
    rows = ROWS.copy()
    rows[:, 6] = [0.0, 0.49, 0.5, 1.0]  # probabilities of closed
    rows[:, 11] = [1.0, 0.6, 0.4, 0.0]
    server = rldx(lambda request, n: rldx_actions(rldx_rows(rows)))
    asked = worker(RLDX, server.address)
    await asked.load()
    await asked.reset()
    seen = observation(load_skill(RLDX))
    assert bits(await asked.infer(seen)) == rows.tobytes()
    await asked.infer(seen)
    _, first, second = server.requests
    state = seen.state.astype(np.float32)
    ranges = {"end_effector_position_relative": slice(0, 3), "base_position": slice(7, 10),
              "end_effector_rotation_relative": slice(3, 7), "base_rotation": slice(10, 14),
              "gripper_qpos": slice(14, 16)}  # fmt: skip
    for name, part in ranges.items():
        array = read_npy(first["observation"][f"state.{name}"])
        assert array.dtype == np.float32
        np.testing.assert_array_equal(array, state[None, None, part])
    for name, image in seen.images.items():
        array = read_npy(first["observation"][f"video.{name}"])
        assert array.shape == (1, 4, *image.shape)
        np.testing.assert_array_equal(array, seen.frames_of(name)[None])
    assert first["observation"]["annotation.human.task_description"] == ["put it there"]
    assert [r["options"]["reset_memory"] for r in (first, second)] == [[True], [False]]
    assert first["options"]["session_ids"] == second["options"]["session_ids"]
    assert server.resets == [{"session_ids": first["options"]["session_ids"]}]
    await asked.reset()
    await asked.infer(seen)
    third = server.requests[-1]
    assert third["options"] == first["options"], "another episode of the same session"


@pytest.mark.parametrize(
    ("skill_id", "options", "text"),
    [
        (PI05, {"address": "127.0.0.1:8000"},
         "openpi policy: 1 problem(s):\n  address: String should match"),
        (PI05, {"answer_timeout_s": 5.0},
         "openpi policy: answer_timeout_s: expected less than the skill's inference_timeout_s, "
         "5 s, got 5 s"),
        (RLDX, {"address": "ws://127.0.0.1:1"},
         "rldx policy: 1 problem(s):\n  address: String should match"),
        (RLDX, {"state": {"all": [0, 14]}},
         "rldx policy: state: expected every index of 0..15 once, got indices [0, 1, 2, 3, 4"),
        (RLDX, {"actions": [{"name": "a", "width": 11}]},
         "rldx policy: actions: expected 12 numbers in all, got 11"),
        (RLDX, {"start": ""},
         "rldx policy: 1 problem(s):\n  start: String should have at least 1 character"),
    ],
)  # fmt: skip
def test_options_that_do_not_fit_are_named(
    skill_id: str, options: dict[str, Any], text: str
) -> None:
    skill = load_skill(skill_id)
    policy = OpenpiPolicy if skill_id == PI05 else RldxZmqPolicy
    with pytest.raises(ConfigError) as caught:
        policy.from_options(skill, skill.policy.options | options)
    assert text in str(caught.value)


def test_a_server_that_takes_bytes_alone_is_given_no_picture_of_other_numbers() -> None:
    skill = load_skill(RLDX)
    name, spec = next(iter(skill.images.items()))
    images = {**skill.images, name: spec.model_copy(update={"dtype": "float32_unit"})}
    seeing = skill.model_copy(update={"images": images})
    with pytest.raises(ConfigError) as caught:
        RldxZmqPolicy.check_options(seeing, skill.policy.options)
    assert str(caught.value) == (
        f"rldx policy: images.{name}: expected dtype uint8, axes hwc, got float32_unit, hwc"
    )
