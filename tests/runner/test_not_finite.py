"""A number that is none never becomes a command: from any backend, in any slot, of any mode."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from fairlead.errors import PolicyError
from fairlead.messages import floats
from fairlead.modes import ControlMode
from fairlead.plugins import POLICIES
from fairlead.policy import Observation, Policy
from fairlead.robot.manifest import load_robot
from fairlead.skill.action_contract import ActionContract
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead.skill.routes import Route, resolve_routes
from fairlead.skill.slots import FIELD_RULES
from fairlead_skill_runner.action_rows import policy_rows
from fairlead_skill_runner.candidate import dispatch
from fairlead_skill_runner.fitted_rows import fitted
from fairlead_skill_runner.policies.constant import ConstantPolicy
from fairlead_skill_runner.policies.go_to import GoToPolicy
from fairlead_skill_runner.policies.joint_reach import JointReachPolicy
from fairlead_skill_runner.policies.lerobot.policy import LerobotPolicy
from fairlead_skill_runner.policies.onnx import OnnxPolicy
from fairlead_skill_runner.policies.oracle.policy import OracleSteps
from fairlead_skill_runner.policies.oracle.reach_cube import ReachCubeOracle
from fairlead_skill_runner.policies.python_file import PythonFilePolicy
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from fairlead_skill_runner.policies.replay import ReplayPolicy
from fairlead_skill_runner.policy_wire import Answer, check_actions, pack_actions
from tests.runner.onnx_skill import install, poisonous
from tests.runner.policy_servers import (
    RLDX_SHARES,
    OpenpiServer,
    RldxServer,
    openpi_actions,
    rldx_actions,
    rldx_rows,
)

pytestmark = pytest.mark.processes

PI05, RLDX = "pi05-robocasa365-human300-nf4", "rldx1-ft-rc365-nf4"
DIM, HORIZON = 12, 4
NOT_FINITE = [np.nan, -np.nan, np.inf, -np.inf]
DTYPES = ["<f2", "<f4", "<f8", ">f8", "g", "O", "<i8", "?"]
FINITE = np.full((HORIZON, DIM), 0.25)


def poisoned(row: int, column: int, number: float, dtype: str) -> np.ndarray[Any, Any]:
    rows = FINITE.astype(object if dtype == "O" else float)
    rows[row, column] = number
    with np.errstate(all="ignore"):
        return rows.astype(dtype)


POISON = st.tuples(
    st.integers(0, HORIZON - 1),
    st.integers(0, DIM - 1),
    st.sampled_from([*NOT_FINITE, 1e308, -1e308, 3.5e38]),
    st.sampled_from(DTYPES[:6]),
)
"""What float16 and float32 cannot hold is infinite in them; float64 says it in full."""


@dataclass
class Servers:
    """One of each, both answering with ``rows``."""

    rows: np.ndarray[Any, Any] = field(default_factory=lambda: FINITE.astype(np.float32))

    def __post_init__(self) -> None:
        self.openpi = OpenpiServer(lambda request, n: openpi_actions(self.rows))
        self.rldx = RldxServer(lambda request, n: rldx_actions(rldx_rows(self.rows)))


@pytest.fixture(scope="module")
def servers() -> Iterator[Servers]:
    both = Servers()
    yield both
    both.openpi.close()
    both.rldx.close()


def seen(skill: SkillManifest) -> Observation:
    images = {name: np.zeros(spec.shape, spec.number_type) for name, spec in skill.images.items()}
    return Observation(1, np.full(skill.state_contract.dim, 0.5), "", images)


def released_to_gate(policy: Policy, skill: SkillManifest) -> np.ndarray[Any, Any]:
    """What the runner would dispatch of the policy's answer, as its two processes agree on it."""
    dim, horizon = skill.action_contract.dim, skill.horizon
    return check_actions(pack_actions(policy.infer(seen(skill)), dim, horizon), dim, horizon)


def refuses(policy: Policy, skill: SkillManifest) -> str:
    with pytest.raises(PolicyError) as caught:
        released_to_gate(policy, skill)
    return str(caught.value)


def made(skill_id: str, address: str) -> tuple[Callable[[], Policy], SkillManifest]:
    skill = load_skill(skill_id)
    backend: Any = {PI05: OpenpiPolicy, RLDX: RldxZmqPolicy}[skill_id]
    return lambda: backend.from_options(skill, skill.policy.options | {"address": address}), skill


