"""Rows of the fault matrix that the campaign does not run, and what there is instead."""

from __future__ import annotations

from bench.faults.row import NotRun

NOT_RUN: tuple[NotRun, ...] = (
    NotRun(25, "expired, revoked or wrong certificate", "no certificates yet"),
)  # fmt: skip
