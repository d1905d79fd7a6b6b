"""A camera's recorded frames as an MP4 file."""

from __future__ import annotations

import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError
from fairlead.messages import Image


def write_film(images: Sequence[Image], frames_per_s: float, path: Path) -> None:
    """Encode frames in tick order; a tick that came twice counts once.

    Raises:
        ConfigError: there is no frame, or frames that are no colour pictures.
    """
    import imageio_ffmpeg

    if not images:
        raise ConfigError(f"{path}: no camera frame was recorded")
    by_tick = {image.tick: image for image in images}
    first = images[0]
    writer: Any = imageio_ffmpeg.write_frames(
        str(path), (first.width, first.height), fps=frames_per_s, quality=7, macro_block_size=2
    )
    writer.send(None)  # starts the encoder
    for tick in sorted(by_tick):
        writer.send(np.ascontiguousarray(pixels(by_tick[tick])))
    writer.close()


def pixels(image: Image) -> npt.NDArray[np.uint8]:
    """uint8 ``[height, width, 3]``, RGB, row 0 at the top.

    Raises:
        ConfigError: for a depth image.
    """
    if image.encoding_name == "rgb8":
        return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)
    if image.encoding_name == "jpeg":
        import imageio.v3 as imageio

        return np.asarray(imageio.imread(io.BytesIO(image.data), extension=".jpg"))
    raise ConfigError(
        f"camera {image.camera}: expected a colour image, got {image.encoding_name} "
        "(valid: rgb8, jpeg)"
    )
