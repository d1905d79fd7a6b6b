"""What GR00T-N1.6-3B has for the embodiment robocasa_panda_omron.

From the published checkpoint's processor_config.json, as whichwhichgone/Isaac-GR00T on GitHub has
it at b2f07bd0: by modality its deltas and names.
"""

from __future__ import annotations

ROBOCASA_PANDA_OMRON: dict[str, tuple[list[int], list[str]]] = {
    "video": ([0], ["res256_image_side_0", "res256_image_side_1", "res256_image_wrist_0"]),
    "state": (
        [0],
        [
            "end_effector_position_relative",
            "end_effector_rotation_relative",
            "gripper_qpos",
            "base_position",
            "base_rotation",
        ],
    ),
    "action": (
        list(range(16)),
        [
            "end_effector_position",
            "end_effector_rotation",
            "gripper_close",
            "base_motion",
            "control_mode",
        ],
    ),
    "language": ([0], ["annotation.human.action.task_description"]),
}
