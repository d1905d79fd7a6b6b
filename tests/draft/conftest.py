"""A desk for each test: a folder, with robots of one's own in it."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.draft.drafting import Desk


@pytest.fixture
def desk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Desk:
    monkeypatch.setenv("FAIRLEAD_ROBOTS", str(tmp_path / "robots"))
    monkeypatch.chdir(tmp_path)
    return Desk(tmp_path)