@pytest.mark.parametrize("skill_id", [PI05, RLDX])
def test_a_server_s_number_that_is_none_is_a_typed_failure_in_every_dimension(
    servers: Servers, skill_id: str
) -> None:
    address = servers.openpi.address if skill_id == PI05 else servers.rldx.address
    make, skill = made(skill_id, address)

    @settings(max_examples=60, deadline=None)
    @given(POISON)
    def holds(poison: tuple[int, int, float, str]) -> None:
        if poison[3] in "Og":
            poison = (*poison[:3], "<f8")  # neither wire has them
        servers.rows = FINITE.astype(np.float32)
        policy = make()
        servers.rows = poisoned(*poison)
        text = refuses(policy, skill)
        assert "finite" in text, text

    holds()


def test_the_server_s_error_names_output_row_dimension_and_value(servers: Servers) -> None:
    make, skill = made(RLDX, servers.rldx.address)
    first = RLDX_SHARES["gripper_close"][0]
    for number, said in [(np.nan, "nan"), (1e308, "1e+308")]:
        servers.rows = FINITE.astype(np.float32)
        policy = make()
        servers.rows = poisoned(2, first, number, "<f8")
        assert refuses(policy, skill) == (
            f"rldx policy: expected action.gripper_close as finite float32 numbers, "
            f"got {said} in row 2 dimension 0"
        )


@settings(max_examples=80, deadline=None)
@given(POISON)
def test_a_policy_in_python_likewise_whatever_the_array_is_made_of(
    poison: tuple[int, int, float, str],
) -> None:
    class Own:
        def infer(self, observation: Observation) -> Any:
            return poisoned(*poison)

    policy: Any = Own()
    assert "expected" in refuses(policy, load_skill(PI05))


@pytest.mark.parametrize("dtype", ["<i8", "?", "<c8"])
def test_numbers_of_another_kind_and_masked_ones_are_a_typed_failure(dtype: str) -> None:
    with pytest.raises(
        PolicyError, match="expected actions as floats .* got (int64|bool|complex64)"
    ):
        pack_actions(FINITE.astype(dtype), DIM, HORIZON)
    masked = np.ma.masked_array(FINITE.astype(np.float32), mask=FINITE > 0)
    with pytest.raises(PolicyError, match="expected actions without masked numbers"):
        pack_actions(masked, DIM, HORIZON)


@pytest.mark.parametrize("number", [*NOT_FINITE, 1e308])
def test_a_constant_and_a_recording_likewise(tmp_path: Path, number: float) -> None:
    skill = load_skill(PI05)
    row: list[Any] = [0.25] * (DIM - 1) + [number]
    with np.errstate(over="ignore"):
        constant = ConstantPolicy.from_options(skill, {"row": row, "horizon": 2})
        assert "finite" in refuses(constant, skill)
        actions = np.asarray([row], np.float32)
    state = np.zeros(16).tobytes().hex()
    line = {"tick": 1, "state": state, "actions": actions.tobytes().hex(), "horizon": 1, "dim": DIM}
    (tmp_path / "trace.jsonl").write_text(json.dumps(line) + "\n")
    replay = ReplayPolicy.from_options(skill, {"trace": str(tmp_path / "trace.jsonl")})
    assert "finite" in refuses(replay, skill)


@pytest.mark.parametrize("number", [*NOT_FINITE, 1e308])
@pytest.mark.parametrize("place", [(0, 0), (2, 6), (3, 11)])
def test_a_network_in_a_file_likewise(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, number: float, place: tuple[int, int]
) -> None:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path))
    skill = install(tmp_path, poisonous(poisoned(*place, number, "<f4")))
    policy = OnnxPolicy.from_options(skill, skill.policy.options)
    fine = Observation(1, np.full(skill.state_contract.dim, 0.5), "")
    assert (policy.infer(fine) == 0.25).all()
    with pytest.raises(PolicyError, match="finite"):
        policy.infer(Observation(1, fine.state * 4, ""))


def test_every_backend_is_tried_above_but_those_that_compute_from_a_finite_state() -> None:
    tried = {OpenpiPolicy, RldxZmqPolicy, PythonFilePolicy, ConstantPolicy, ReplayPolicy}
    tried |= {OnnxPolicy, OracleSteps, ReachCubeOracle, JointReachPolicy, GoToPolicy}
    tried.add(LerobotPolicy)  # in its own file
    assert {POLICIES.find(name).value.rpartition(":")[2] for name in POLICIES.names()} == {
        backend.__name__ for backend in tried
    }


