"""RLDX and GR00T servers of several releases: told apart, and held against the skill, at load.

The servers here are small ones of ours. Their bytes are as `tests/peers` found those of the real
ones to be, which are run there unchanged.
"""

from __future__ import annotations

import io
import json
import math
from collections.abc import Callable, Iterator
from typing import Any

import msgspec
import numpy as np
import pytest

from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.remote.rldx_wire import decode
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from tests.runner.asked_policies import (
    FITTING,
    LANGUAGE,
    RLDX,
    ROWS,
    STATES,
    failure,
    observation,
)
from tests.runner.policy_servers import (
    ANSWERS,
    RLDX_SHARES,
    Array,
    RldxServer,
    modality_config,
    npy,
    read_npy,
    rldx_actions,
    rldx_rows,
)

pytestmark = pytest.mark.processes

SKILL = load_skill(RLDX)


def saved(array: Array) -> bytes:
    file = io.BytesIO()
    np.save(file, array, allow_pickle=True)
    return file.getvalue()


PICKLED, GOOD_NPY = saved(np.array([None])), saved(np.zeros(2))
NEWER = "__ModalityConfig__"


def nd(array: Array) -> dict[bytes, Any]:
    """An array as msgpack-numpy writes it."""
    return {b"nd": True, b"type": array.dtype.str, b"kind": b"", b"shape": array.shape,
            b"data": array.tobytes()}  # fmt: skip


Load = Callable[[RldxServer, Any], RldxZmqPolicy]


@pytest.fixture
def asked() -> Iterator[Load]:
    """Loads a policy whose server answers with a config."""
    made: list[RldxZmqPolicy] = []

    def load(server: RldxServer, config: Any) -> RldxZmqPolicy:
        server.config = config
        options = SKILL.policy.options | {"address": server.address}
        made.append(RldxZmqPolicy.from_options(SKILL, options))
        return made[-1]

    yield load
    for policy in made:
        policy._link.close()


@pytest.fixture
def server(rldx: Callable[[ANSWERS], RldxServer]) -> RldxServer:
    return rldx(lambda request, n: rldx_actions(rldx_rows(ROWS)))


def test_a_server_that_wants_and_gives_what_the_skill_has_is_taken(
    server: RldxServer, asked: Load, capfd: pytest.CaptureFixture[str]
) -> None:
    policy = asked(server, modality_config(**FITTING))
    assert policy.infer(observation(SKILL)).tobytes() == ROWS.tobytes()
    said = capfd.readouterr().err
    assert (
        f"{server.address} speaks as RLDX-1, GR00T N1.6 or N1.7 at its release; it tells " in said
    )
    assert "its modalities: video, state, action, language; asked with a probe" in said
    assert "it gave [4, 12] after " in said


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({"video": [0]},
         "images: it wants frames at deltas [0], robot0_agentview_left has [-6, -4, -2, 0]"),
        ({"pictures": ["res256_image_side_0"]},
         "images: it wants res256_image_side_0, the skill has robot0_agentview_left, "
         "robot0_agentview_right, robot0_eye_in_hand"),
        ({"state": [*STATES, "joint_position"]},
         f"policy.options.state: it wants {', '.join(STATES)}, joint_position, the skill has "),
        ({"actions": list(RLDX_SHARES)[:4]},
         "policy.options.actions: it gives end_effector_position, end_effector_rotation, "
         "gripper_close, base_motion, the skill has end_effector_position, "),
        ({"horizon": 17}, "horizon: it gives 17 rows, the skill takes 16"),
        ({"language": "task"},
         f"policy.options.language_key: it wants task, got {LANGUAGE}"),
    ],
)  # fmt: skip
def test_a_server_of_another_policy_is_refused_at_load_with_every_difference(
    server: RldxServer, asked: Load, change: dict[str, Any], problem: str
) -> None:
    text = failure(lambda: asked(server, modality_config(**(FITTING | change))))
    assert text.startswith(f"rldx policy: {server.address} does not serve this skill's policy:\n  ")
    assert problem in text
    assert server.requests == [], "it is not even asked"


@pytest.mark.parametrize("deltas", [[0, 2, 4, 6], [1, 2, 3, 4]])
def test_rows_of_other_times_than_one_a_period_are_refused(
    deltas: list[int], server: RldxServer, asked: Load
) -> None:
    config = modality_config(**FITTING)
    config["action"]["as_json"]["delta_indices"] = deltas
    said = failure(lambda: asked(server, config))
    assert f"rate_hz: it gives rows at deltas {deltas}, the skill takes one for each" in said


def test_states_of_the_past_which_no_skill_sends_are_refused(
    server: RldxServer, asked: Load
) -> None:
    config = modality_config(**FITTING)
    config["state"]["as_json"]["delta_indices"] = [-1, 0]
    assert "state_contract: it wants states at deltas [-1, 0], a skill sends the newest" in failure(
        lambda: asked(server, config)
    )


@pytest.mark.parametrize("config", [None, {}])
def test_what_a_server_does_not_tell_is_asked_by_a_probe_and_said(
    server: RldxServer, asked: Load, config: Any, capfd: pytest.CaptureFixture[str]
) -> None:
    asked(server, config)
    assert len(server.requests) == 1
    assert "it tells of its modalities: nothing; asked with a probe obs" in capfd.readouterr().err


