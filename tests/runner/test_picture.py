"""What a policy gets of a frame, beside what libraries of others make of the same pixels."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import cv2
import matplotlib.image
import numpy as np
import pytest
from PIL import Image as Pillow

from fairlead.errors import PolicyError
from fairlead.messages import Image
from fairlead.skill.image_spec import ImageSpec
from fairlead_skill_runner import picture as module
from fairlead_skill_runner.observation_buffer import ObservationBuffer
from fairlead_skill_runner.picture import as_declared, picture, pixels_of
from tests.runner.scripted_robot import SESSION, SKILL, layout

RNG = np.random.default_rng(17)
ALL = np.arange(256, dtype=np.uint8)


def frame(pixels: np.ndarray[Any, Any], tick: int = 5) -> Image:
    height, width = pixels.shape[:2]
    return Image(
        session=SESSION, tick=tick, camera="front", width=width, height=height,
        encoding_name="rgb8", data=pixels.tobytes(),
    )  # fmt: skip


def declared(pixels: np.ndarray[Any, Any], *steps: dict[str, Any], **more: Any) -> ImageSpec:
    height, width = pixels.shape[:2]
    made = {"camera": "front", "width": width, "height": height, "transforms": steps}
    return ImageSpec.model_validate(made | more)


def random_pixels(width: int, height: int) -> np.ndarray[Any, np.dtype[np.uint8]]:
    return RNG.integers(0, 256, (height, width, 3), np.uint8)


def made(pixels: np.ndarray[Any, Any], *steps: dict[str, Any], **more: Any) -> Any:
    return picture("eye", declared(pixels, *steps, **more), frame(pixels))


@pytest.mark.parametrize(
    ("deg", "code"),
    [(90, cv2.ROTATE_90_CLOCKWISE), (180, cv2.ROTATE_180), (270, cv2.ROTATE_90_COUNTERCLOCKWISE)],
)
@pytest.mark.parametrize(("width", "height"), [(640, 480), (5, 7)])
def test_a_picture_is_turned_as_opencv_turns_it(
    deg: int, code: int, width: int, height: int
) -> None:
    pixels = random_pixels(width, height)
    np.testing.assert_array_equal(made(pixels, {"rotate_deg": deg}), cv2.rotate(pixels, code))


@pytest.mark.parametrize(
    ("flip", "numpys", "pillows"),
    [
        ("horizontal", np.fliplr, Pillow.Transpose.FLIP_LEFT_RIGHT),
        ("vertical", np.flipud, Pillow.Transpose.FLIP_TOP_BOTTOM),
    ],
)
def test_a_picture_is_flipped_as_numpy_and_pillow_flip_it(
    flip: str, numpys: Callable[[Any], Any], pillows: Pillow.Transpose
) -> None:
    pixels = random_pixels(7, 5)
    flipped = made(pixels, {"flip": flip})
    np.testing.assert_array_equal(flipped, numpys(pixels))
    np.testing.assert_array_equal(flipped, np.asarray(Pillow.fromarray(pixels).transpose(pillows)))
    np.testing.assert_array_equal(made(pixels, {"flip": flip}, {"flip": flip}), pixels)


def test_an_upright_picture_flipped_is_what_libero_s_checkpoints_were_trained_on() -> None:
    """They turn a picture of robosuite's, whose rows come bottom first, by 180 degrees."""
    upright = random_pixels(8, 8)
    robosuites = upright[::-1]
    trained_on = cv2.rotate(robosuites, cv2.ROTATE_180)
    np.testing.assert_array_equal(made(upright, {"flip": "horizontal"}), trained_on)
    assert (made(upright, {"rotate_deg": 180}) != trained_on).any()


