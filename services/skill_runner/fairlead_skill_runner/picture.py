"""From a camera's frame to the array that a policy gets: here, and nowhere else."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
from PIL import Image as Pillow

from fairlead.errors import PolicyError, expected
from fairlead.messages import Image
from fairlead.skill.image_spec import ImageSpec, PictureStep, Size, scaled_into

Pixels = npt.NDArray[np.uint8]

_BYTE = np.float32(255)


def picture(name: str, spec: ImageSpec, image: Image) -> npt.NDArray[Any]:
    """What the skill declares of a frame, `ImageSpec.shape` of `ImageSpec.number_type`.

    Raises:
        PolicyError: the frame is not what the skill says of its camera.
    """
    size = spec.width * spec.height * 3
    fits = (image.width, image.height) == (spec.width, spec.height) and len(image.data) == size
    if image.encoding_name != "rgb8" or not fits:
        raise PolicyError(
            expected(
                f"image {name}",
                f"rgb8 of {spec.width} x {spec.height}",
                f"{image.encoding_name} of {image.width} x {image.height}",
            )
        )
    pixels = np.frombuffer(image.data, dtype=np.uint8).reshape(image.height, image.width, 3)
    for step in spec.transforms:
        pixels = _changed(pixels, step)
    return as_declared(spec, pixels)


def as_declared(spec: ImageSpec, pixels: Pixels) -> npt.NDArray[Any]:
    """Pixels ``[..., height, width, 3]``, RGB, with the declared channels, axes and numbers."""
    if spec.channels == "bgr":
        pixels = pixels[..., ::-1]
    if spec.axes == "chw":
        pixels = np.moveaxis(pixels, -1, -3)
    whole = np.ascontiguousarray(pixels)
    if spec.dtype == "uint8":
        return whole
    unit = whole.astype(np.float32) / _BYTE
    return unit if spec.dtype == "float32_unit" else unit * np.float32(2) - np.float32(1)


def pixels_of(spec: ImageSpec, array: npt.NDArray[Any]) -> Pixels:
    """The pixels that `as_declared` made an array of."""
    if spec.dtype != "uint8":
        unit = array if spec.dtype == "float32_unit" else (array + np.float32(1)) / np.float32(2)
        array = np.rint(unit * _BYTE).astype(np.uint8)
    if spec.axes == "chw":
        array = np.moveaxis(array, -3, -1)
    return np.ascontiguousarray(array[..., ::-1] if spec.channels == "bgr" else array)


def _changed(pixels: Pixels, step: PictureStep) -> Pixels:
    if step.rotate_deg is not None:
        return np.rot90(pixels, k=-(step.rotate_deg // 90))
    if step.flip is not None:
        return np.flip(pixels, axis=1 if step.flip == "horizontal" else 0)
    if step.crop is not None:
        box = step.crop
        return pixels[box.top : box.top + box.height, box.left : box.left + box.width]
    if step.resize is not None:
        return _resized(pixels, step.resize)
    assert step.resize_with_pad is not None
    return _padded(pixels, step.resize_with_pad)


def _resized(pixels: Pixels, size: Size) -> Pixels:
    """Pillow's bilinear filter, which takes all pixels into account where it shrinks."""
    whole = Pillow.fromarray(np.ascontiguousarray(pixels))
    return np.asarray(whole.resize(size, Pillow.Resampling.BILINEAR))


def _padded(pixels: Pixels, size: Size) -> Pixels:
    width, height = scaled_into((pixels.shape[1], pixels.shape[0]), size)
    left, top = (size[0] - width) // 2, (size[1] - height) // 2
    padded = np.zeros((size[1], size[0], 3), np.uint8)
    padded[top : top + height, left : left + width] = _resized(pixels, (width, height))
    return padded
