"""Servers of policies that answer what is no answer."""

from __future__ import annotations

import math

import msgspec
import numpy as np
import pytest

from fairlead.skill.manifest import load_skill
from fairlead_skill_runner.policies.remote.openpi import OpenpiPolicy
from fairlead_skill_runner.policies.remote.rldx_zmq import RldxZmqPolicy
from tests.runner.asked_policies import PI05, RLDX, ROWS, failure
from tests.runner.policy_servers import (
    DEEP,
    openpi_actions,
    openpi_array,
    rldx_actions,
    rldx_rows,
)

pytestmark = pytest.mark.processes


Broken = dict[str, tuple[bytes | bytearray | str | list[bytes] | None, str]]
BROKEN_OPENPI: Broken = {
    "too narrow": (openpi_actions(ROWS[:, :11]),
                   "expected actions as floats [1 to 50, 12], got float32 [4, 11]"),
    "one row, flat": (openpi_actions(ROWS[0]),
                      "expected actions as floats [1 to 50, 12], got float32 [12]"),
    "whole numbers": (openpi_actions(ROWS.astype(np.int64)),
                      "expected actions as floats [1 to 50, 12], got int64 [4, 12]"),
    "no rows": (openpi_actions(ROWS[:0]),
                "expected actions as floats [1 to 50, 12], got float32 [0, 12]"),
    "no actions": (msgspec.msgpack.encode({}),
                   "expected an output actions, got none of that name"),
    "other names": (msgspec.msgpack.encode({"action": 1, "timing": 2}),
                    "expected an output actions, got none of that name (valid: action, timing)"),
    "names that are none": (msgspec.msgpack.encode({1: 2, b"x": 3}),
                            "expected an output actions, got none of that name (valid: 1, b'x')"),
    "more rows than the skill takes": (
        openpi_actions(np.zeros((51, 12), np.float32)),
        "expected actions as floats [1 to 50, 12], got float32 [51, 12]"),
    "a traceback that goes on after its error": (
        "Traceback ...\njax.errors.TracerError: x is traced\n-----\nFor simplicity, JAX has "
        "removed its internal frames from the traceback.\n",
        "failed: jax.errors.TracerError: x is traced"),
    "a number": (b"\x07", "expected a map with actions, got int"),
    "no message": (b"\xc1garbage", "answered no message: "),
    "less data than its shape": (
        msgspec.msgpack.encode({"actions": openpi_array(ROWS) | {b"shape": [400, 12]}}),
        "answered no message: cannot reshape array of size 48"),
    "an array of objects": (
        msgspec.msgpack.encode({"actions": openpi_array(ROWS) | {b"dtype": "|O"}}),
        "answered no message: an array of |O"),
    "a traceback": ("Traceback ...\n  ...\nKeyError: 'state'\n", "failed: KeyError: 'state'"),
    "deeply nested": (DEEP, "answered no message: "),
    "a shape of nothing": (
        msgspec.msgpack.encode({"actions": openpi_array(ROWS) | {b"shape": [None, 12]}}),
        "answered no message: "),
    "a shape without an end": (
        msgspec.msgpack.encode({"actions": openpi_array(ROWS) | {b"shape": [math.inf, 12]}}),
        "answered no message: 'float' object"),
    "hangs up": (None, "closed the connection: "),
    "hangs up in the middle": (bytearray(b"\x82\x7e\xff\xff" + DEEP[:1000]),
                               "closed the connection: "),
}  # fmt: skip


GOOD = rldx_rows(ROWS)
LARGE_NPY = (
    b"\x93NUMPY\x01\x00\x4f\x00"
    + b"{'descr': '<f4', 'fortran_order': False, 'shape': (10000000, 10000000), }".ljust(78)
    + b"\n"
)
NARROW = "expected action.base_motion as floats [1 to 16, 4], got "
BROKEN_RLDX: Broken = {
    "too narrow": (rldx_actions(GOOD | {"base_motion": ROWS[:, :3]}), NARROW + "float32 [4, 3]"),
    "an output left out": (
        rldx_actions({n: a for n, a in GOOD.items() if n != "base_motion"}),
        "expected an output action.base_motion, got none of that name (valid: action.end_eff"),
    "names that are none": (msgspec.msgpack.encode([{1: 2}, {}]),
                            "expected an output action.end_effector_position, got none of that"),
    "unequal rows": (rldx_actions(GOOD | {"base_motion": ROWS[:3, 7:11]}),
                     "expected as many rows of every action, got 4, 4, 4, 3, 4"),
    "an error": (msgspec.msgpack.encode({"error": "no such key"}), "failed: no such key"),
    "a traceback": (
        msgspec.msgpack.encode({"error": "Traceback ...\n  ...\nValueError: no weights\n\n---\n"}),
        "failed: ValueError: no weights"),
    "an error without an end": (
        msgspec.msgpack.encode({"error": "x" * 5_000_000}), f"failed: {'x' * 1000}"),
    "a message of two parts": ([rldx_actions(GOOD), b"more"], "answered no message: "),
    "a map": (msgspec.msgpack.encode({"action": 1}),
              "expected a list that begins with a map, got dict"),
    "no message": (b"\xc1", "answered no message: "),
    "an array of no bytes": (
        msgspec.msgpack.encode([{"action.base_motion": {"__ndarray_class__": True}}, {}]),
        "answered no message: an array without its bytes"),
    "deeply nested": (DEEP, "answered no message: "),
    "an array larger than any memory": (
        msgspec.msgpack.encode([{"a": {"__ndarray_class__": True, "as_npy": LARGE_NPY}}, {}]),
        "answered no message: "),
    "an array cut short": (
        msgspec.msgpack.encode([{"a": {"__ndarray_class__": True, "as_npy": b"\x93NUMPY"}}, {}]),
        "answered no message: "),
}  # fmt: skip


SERVERS: dict[str, tuple[str, type[OpenpiPolicy | RldxZmqPolicy], Broken]] = {
    "openpi": (PI05, OpenpiPolicy, BROKEN_OPENPI),
    "rldx": (RLDX, RldxZmqPolicy, BROKEN_RLDX),
}


@pytest.mark.parametrize(
    ("server", "name"), [(server, name) for server in SERVERS for name in SERVERS[server][2]]
)
def test_a_server_that_answers_garbage_is_refused_before_any_claim(
    request: pytest.FixtureRequest, server: str, name: str
) -> None:
    skill_id, policy, broken = SERVERS[server]
    answer, text = broken[name]
    skill = load_skill(skill_id)
    started = request.getfixturevalue(server)(lambda asked, n: answer)
    options = skill.policy.options | {"address": started.address}
    said = failure(lambda: policy.from_options(skill, options))
    assert said.startswith(f"{server} policy: ")
    assert text in said and len(said) < 2000
