"""What a skill may declare of a picture, and what is said of what it may not."""

from __future__ import annotations

from typing import Any

import pytest

from fairlead.checked_model import checked_model
from fairlead.errors import ConfigError
from fairlead.skill.image_spec import ImageSpec

CAMERA = {"camera": "front", "width": 640, "height": 480}


def spec(*steps: dict[str, Any], **more: Any) -> ImageSpec:
    return checked_model("skill", ImageSpec, CAMERA | {"transforms": list(steps)} | more)


def crop(left: int, top: int, width: int, height: int) -> dict[str, Any]:
    return {"crop": {"left": left, "top": top, "width": width, "height": height}}


@pytest.mark.parametrize(
    ("steps", "shape"),
    [
        ([], (480, 640, 3)),
        ([{"rotate_deg": 90}], (640, 480, 3)),
        ([{"flip": "horizontal"}, {"flip": "vertical"}], (480, 640, 3)),
        ([{"rotate_deg": 180}], (480, 640, 3)),
        ([crop(80, 0, 480, 480)], (480, 480, 3)),
        ([{"rotate_deg": 270}, crop(0, 160, 480, 480), {"resize": [224, 112]}], (112, 224, 3)),
        ([{"resize_with_pad": [224, 224]}], (224, 224, 3)),
    ],
)
def test_the_shape_is_what_the_transforms_make_of_the_camera_s(
    steps: list[dict[str, Any]], shape: tuple[int, ...]
) -> None:
    assert spec(*steps).shape == shape
    assert spec(*steps, axes="chw").shape == (3, *shape[:2])


def test_a_box_may_end_where_the_picture_ends() -> None:
    assert spec(crop(160, 0, 480, 480)).shape == (480, 480, 3)


STEPS = "rotate_deg, flip, crop, resize, resize_with_pad"


@pytest.mark.parametrize(
    ("steps", "text"),
    [
        ([{}], f"transforms.0: expected one of {STEPS}, got none"),
        ([{"rotate_deg": 90, "resize": [2, 2]}],
         f"transforms.0: expected one of {STEPS}, got rotate_deg and resize"),
        ([{"rotate_deg": 45}], "transforms.0.rotate_deg: Input should be 90, 180 or 270, got 45"),
        ([{"flip": "left"}],
         "transforms.0.flip: Input should be 'horizontal' or 'vertical', got 'left'"),
        ([{"rotate_deg": 90}, crop(161, 0, 480, 480)],
         "transforms.1: crop: expected a box within 480 x 640, got columns 161 to "
         "640, rows 0 to 479"),
        ([crop(0, 1, 640, 480)],
         "transforms.0: crop: expected a box within 640 x 480, got columns 0 to 639, "
         "rows 1 to 480"),
        ([{"resize": [0, 224]}],
         "transforms.0.resize: expected width and height from 1 to 4096, got [0, 224]"),
        ([crop(0, 0, 640, 1), {"resize_with_pad": [64, 64]}],
         "transforms.1: resize_with_pad: nothing would be left of 640 x 1 in 64 x 64"),
        ([{"resize_pad": [224, 224]}],
         "transforms.0.resize_pad: unknown key, did you mean resize_with_pad? (valid: "
         f"{STEPS})"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_named_with_its_place(
    steps: list[dict[str, Any]], text: str
) -> None:
    with pytest.raises(ConfigError) as caught:
        spec(*steps)
    assert str(caught.value) == f"skill: 1 problem(s):\n  {text}"


def test_another_kind_of_numbers_is_refused_with_those_there_are() -> None:
    with pytest.raises(ConfigError, match="'uint8', 'float32_unit' or 'float32_signed'"):
        spec(dtype="float16")
