"""``fairlead robot distances``: how near a robot came to itself in a recorded run."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from fairlead.robot.capsules import load_capsules
from fairlead.robot.manifest import load_robot
from fairlead_tools.cli.console import echo, print_json, print_table
from fairlead_tools.cli.deployment_choice import JsonOption
from fairlead_tools.cli.robot_choice import RobotArgument

EXAMPLE = "fairlead robot distances panda_mobile out/demo/state/safety/decisions/000001.decisions"


def command(
    robot: RobotArgument,
    log: Annotated[Path, typer.Argument(help="decision log of a run, which the gate wrote")],
    as_json: JsonOption = False,
) -> None:
    """Print the smallest distance of each checked pair of capsules over a recorded run."""
    from fairlead.robot.capsule_distance import capsule_spans, pair_distances
    from fairlead.robot.description_tree import description_tree
    from fairlead.robot.link_poses import link_poses
    from fairlead_tools.shape.recorded_positions import recorded_positions

    manifest = load_robot(robot)
    file, measured = load_capsules(manifest), recorded_positions(manifest, log)
    columns = {name: measured[:, i] for i, name in enumerate(manifest.measured_joint_names)}
    spans = capsule_spans(file.capsules, link_poses(description_tree(manifest), columns))
    rows = sorted(
        (float(pair_distances(file.capsules, spans, *pair).min()), *pair)
        for pair in file.checked_pairs
    )
    links = [one.link for one in file.capsules]
    if as_json:
        print_json(
            [
                {"capsules": [i, j], "links": [links[i], links[j]], "least_m": least}
                for least, i, j in rows
            ]
        )
        return
    print_table(
        ("LEAST [m]", "PAIR", "LINKS"),
        [(f"{least:.4f}", f"{i}-{j}", f"{links[i]}, {links[j]}") for least, i, j in rows],
    )
    echo(f"\n{len(rows)} pairs over {len(measured)} recorded states of {robot}")
