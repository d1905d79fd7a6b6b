"""Run with an interpreter that has lerobot: opens a LeRobotDataset and prints what is in it.

``python -m tests.peers.read_lerobot FOLDER``
"""

from __future__ import annotations

import importlib
import json
import sys


def main() -> None:
    """One JSON document: counts, the task, and every frame's state and action."""
    module = importlib.import_module("lerobot.datasets.lerobot_dataset")
    data = module.LeRobotDataset("fairlead/test", root=sys.argv[1])
    frames = [data[index] for index in range(len(data))]
    document = {
        "episodes": data.num_episodes,
        "fps": data.fps,
        "tasks": sorted({frame["task"] for frame in frames}),
        "episode_index": [int(frame["episode_index"]) for frame in frames],
        "state": [frame["observation.state"].tolist() for frame in frames],
        "action": [frame["action"].tolist() for frame in frames],
        "mean": data.meta.stats["action"]["mean"].tolist(),
        "cameras": data.meta.camera_keys,
    }
    if "released" in data.meta.features:
        document["released"] = [bool(frame["released"]) for frame in frames]
    for key in data.meta.camera_keys:  # from 0 to 1, colours first
        document[key] = [(frame[key] * 255).round().int().flatten().tolist() for frame in frames]
        document[f"{key} mean"] = data.meta.stats[key]["mean"].tolist()
    print(json.dumps(document))


if __name__ == "__main__":
    main()
