"""``fairlead home`` says which joints it left where they are."""

from __future__ import annotations

from contextlib import nullcontext
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from fairlead.robot.manifest import load_robot
from fairlead.robot.rules import HomePose
from fairlead_tools.cli import jog

KINOVA = load_robot("kinova3")
BOUNDED = [joint.name for joint in (*KINOVA.joints, *KINOVA.passive_joints) if joint.has_bounds]
HOME = HomePose(positions=dict.fromkeys(BOUNDED, 0.5), source="test")


def test_joints_without_a_home_stay_where_they_are_and_are_named(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    asked: list[Any] = []
    chosen = SimpleNamespace(robot="kinova3", profile="sim")
    monkeypatch.setattr(jog, "choose_deployment", lambda _: chosen)
    monkeypatch.setattr(jog, "load_robot", lambda _: KINOVA.model_copy(update={"home": HOME}))
    monkeypatch.setattr(jog, "_hand", lambda *_: nullcontext())
    monkeypatch.setattr(jog, "_go", lambda _, wanted, __: asked.append(wanted(np.arange(7.0))))
    jog.home_command(deployment=Path("any.yaml"))
    np.testing.assert_array_equal(asked, [[0.0, 0.5, 2.0, 0.5, 4.0, 0.5, 6.0]])
    assert capsys.readouterr().out == (
        "arm is home but for joint_1, joint_3, joint_5, joint_7: without a home in robot.yaml, "
        "left where it was\n"
    )
