"""Our pictures beside openpi-client's own, pixel for pixel."""

from __future__ import annotations

import json
import subprocess
from typing import Any

import numpy as np
import pytest

from fairlead.messages import Image
from fairlead.skill.image_spec import ImageSpec
from fairlead_skill_runner.picture import picture
from tests.peers.environment import peer

pytestmark = pytest.mark.processes

BOXES = ((224, 224), (256, 256), (64, 96))
SIZES = ((640, 480), (480, 640), (1280, 720), (224, 224), (256, 256), (97, 31), (31, 97), (3, 200))


def ours(pixels: np.ndarray[Any, Any], **declared: Any) -> np.ndarray[Any, Any]:
    height, width = pixels.shape[:2]
    sizes = {"width": width, "height": height}
    frame = Image(
        session=1, tick=1, camera="front", encoding_name="rgb8", data=pixels.tobytes(), **sizes
    )
    spec = ImageSpec.model_validate({"camera": "front"} | sizes | declared)
    return picture("eye", spec, frame)


def theirs(jobs: list[dict[str, Any]]) -> list[str]:
    done = subprocess.run(
        peer("peer_images"), input="".join(f"{json.dumps(job)}\n" for job in jobs),
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return done.stdout.splitlines()


def told(array: np.ndarray[Any, Any]) -> str:
    return f"{array.dtype} {list(array.shape)} {array.tobytes().hex()}"


def test_resize_with_pad_is_openpi_s_own_on_random_pictures() -> None:
    rng = np.random.default_rng(3)
    drawn = [tuple(map(int, rng.integers(1, 400, 2))) for _ in range(40)]
    cases = [
        (rng.integers(0, 256, (height, width, 3), np.uint8), box)
        for width, height in (*SIZES, *drawn)
        for box in BOXES
        if 200 * min(width, height) > max(width, height)  # of less nothing is left
    ]
    jobs = [
        {"width": one.shape[1], "height": one.shape[0], "pixels": one.tobytes().hex(), "box": box}
        for one, box in cases
    ]
    for (pixels, box), line in zip(cases, theirs(jobs), strict=True):
        made = ours(pixels, transforms=[{"resize_with_pad": box}])
        assert told(made) == line, (pixels.shape, box)


def test_openpi_s_client_brings_our_numbers_from_0_to_1_back_to_a_level_at_most_below() -> None:
    """It cuts off what it multiplied by 255, so a number just below its level loses one."""
    levels = np.repeat(np.arange(256, dtype=np.uint8), 3).reshape(16, 16, 3)
    unit = ours(levels, dtype="float32_unit")
    job = {"width": 16, "height": 16, "pixels": unit.astype("<f4").tobytes().hex(), "box": None}
    (line,) = theirs([job])
    back = np.frombuffer(bytes.fromhex(line.split(" ")[-1]), np.uint8).reshape(levels.shape)
    assert set((levels.astype(int) - back).ravel().tolist()) <= {0, 1}
