"""JPEG from a camera: decoded once, as OpenCV does; what is none is said and is no frame."""

from __future__ import annotations

import io
from contextlib import suppress
from typing import Any

import cv2
import msgspec
import numpy as np
import pytest
from PIL import Image as Pillow

from fairlead.errors import MessageError
from fairlead.jpeg import as_jpeg, decoded
from fairlead.messages import Image
from fairlead.skill.image_spec import ImageSpec
from fairlead_skill_runner.observation_buffer import ObservationBuffer
from fairlead_skill_runner.tick_history import contrast
from tests.runner.scripted_robot import SESSION, SKILL, layout

RNG = np.random.default_rng(23)
WIDTH, HEIGHT = 64, 48


def scene() -> np.ndarray[Any, np.dtype[np.uint8]]:
    """Something smooth, which JPEG is made for."""
    rows, columns = np.mgrid[:HEIGHT, :WIDTH]
    waves = [np.sin(rows / 9 + shift) + np.cos(columns / 7) for shift in RNG.uniform(0, 6, 3)]
    return (np.stack(waves, -1) * 60 + 128).astype(np.uint8)


def frame(data: bytes, tick: int = 5, encoding: Any = "jpeg") -> Image:
    return Image(
        session=SESSION, tick=tick, camera="front", width=WIDTH, height=HEIGHT,
        encoding_name=encoding, data=data,
    )  # fmt: skip


def pixels_of(image: Image) -> np.ndarray[Any, np.dtype[np.uint8]]:
    return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)


def eye() -> ObservationBuffer:
    spec = ImageSpec(camera="front", width=WIDTH, height=HEIGHT)
    skill = SKILL.model_copy(update={"images": {"eye": spec}})
    return ObservationBuffer(skill, "pick", {"front": 1}, exact=False, has_task=False)


@pytest.mark.parametrize("quality", [1, 50, 90, 100])
def test_pixels_are_those_that_opencv_decodes(quality: int) -> None:
    data = as_jpeg(scene(), quality)
    theirs = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    assert theirs is not None
    found = decoded(frame(data))
    assert found.encoding_name == "rgb8"
    np.testing.assert_array_equal(pixels_of(found), cv2.cvtColor(theirs, cv2.COLOR_BGR2RGB))


def test_pixels_are_near_what_was_seen_and_the_bytes_fewer() -> None:
    seen = scene()
    data = as_jpeg(seen, 90)
    assert len(data) < seen.nbytes / 3
    off = np.abs(pixels_of(decoded(frame(data))).astype(int) - seen)
    assert 0 < off.max() <= 12 and off.mean() < 1.5


def test_a_policy_gets_the_pixels_and_each_frame_is_decoded_once(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    opened: list[int] = []
    real = Pillow.open

    def counting(*args: Any, **more: Any) -> Any:
        opened.append(1)
        return real(*args, **more)

    monkeypatch.setattr(Pillow, "open", counting)
    box, image = eye(), frame(as_jpeg(scene(), 90))
    box.add_image(image)
    for tick in (5, 6, 7):
        box.add_layout(layout(tick))
        seen = box.gather().observation.images["eye"]
    assert len(opened) == 1
    np.testing.assert_array_equal(seen, pixels_of(decoded(image)))


def grey() -> bytes:
    file = io.BytesIO()
    Pillow.fromarray(scene()[..., 0]).save(file, "JPEG")
    return file.getvalue()


@pytest.mark.parametrize(
    ("data", "text"),
    [
        (b"", "got no such: "),
        (b"\xff\xd8 no more", "got no such: "),
        (as_jpeg(scene(), 90)[:-200], "got no such: "),
        (as_jpeg(scene()[:20], 90), "got one of 64 x 20, RGB"),
        (grey(), "got one of 64 x 48, L"),
    ],
)
def test_what_is_no_jpeg_of_that_size_is_no_frame(data: bytes, text: str) -> None:
    box = eye()
    with pytest.raises(MessageError) as caught:
        box.add_image(frame(data))
    assert str(caught.value).startswith("camera front: expected a JPEG of 64 x 48, RGB, ")
    assert text in str(caught.value)
    box.add_layout(layout(5))
    assert box.missing(5) == "image eye from camera front"


def test_damaged_bytes_are_a_picture_or_a_message_error() -> None:
    data = as_jpeg(scene(), 90)
    for _ in range(300):
        damaged = bytearray(data)
        for place in RNG.integers(0, len(data), 4):
            damaged[place] = RNG.integers(0, 256)
        with suppress(MessageError):
            assert len(decoded(frame(bytes(damaged))).data) == WIDTH * HEIGHT * 3


def test_a_black_jpeg_is_no_frame_and_the_camera_s_trouble_says_so() -> None:
    box = eye()
    box.add_image(frame(as_jpeg(scene(), 90)))
    box.add_image(frame(as_jpeg(np.zeros((HEIGHT, WIDTH, 3), np.uint8), 90), tick=6))
    box.add_layout(layout(30))
    assert "1 pictures of one colour came since" in box.missing(30)


@pytest.mark.parametrize(
    ("depths", "varies"),
    [
        (np.zeros((HEIGHT, WIDTH)), False),
        (np.full((HEIGHT, WIDTH), np.nan), False),
        (np.full((HEIGHT, WIDTH), np.inf), False),
        (np.full((HEIGHT, WIDTH), 1.5), False),
        (RNG.uniform(0.5, 3.0, (HEIGHT, WIDTH)), True),
        (np.where(RNG.uniform(size=(HEIGHT, WIDTH)) < 0.9, np.nan, RNG.uniform(1, 2)), False),
    ],
)
def test_a_depth_picture_of_one_distance_or_of_none_has_no_contrast(
    depths: np.ndarray[Any, Any], varies: bool
) -> None:
    image = frame(depths.astype("<f4").tobytes(), encoding="depth32f")
    assert (contrast(image) >= 1.0) is varies


def test_a_picture_of_another_length_is_left_to_who_takes_it() -> None:
    short = msgspec.structs.replace(frame(b"123"), encoding_name="depth32f")
    assert contrast(short) == float("inf")