def test_a_box_is_cut_out_and_sides_resized_as_pillow_does_both() -> None:
    for _ in range(20):
        width, height, to_width, to_height = map(int, RNG.integers(8, 300, 4))
        pixels = random_pixels(width, height)
        left, top = width // 4, height // 8
        box = {"left": left, "top": top, "width": width // 2, "height": height // 2}
        theirs = Pillow.fromarray(pixels).crop((left, top, left + width // 2, top + height // 2))
        np.testing.assert_array_equal(made(pixels, {"crop": box}), np.asarray(theirs))
        theirs = theirs.resize((to_width, to_height), Pillow.Resampling.BILINEAR)
        ours = made(pixels, {"crop": box}, {"resize": [to_width, to_height]})
        np.testing.assert_array_equal(ours, np.asarray(theirs))


def test_transforms_are_done_in_their_order() -> None:
    pixels = random_pixels(6, 4)
    box = {"crop": {"left": 0, "top": 0, "width": 4, "height": 4}}
    first = made(pixels, box, {"rotate_deg": 180})
    last = made(pixels, {"rotate_deg": 180}, box)
    np.testing.assert_array_equal(first, cv2.rotate(pixels[:, :4], cv2.ROTATE_180))
    np.testing.assert_array_equal(last, cv2.rotate(pixels, cv2.ROTATE_180)[:, :4])
    assert (first != last).any()


def test_channels_and_axes_are_as_opencv_has_them() -> None:
    pixels = random_pixels(9, 6)
    blue_first = cv2.cvtColor(pixels, cv2.COLOR_RGB2BGR)
    np.testing.assert_array_equal(made(pixels, channels="bgr"), blue_first)
    planes = cv2.split(blue_first)
    np.testing.assert_array_equal(made(pixels, channels="bgr", axes="chw"), np.stack(planes))


def test_numbers_from_0_to_1_are_those_that_matplotlib_reads_from_a_png() -> None:
    pixels = np.stack([ALL.reshape(16, 16)] * 3, -1)
    file = io.BytesIO()
    Pillow.fromarray(pixels).save(file, "png")
    file.seek(0)
    theirs = matplotlib.image.imread(file, format="png")
    ours = made(pixels, dtype="float32_unit")
    assert ours.dtype == theirs.dtype == np.float32
    np.testing.assert_array_equal(ours, theirs)
    signed = made(pixels, dtype="float32_signed")
    assert (signed.min(), signed.max(), signed.dtype) == (-1.0, 1.0, np.float32)
    np.testing.assert_allclose(signed, theirs.astype(float) * 2 - 1, atol=1e-7)


@pytest.mark.parametrize("dtype", ["uint8", "float32_unit", "float32_signed"])
@pytest.mark.parametrize("axes", ["hwc", "chw"])
@pytest.mark.parametrize("channels", ["rgb", "bgr"])
def test_every_level_is_got_back_from_what_a_policy_gets(
    dtype: str, axes: str, channels: str
) -> None:
    pixels = RNG.permutation(np.repeat(ALL, 3)).reshape(2, 16, 8, 3)
    spec = declared(pixels[0], dtype=dtype, axes=axes, channels=channels)
    array = as_declared(spec, pixels)
    assert (array.shape, array.dtype) == ((2, *spec.shape), spec.number_type)
    np.testing.assert_array_equal(pixels_of(spec, array), pixels)


def test_each_frame_is_transformed_once_however_many_observations_it_is_in(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    eye = declared(random_pixels(6, 4), {"resize_with_pad": [8, 8]}, deltas=(-2, -1, 0))
    skill = SKILL.model_copy(update={"images": {"eye": eye}})
    resized: list[int] = []
    real = module._resized

    def counting(pixels: Any, size: Any) -> Any:
        resized.append(1)
        return real(pixels, size)

    monkeypatch.setattr(module, "_resized", counting)
    box = ObservationBuffer(skill, "pick", {"front": 1}, exact=False, has_task=False)
    for tick in range(1, 11):
        box.add_image(frame(random_pixels(6, 4), tick))
        box.add_layout(layout(tick))
        assert box.gather().observation.frames["eye"].shape == (3, 8, 8, 3)
    assert len(resized) == 10


def test_a_frame_of_another_size_is_a_policy_error() -> None:
    pixels = random_pixels(6, 4)
    spec = declared(random_pixels(8, 4), {"resize": [6, 4]})
    with pytest.raises(PolicyError) as caught:
        picture("eye", spec, frame(pixels))
    assert str(caught.value) == "image eye: expected rgb8 of 8 x 4, got rgb8 of 6 x 4"
