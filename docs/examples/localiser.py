"""A localiser: says at every tick where ``odom`` is in ``map``.

    python docs/examples/localiser.py DEPLOYMENT NAME X_M Y_M

This one was told. A real one has found out; how to send it is the same.
"""

from __future__ import annotations

import argparse
import signal
import threading
from pathlib import Path

from fairlead import Qos, Sample, ZenohBus, load_deployment
from fairlead.messages import Transform, TransformBatch, decode, pack_floats


def main(deployment: str, name: str, x_m: float, y_m: float) -> None:
    """Answer each tick of the HAL with the transform of the same tick."""
    loaded = load_deployment(Path(deployment))
    bus = ZenohBus(loaded.tool_endpoints(name))
    tf = bus.publisher(loaded.keys.tf(name), TransformBatch, Qos.HOT)
    T_map_odom = Transform(
        parent="map",
        child="odom",
        translation=pack_floats([x_m, y_m, 0.0]),
        rotation_xyzw=pack_floats([0.0, 0.0, 0.0, 1.0]),
    )

    def on_transforms(sample: Sample) -> None:
        hal = decode(TransformBatch, sample.payload)
        if not hal.is_static:
            batch = TransformBatch(
                session=hal.session, tick=hal.tick, is_static=False, transforms=(T_map_odom,)
            )
            tf.put(batch)

    bus.subscribe(loaded.keys.tf(loaded.hal), on_transforms)
    stopping = threading.Event()
    signal.signal(signal.SIGTERM, lambda *_: stopping.set())
    stopping.wait()
    bus.close()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="A localiser: says at every tick where odom is.")
    parser.add_argument("deployment")
    parser.add_argument("name")
    for number in ("x_m", "y_m"):
        parser.add_argument(number, type=float)
    main(**vars(parser.parse_args()))
