"""JPEG pictures, by Pillow: made where a deployment says so, undone once where one is used.

JPEG is lossy: decoded pixels are near those that were rendered, not the same. The same bytes give
the same pixels in every process of one installation.
"""

from __future__ import annotations

import io

import numpy as np
import numpy.typing as npt
from msgspec.structs import replace
from PIL import Image as Pillow

from fairlead.errors import MessageError, expected
from fairlead.messages import Image


def as_jpeg(pixels: npt.NDArray[np.uint8], quality: int) -> bytes:
    """Pixels ``[height, width, 3]``, RGB, as JPEG; quality from 1 to 100, colours at full size."""
    file = io.BytesIO()
    whole = Pillow.fromarray(np.ascontiguousarray(pixels))
    whole.save(file, "JPEG", quality=quality, subsampling=0)
    return file.getvalue()


def decoded(image: Image) -> Image:
    """A JPEG picture as rgb8; any other as it is.

    Raises:
        MessageError: it is no JPEG of the size that it announces, in RGB.
    """
    if image.encoding_name != "jpeg":
        return image
    who, wanted = f"camera {image.camera}", f"a JPEG of {image.width} x {image.height}, RGB"
    try:
        with Pillow.open(io.BytesIO(image.data), formats=["JPEG"]) as file:
            if file.size != (image.width, image.height) or file.mode != "RGB":
                got = f"one of {file.size[0]} x {file.size[1]}, {file.mode}"
                raise MessageError(expected(who, wanted, got))
            data = file.tobytes()
    except (OSError, SyntaxError, ValueError, Pillow.DecompressionBombError) as error:
        raise MessageError(expected(who, wanted, f"no such: {error}")) from None
    return replace(image, encoding_name="rgb8", data=data)
