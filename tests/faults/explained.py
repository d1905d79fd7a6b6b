"""Rows of the fault matrix that the campaign does not run, and what there is instead."""

from __future__ import annotations

from tests.faults.row import NotRun

NOT_RUN: tuple[NotRun, ...] = (
    NotRun(
        6, "policy server slow, hanging, dropping, late, garbage",
        "tests/runner/test_remote_policies.py: real servers, without a time from the HAL's log",
    ),
    NotRun(
        23, "writer without the right to write",
        "there is no access control yet; chunks without a live claim are rows 16 and 21",
    ),
    NotRun(24, "peer with a default configuration", "there is no access control yet"),
    NotRun(25, "expired, revoked or wrong certificate", "there are no certificates yet"),
    NotRun(
        30, "camera stalls, repeats, goes black",
        "tests/hal/test_cameras.py and tests/system/test_camera_skills.py, without a time from "
        "the HAL's log; needs rendering",
    ),
)  # fmt: skip
