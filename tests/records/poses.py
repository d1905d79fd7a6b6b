"""The record's own bindings, transforms that fill them, and the vector or skill they make."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import yaml

from fairlead.paths import rskill_dir
from fairlead.skill.bindings import StateContractBindings
from fairlead_state_assembler import JointPositions, TransformBuffer, assemble_state, pose_from

PI05 = "pi05-robocasa365-human300-nf4"
RECORDS_BINDINGS: dict[str, Any] = {
    "eef_frame": "panda_hand_tcp",
    "base_frame": "base_link",
    "world_frame": "odom",
    "gripper_qpos_joints": ["panda_gripper"],
    "quaternion_convention": "xyzw",
}
RECORDED: dict[str, Any] = {"layout": "human300_16d", "dim": 16, "bindings": RECORDS_BINDINGS}
"""The record's own manifest."""

FINGERS = ("panda_finger_joint1", "panda_finger_joint2")
HAND_TURNED = (0.0, 0.0, 0.6, 0.8)
BASE_TURNED = (0.0, 0.6, 0.0, 0.8)


def transforms(tick: int = 1) -> TransformBuffer:
    """The hand at (0.5, 0.1, 1.2) in the base, the base at (2, 1, 0) in the world."""
    buffer = TransformBuffer()
    tcp = pose_from("panda_hand_tcp", [0.5, 0.1, 1.2], HAND_TURNED)
    base = pose_from("base_link", [2.0, 1.0, 0.0], BASE_TURNED)
    buffer.add("base_link", "panda_hand_tcp", tcp, tick, is_static=False)
    buffer.add("odom", "base_link", base, tick, is_static=False)
    return buffer


def assembled(layout: str, buffer: TransformBuffer | None = None, **changes: Any) -> list[float]:
    bindings = StateContractBindings.model_validate(RECORDS_BINDINGS | changes)
    joints = JointPositions.named(("panda_gripper", *FINGERS), np.array([0.03, 0.02, -0.01]))
    at = (transforms() if buffer is None else buffer).at(1)
    return [float(v) for v in assemble_state(layout, bindings, joints, at).round(9)]


def skill_file(folder: Path, contract: dict[str, Any]) -> Path:
    """The folder of a skill as an author writes it, with a state contract of its own."""
    plain = yaml.safe_load((rskill_dir(PI05) / "rskill.yaml").read_text())
    plain |= {"id": folder.name, "state_contract": contract}
    folder.mkdir()
    (folder / "rskill.yaml").write_text(yaml.safe_dump(plain))
    return folder
