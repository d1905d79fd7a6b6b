"""Rows of the fault matrix that the campaign does not run, and what there is instead."""

from __future__ import annotations

from bench.faults.row import NotRun

NOT_RUN: tuple[NotRun, ...] = (
    NotRun(
        23, "writer without the right to write",
        "no access control yet; chunks without a live claim: rows 16 and 21",
    ),
    NotRun(24, "peer with a default configuration", "no access control yet"),
    NotRun(25, "expired, revoked or wrong certificate", "no certificates yet"),
)  # fmt: skip
