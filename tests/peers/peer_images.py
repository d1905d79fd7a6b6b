"""Run in the peers' environment: what openpi's own client makes of pictures.

Reads a JSON object a line from stdin: ``width``, ``height``, ``pixels`` (hex) and ``box``, the
width and height that they are brought to. Says as hex what ``resize_with_pad`` makes of them; of
pixels that are float32 from 0 to 1, with ``box`` null, what ``convert_to_uint8`` makes.
"""

from __future__ import annotations

import importlib
import json
import sys

import numpy as np


def main() -> None:
    """One line for each picture."""
    tools = importlib.import_module("openpi_client.image_tools")
    for line in sys.stdin:
        job = json.loads(line)
        data = bytes.fromhex(job["pixels"])
        shape = (job["height"], job["width"], 3)
        if job["box"] is None:
            made = tools.convert_to_uint8(np.frombuffer(data, "<f4").reshape(shape))
        else:
            width, height = job["box"]
            pixels = np.frombuffer(data, np.uint8).reshape(shape)
            made = tools.resize_with_pad(pixels, height, width)
        sys.stdout.write(f"{made.dtype} {list(made.shape)} {made.tobytes().hex()}\n")


if __name__ == "__main__":
    main()