DUAL, MOBILE = load_robot("dual_panda"), load_robot("panda_mobile")
LEFT = {"ee": "left_tool"}
FIELDS: dict[ControlMode, dict[str, Any]] = {
    **{mode: LEFT | {"frame": "base_link"} for mode, rule in FIELD_RULES.items()
       if "frame" in rule.required},
    **{mode: {"joint_names": ["right_joint3", "right_joint1"]} for mode, rule in FIELD_RULES.items()
       if "joint_names" in rule.required},
    ControlMode.DEX_HAND_JOINT: {"joint_names": ["right_index_joint1", "right_index_joint2"]},
    ControlMode.GRIPPER_BINARY: LEFT | {"threshold": 0.5},
    ControlMode.GRIPPER_POSITION: LEFT,
    ControlMode.BODY_TWIST: {"axes": [0, 5]},
    ControlMode.COMPOSITE_MODE: {},
}  # fmt: skip


FITS: dict[str, dict[str, Any]] = {"plain": {}, "clip": {"clip": [-1.0, 1.0]}}
DECIDED = {"threshold": 0.5}
"""What the slots of one number may also ask for."""


def route_of(mode: ControlMode, scale: float, offset: float, fit: str) -> tuple[Route, int]:
    own = FIELDS[mode] | FITS.get(fit, {})
    if fit == "threshold" and mode in (ControlMode.GRIPPER_POSITION, ControlMode.COMPOSITE_MODE):
        own |= DECIDED
    if fit == "clip":
        own.pop("threshold", None)
    width = len(own.get("joint_names", own.get("axes", ()))) or mode.width(0)
    slot = {"range": [0, width - 1], "control_mode": mode.yaml_name, **own}
    contract = ActionContract.model_validate(
        {"dim": width, "slots": [slot | {"scale": scale, "offset": offset}]}
    )
    robot = MOBILE if mode in (ControlMode.BODY_TWIST, ControlMode.COMPOSITE_MODE) else DUAL
    [route] = resolve_routes(contract, robot)
    return route, width


@settings(max_examples=200, deadline=None)
@given(
    mode=st.sampled_from(list(FIELD_RULES)),
    column=st.integers(0, 6),
    row=st.integers(0, HORIZON - 1),
    number=st.sampled_from(NOT_FINITE),
    scale=st.sampled_from([1.0, -0.05, 1e-300]),
    offset=st.sampled_from([0.0, 0.5, -1e300]),
    fit=st.sampled_from(["plain", "clip", "threshold"]),
)
def test_whatever_the_slot_what_is_not_finite_reaches_the_gate_as_such(
    mode: ControlMode, column: int, row: int, number: float, scale: float, offset: float, fit: str
) -> None:
    """Fits and dispatch stand behind the check of the answer: they must not mend what that let
    pass."""
    route, width = route_of(mode, scale, offset, fit)
    column %= width
    rows = np.full((HORIZON, width), 0.25, np.float32)
    rows[row, column] = number
    [part] = dispatch([route], fitted([route], rows), width)
    values = floats(part.values, route.width)
    wrong = np.argwhere(~np.isfinite(values)).tolist()
    assert wrong == [[row, route.columns[column]]]


def test_every_mode_is_tried_above() -> None:
    assert set(FIELDS) == set(FIELD_RULES)


def test_a_discarded_dimension_counts_like_any_other() -> None:
    """A policy that puts out NaN anywhere is not in order; nothing of its answer is used."""
    skill = load_skill(PI05)
    [torso] = [slot for slot in skill.action_contract.slots if slot.discard]
    rows = FINITE.astype(np.float32)
    rows[1, torso.first] = np.nan
    with pytest.raises(PolicyError, match=f"got nan in row 1 dimension {torso.first}"):
        check_actions(Answer(rows.shape, rows.tobytes()), DIM, HORIZON)


def test_what_is_too_small_for_float32_is_zero_also_where_numpy_is_to_raise() -> None:
    with np.errstate(all="raise"):
        rows = policy_rows(np.full((1, 2), 1e-60), 2, 1)
    assert rows.tolist() == [[0.0, 0.0]]
