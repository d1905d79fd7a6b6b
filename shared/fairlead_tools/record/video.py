"""A camera's recorded pictures as a video, with the gate's verdicts below each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from fairlead.errors import ConfigError
from fairlead.jpeg import decoded
from fairlead.messages import Image
from fairlead_tools.record.caption import Caption, draw_caption

Pixels = npt.NDArray[np.uint8]
STILL_S = 2.0  # how long the last picture stands still for each caption after it
_GIF = [
    "-filter_complex",
    "split[a][b];[a]palettegen=max_colors=64[palette];"
    "[b][palette]paletteuse=dither=none:diff_mode=rectangle",
]  # one palette for all frames


def captioned(
    images: Sequence[Image],
    caption: Callable[[int], Caption],
    ends: Sequence[Caption],
    frames_per_s: float,
) -> Iterator[Pixels]:
    """Frames of a video, in tick order; a tick that came twice counts once.

    Args:
        images: pictures of one camera.
        caption: what stands below the picture of a tick.
        ends: stand one after the other below the last picture, which is repeated for them.
        frames_per_s: of the video.

    Raises:
        ConfigError: there is no picture, or one that is no colour picture.
    """
    if not images:
        raise ConfigError("video: expected camera pictures, got none")
    by_tick = {image.tick: image for image in images}
    for tick in sorted(by_tick):
        yield _above(pixels(by_tick[tick]), caption(tick))
    for end in ends:
        still = _above(pixels(by_tick[max(by_tick)]), end)
        yield from [still] * round(STILL_S * frames_per_s)


def _above(picture: Pixels, caption: Caption) -> Pixels:
    return np.vstack((picture, draw_caption(caption, picture.shape[1])))


def write_video(frames: Iterable[Pixels], frames_per_s: float, path: Path) -> None:
    """Encode frames, uint8 ``[height, width, 3]``, as the file's ending says: .mp4 or .gif."""
    import imageio_ffmpeg

    writer: Any = None
    for frame in frames:
        if writer is None:
            size = frame.shape[1], frame.shape[0]
            how: dict[str, Any] = {"quality": 7}
            if path.suffix == ".gif":
                how = {
                    "codec": "gif",
                    "quality": None,
                    "pix_fmt_out": "pal8",
                    "output_params": _GIF,
                }
            writer = imageio_ffmpeg.write_frames(
                str(path), size, fps=frames_per_s, macro_block_size=2, **how
            )
            writer.send(None)  # starts the encoder
        writer.send(np.ascontiguousarray(frame))
    if writer is not None:
        writer.close()


def pixels(image: Image) -> Pixels:
    """uint8 ``[height, width, 3]``, RGB, row 0 at the top.

    Raises:
        ConfigError: for a depth image.
    """
    image = decoded(image)
    if image.encoding_name == "rgb8":
        return np.frombuffer(image.data, np.uint8).reshape(image.height, image.width, 3)
    raise ConfigError(
        f"camera {image.camera}: expected a colour image, got {image.encoding_name} "
        "(valid: rgb8, jpeg)"
    )
