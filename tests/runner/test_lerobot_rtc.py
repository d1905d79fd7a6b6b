"""Real-time chunking with policies of LeRobot's: who can gets the rows that act meanwhile."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.runner.asked_policies import late
from tests.runner.lerobot_skill import (
    DIM,
    NAME,
    checkpoint,
    install,
    made,
    other_python,
    refusal,
    seen,
)

pytestmark = pytest.mark.processes


@pytest.fixture
def skills(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("FAIRLEAD_SKILLS", str(tmp_path / "skills"))
    return tmp_path / "skills"


@pytest.fixture
def python(tmp_path: Path) -> Path:
    return other_python(tmp_path)


def test_a_policy_with_real_time_chunking_goes_on_from_the_rows_that_act_meanwhile(
    skills: Path, python: Path, capfd: pytest.CaptureFixture[str]
) -> None:
    """They reach it in its own numbers, as its processors have those of a dataset."""
    checkpoint(skills / NAME / "own", type="smolvla", scale=2)
    with made(install(skills, python, rtc=True)) as policy:
        assert policy.continues_rows
        assert "it goes on from a prefix of one row within 0 of it" in capfd.readouterr().err
        policy.reset()
        assert policy.infer(seen())[0, 2] == 1
        now, acting = late(seen(), DIM, 3)
        rows = policy.infer(now)
        assert rows[:3].tobytes() == acting.tobytes()
        assert rows[3, 2] == 2
    with made(install(skills, python)) as policy:
        assert not policy.continues_rows
        assert policy.infer(now)[0, 2] == 2


def test_a_policy_without_real_time_chunking_is_refused_a_skill_that_wants_it(
    skills: Path, python: Path
) -> None:
    checkpoint(skills / NAME / "own")
    assert refusal(install(skills, python, rtc=True)) == (
        "lerobot policy: rtc: expected a policy with real-time chunking, or no rtc, got act of "
        "lerobot 0.6.1"
    )
