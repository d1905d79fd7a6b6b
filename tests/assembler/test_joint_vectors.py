"""State vectors of joints alone, from joint states as a HAL sends them."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import msgspec
import pytest
import yaml

from fairlead.messages import LayoutState, decode, floats, pack_floats
from fairlead.paths import SKILLS_VARIABLE, rskill_dir
from fairlead.robot.manifest import load_robot
from fairlead_state_assembler.core import AssemblerCore
from fairlead_state_assembler.publishers import Publishers
from fairlead_state_assembler.skill_view import SkillView
from tests.assembler.robot_feed import RobotFeed

PANDA = [f"panda_joint{number}" for number in range(1, 8)]
BOTH = [f"{side}_joint{number}" for side in ("right", "left") for number in range(1, 8)]


def field(names: list[str], unit: str) -> dict[str, Any]:
    quantity = "velocity" if unit.endswith("/s") else "position"
    return {"names": names, "quantity": quantity, "unit": unit}


@pytest.mark.parametrize(
    ("robot_id", "fields"),
    [
        ("panda", [field(PANDA[4::-1], "rad")]),
        ("panda", [field(PANDA[:6], "deg"), field(["panda_gripper"], "m")]),
        ("panda", [field(PANDA, "deg"), field(PANDA, "deg/s") | {"scale": 0.5}]),
        ("dual_panda", [field(BOTH, "rad"), field(["left_gripper"], "m/s")]),
        ("panda_mobile", [
            field(["base_x", "base_y"], "m"), field(["base_yaw", *PANDA], "rad"),
            field(["panda_gripper"], "m"),
        ]),
    ],
    ids=["5", "6 and gripper, degrees", "7 and speeds, degrees", "14", "11"],
)  # fmt: skip
def test_vector_has_the_named_joints_in_order_and_unit_and_needs_no_transform(
    robot_id: str, fields: list[dict[str, Any]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    manifest = yaml.safe_load((rskill_dir("panda-joint-reach") / "rskill.yaml").read_text())
    dim = sum(len(one["names"]) for one in fields)
    manifest |= {"id": "joints", "state_contract": {"dim": dim, "joints": fields}}
    (tmp_path / "joints").mkdir()
    (tmp_path / "joints" / "rskill.yaml").write_text(yaml.safe_dump(manifest))
    monkeypatch.setenv(SKILLS_VARIABLE, str(tmp_path))
    robot = load_robot(robot_id)
    state = RobotFeed(robot).joints(7)
    speeds = [0.1 - 0.03 * index for index in range(len(robot.measured_joint_names))]
    state = msgspec.structs.replace(state, velocities=pack_floats(speeds))
    core = AssemblerCore(robot, Publishers())
    core.want(SkillView("joints"))
    [answer] = [output for output in core.on_joints(state) if output.skill]
    measured = {"position": floats(state.positions).tolist(), "velocity": speeds}
    wanted = [
        measured[one["quantity"]][robot.measured_joint_names.index(name)]
        * (180.0 / math.pi if one["unit"].startswith("deg") else 1.0)
        / one.get("scale", 1.0)
        for one in fields
        for name in one["names"]
    ]
    found = decode(LayoutState, answer.payload)
    assert (found.layout, found.fault, found.oldest_tick) == ("joints", None, 7)
    assert found.values is not None
    assert floats(found.values).tolist() == wanted
