"""Where the gate's own code takes every link to be."""

from __future__ import annotations

import subprocess
from pathlib import Path

import numpy as np

from fairlead.messages import FloatArray
from fairlead.paths import gate_binary


def gate_links(config: Path, positions: FloatArray, velocities: FloatArray) -> FloatArray:
    """What the gate's own code says: [samples, links, 13]."""
    tool = gate_binary().with_name("link-poses")
    sent = np.hstack([positions, velocities]).astype("<f8").tobytes()
    answer = subprocess.run([tool, config], input=sent, stdout=subprocess.PIPE, check=True)
    return np.frombuffer(answer.stdout, "<f8").reshape(len(positions), -1, 13)