def test_a_config_that_is_none_is_a_typed_error(server: RldxServer, asked: Load) -> None:
    for config, text in [
        ([1], "expected a map of modalities, got list"),
        ({"video": 7}, "modality video: Expected `object`, got `int`"),
        ({"video": {"as_json": "{"}}, "modality video: Input data was truncated"),
        ({"video": {"as_json": {"delta_indices": [0]}}}, "missing required field `modality_keys`"),
    ]:
        assert text in failure(lambda config=config: asked(server, config))  # type: ignore[misc]


def test_gr00t_n1_7_gets_and_sends_arrays_as_msgpack_numpy_writes_them(
    rldx: Callable[[ANSWERS], RldxServer], asked: Load, capfd: pytest.CaptureFixture[str]
) -> None:
    def answers(request: Any, number: int) -> bytes:
        named = {f"action.{name}": nd(rows[None]) for name, rows in rldx_rows(ROWS).items()}
        return msgspec.msgpack.encode([named, {"took": {b"nd": False, b"type": "<f8",
                                                        b"data": bytes(8)}}])  # fmt: skip

    server = rldx(answers)
    policy = asked(server, modality_config(**FITTING, marker=NEWER))
    policy.reset()
    seen = observation(SKILL)
    assert policy.infer(seen).tobytes() == ROWS.tobytes()
    request = server.requests[-1]["observation"]
    for name in seen.images:
        packed = request[f"video.{name}"]
        frames = np.frombuffer(packed[b"data"], packed[b"type"]).reshape(packed[b"shape"])
        np.testing.assert_array_equal(frames, seen.frames_of(name)[None])
        assert (packed[b"nd"], packed[b"kind"]) == (True, b"")
    assert request["state.gripper_qpos"][b"shape"] == [1, 1, 2]
    assert "speaks as GR00T N1.7 after 3df8b38" in capfd.readouterr().err


def test_gr00t_n1_5_gets_the_observation_itself_and_answers_with_the_map_alone(
    rldx: Callable[[ANSWERS], RldxServer],
    asked: Load,
) -> None:
    def answers(request: Any, number: int) -> bytes:
        named = {f"action.{name}": npy(rows) for name, rows in rldx_rows(ROWS).items()}
        return msgspec.msgpack.encode(named)

    server = rldx(answers)
    told = {
        kind: {"__ModalityConfig_class__": True, "as_json": json.dumps(
            {"delta_indices": entry["as_json"]["delta_indices"],
             "modality_keys": [name if kind == "language" else f"{kind}.{name}"
                               for name in entry["as_json"]["modality_keys"]]})}
        for kind, entry in modality_config(**FITTING).items()
    }  # fmt: skip
    policy = asked(server, told)
    policy.reset()
    seen = observation(SKILL)
    assert policy.infer(seen).tobytes() == ROWS.tobytes()
    assert server.resets == [], "it has no such endpoint"
    request = server.requests[-1]
    assert request[LANGUAGE] == ["put it there"]
    assert read_npy(request["state.gripper_qpos"]).shape == (1, 2)
    for name in seen.images:
        np.testing.assert_array_equal(read_npy(request[f"video.{name}"]), seen.frames_of(name))


@pytest.mark.parametrize(
    ("packed", "text"),
    [
        ({b"nd": True, b"type": "|O", b"kind": b"O", b"shape": [1], b"data": b"\x80\x04."},
         "an array of |O"),
        ({b"nd": True, b"type": [["a", "<f4"]], b"kind": b"V", b"shape": [1], b"data": bytes(4)},
         "an array without its type or data"),
        ({b"nd": True, b"type": "<f4", b"shape": [1]}, "an array without its type or data"),
        ({b"nd": True, b"type": "<f4", b"data": bytes(4)}, "an array without its shape"),
        ({b"nd": 1, b"type": "|O", b"kind": b"O", b"data": b"\x80\x04."}, "an array of |O"),
        ({b"nd": True, b"type": "<f4", b"shape": [9], b"data": bytes(4)}, "cannot reshape"),
        ({b"nd": True, b"type": "<f4", b"shape": [1.0], b"data": bytes(4)}, "'float' object"),
        ({b"nd": True, b"type": "<f4", b"shape": [math.inf], b"data": bytes(4)}, "'float' object"),
        ({b"nd": False, b"type": "<f4", b"data": b""}, "cannot reshape"),
        ({"__ndarray_class__": True, "as_npy": PICKLED}, "Object arrays cannot be loaded"),
        ({"__ndarray_class__": True, "as_npy": b"PK\3\4" + bytes(99)}, "the magic string is not"),
        ({"__ndarray_class__": True, "as_npy": GOOD_NPY.replace(b"{'", b"{{'")},
         "an array whose header is none"),
    ],
)  # fmt: skip
def test_an_array_that_is_none_or_would_be_unpickled_is_refused(packed: Any, text: str) -> None:
    with pytest.raises((ValueError, TypeError), match=text.replace("|", r"\|")):
        decode(msgspec.msgpack.encode(packed))


def test_a_server_that_was_started_anew_with_another_policy_is_refused_before_the_claim(
    server: RldxServer, asked: Load, rldx: Callable[[ANSWERS], RldxServer], closing: list[Any]
) -> None:
    policy = asked(server, modality_config(**FITTING))
    server.close()
    closing.remove(server)
    other = RldxServer(
        lambda request, n: rldx_actions(rldx_rows(ROWS)), int(server.address.rpartition(":")[2])
    )
    closing.append(other)
    other.config = modality_config(**(FITTING | {"video": [0]}))
    assert "it wants frames at deltas [0]" in failure(policy.reset)
