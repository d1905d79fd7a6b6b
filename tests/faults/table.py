"""All rows of the fault matrix."""

from __future__ import annotations

from tests.faults import process_faults
from tests.faults.row import NotRun, Row

ROWS: tuple[Row, ...] = tuple(
    sorted((*process_faults.ROWS,), key=lambda row: row.number)
)
NOT_RUN: tuple[NotRun, ...] = ()
