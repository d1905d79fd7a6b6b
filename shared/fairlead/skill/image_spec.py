"""Pictures a policy wants: from which camera, and what is done to each of them, in which order."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from fairlead.skill.deltas import NOW, Deltas

Size = tuple[int, int]
"""Width and height [pixels]."""

_LARGEST = 4096


class CropBox(BaseModel):
    """The part of a picture that is kept [pixels]; left and top: its first column and row."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    left: int = Field(ge=0)
    top: int = Field(ge=0)
    width: int = Field(gt=0)
    height: int = Field(gt=0)


class PictureStep(BaseModel):
    """One change of a picture: exactly one of these.

    Attributes:
        rotate_deg: clockwise.
        flip: horizontal: left becomes right; vertical: top becomes bottom.
        crop: what is kept.
        resize: to width and height, each side by itself. Smaller pictures get other pixels than by
            the bilinear filters of OpenCV and PyTorch: a policy that was trained with those needs
            a camera of the final size.
        resize_with_pad: as large as fits into width and height, in the middle of black.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    rotate_deg: Literal[90, 180, 270] | None = None
    flip: Literal["horizontal", "vertical"] | None = None
    crop: CropBox | None = None
    resize: Size | None = None
    resize_with_pad: Size | None = None

    @field_validator("resize", "resize_with_pad")
    @classmethod
    def _side(cls, value: Size | None) -> Size | None:
        if value is not None and not all(0 < side <= _LARGEST for side in value):
            raise ValueError(f"expected width and height from 1 to {_LARGEST}, got {list(value)}")
        return value

    @model_validator(mode="after")
    def _is_one(self) -> Self:
        names = type(self).model_fields
        given = [name for name in names if getattr(self, name) is not None]
        if len(given) != 1:
            got = " and ".join(given) or "none"
            raise ValueError(f"expected one of {', '.join(names)}, got {got}")
        return self

    def size_after(self, size: Size) -> Size:
        """What it makes of a picture of this size.

        Raises:
            ValueError: it cannot be done to one.
        """
        width, height = size
        if self.crop is not None:
            box = self.crop
            if box.left + box.width > width or box.top + box.height > height:
                raise ValueError(
                    f"crop: expected a box within {width} x {height}, got columns {box.left} to "
                    f"{box.left + box.width - 1}, rows {box.top} to {box.top + box.height - 1}"
                )
            return box.width, box.height
        if self.flip is not None:
            return size
        if self.rotate_deg is not None:
            return (width, height) if self.rotate_deg == 180 else (height, width)
        if self.resize is not None:
            return self.resize
        assert self.resize_with_pad is not None
        if 0 in scaled_into(size, self.resize_with_pad):
            raise ValueError(
                f"resize_with_pad: nothing would be left of {width} x {height} in "
                f"{self.resize_with_pad[0]} x {self.resize_with_pad[1]}"
            )
        return self.resize_with_pad


class ImageSpec(BaseModel):
    """One picture a policy wants.

    width, height: of the camera's pictures [pixels].
    transforms: what is done to each, in this order.
    channels, axes, dtype: of the array that the policy gets in the end. float32_unit: from 0 to 1;
        float32_signed: from -1 to 1.
    deltas: of the frames it wants at a time, in rows of the policy (1 / ``rate_hz``) before the
        newest, which is 0; ascending. Before a goal's first frame there is that one again.
    contrast_min: standard deviation of the colour channel that varies most [levels of 255]; a
        frame with less is none, as if the camera had sent nothing. 0: every frame counts. Of
        several pictures of one camera the largest holds for all.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    camera: str
    width: int = Field(gt=0)
    height: int = Field(gt=0)
    transforms: tuple[PictureStep, ...] = ()
    channels: Literal["rgb", "bgr"] = "rgb"
    axes: Literal["hwc", "chw"] = "hwc"
    dtype: Literal["uint8", "float32_unit", "float32_signed"] = "uint8"
    deltas: Deltas = NOW
    contrast_min: float = Field(default=1.0, ge=0, le=127.5)

    @model_validator(mode="after")
    def _can_be_done(self) -> Self:
        list(self._sizes())
        return self

    def _sizes(self) -> Iterator[Size]:
        size = self.width, self.height
        yield size
        for index, step in enumerate(self.transforms):
            try:
                size = step.size_after(size)
            except ValueError as error:
                raise ValueError(f"transforms.{index}: {error}") from None
            yield size

    @property
    def shape(self) -> tuple[int, int, int]:
        """Of one frame as the policy gets it."""
        *_, (width, height) = self._sizes()
        return (height, width, 3) if self.axes == "hwc" else (3, height, width)

    @property
    def number_type(self) -> np.dtype[Any]:
        """Of the array that the policy gets."""
        return np.dtype(np.uint8 if self.dtype == "uint8" else np.float32)

    @property
    def is_plain(self) -> bool:
        """Whether the array is uint8 with the channels last, as most servers take it."""
        return self.dtype == "uint8" and self.axes == "hwc"


def scaled_into(size: Size, box: Size) -> Size:
    """The largest size of these proportions in the box, rounded down."""
    shrunk = max(side / most for side, most in zip(size, box, strict=True))
    return int(size[0] / shrunk), int(size[1] / shrunk)
