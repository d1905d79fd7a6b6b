"""``fairlead parity``: a run, compared with training's own loop and with one process."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from typing import Annotated

import typer

from fairlead.deploy.deployment import Deployment, load_deployment
from fairlead.deploy.service_options import check_options
from fairlead.errors import ConfigError
from fairlead.operate.goal_run import GoalOptions
from fairlead.paths import deployment_path
from fairlead.skill.manifest import SkillManifest, load_skill
from fairlead_tools.cli.console import ProgressLine, echo, ends_like_ctrl_c, print_json, print_table
from fairlead_tools.cli.demo import SOURCE, CopiedOption
from fairlead_tools.cli.options import MAX_NUMBER, JsonOption, example
from fairlead_tools.cli.skill import installed_skill
from fairlead_tools.parity.deployed_episode import DeployedEpisode, deployed_episodes
from fairlead_tools.parity.episode_trace import Comparison, compare
from fairlead_tools.parity.local_episode import local_episode
from fairlead_tools.parity.plain_episodes import (
    PlainComparison,
    check_comparable,
    compare_with_plain,
)
from fairlead_tools.parity.random_episodes import random_episodes
from fairlead_tools.writable import require_writable

DEADLINE_TICKS = 800


@example("fairlead parity --seed 3")
def parity_command(
    seed: Annotated[int, typer.Option(min=0, max=MAX_NUMBER, help="of the first episode")] = 0,
    skill: Annotated[str, typer.Option(help="folder under rskills/")] = "oracle-counter-to-cabinet",
    deployment: CopiedOption = None,
    ticks: Annotated[int, typer.Option(min=1, help="longest episode")] = DEADLINE_TICKS,
    episodes: Annotated[int, typer.Option(min=1, max=1000, help="of as many seeds")] = 1,
    random_scale: Annotated[
        float | None,
        typer.Option(
            "--random", min=0.0, max=1.0,
            help="random vectors of this scale, through all but the gate; 1: full scale",
        ),
    ] = None,
    policy: Annotated[
        bool,
        typer.Option("--policy", help="only what the policy sees and says, pictures included"),
    ] = False,
    out: Annotated[
        Path, typer.Option(file_okay=False, help="folder for traces and logs, made anew")
    ] = Path("out/parity"),
    as_json: JsonOption = False,
) -> None:  # fmt: skip
    """Run episodes through the services and again in plain robosuite; compare every bit.

    Plain robosuite is a loop of env.step with the policy's raw vectors, in a process that knows
    nothing of the HAL. Compared are the vectors given to env.step and the simulator's qpos and
    qvel, up to the first tick held inside an episode: training knows no holds. Observations, hashes
    of the pictures that the policy gets, and actions are computed again in one process. Ports and
    state folder are its own; a running robot is not disturbed. Random vectors go through dispatch
    and the HAL in one process: the gate would refuse most of them.
    """
    if policy and random_scale is not None:
        raise ConfigError("parity: --policy and --random: random vectors have no policy")
    manifest = load_skill(installed_skill(skill))
    source = deployment or deployment_path(f"{SOURCE}_cameras" if manifest.images else SOURCE)
    loaded = load_deployment(source)
    check_comparable(loaded, manifest)
    wish = GoalOptions(manifest.id, deadline_ticks=ticks)
    seeds = range(seed, seed + episodes)
    if random_scale is not None:
        deployed = random_episodes(loaded, manifest, random_scale, seeds, ticks)
    else:
        require_writable("parity: --out", out)
        with ends_like_ctrl_c(), ProgressLine(quiet=as_json) as line:
            deployed = deployed_episodes(
                source, wish, seeds, out / "state", lambda now: line.show(now.line())
            )
    plain = [] if policy else compare_with_plain(loaded, manifest, deployed)
    left = [] if random_scale is not None else [one.seed for one in deployed if _is_held(one)]
    again = [] if random_scale is not None else _again(loaded, manifest, deployed)
    compared = bool(again) if policy else any(one.compared for one in plain)
    same = compared and all(one.same for one in plain) and all(row.same for row in again)
    judged = deployed if plain else []
    lossy = _lossy(loaded, manifest)
    if as_json:
        print_json({"same": same, "policy": _rows(again), "held_seeds": left,
                    "episodes": _documents(plain, judged), "lossy_cameras": lossy})  # fmt: skip
    else:
        _print(again, plain, same, compared)
        if left:
            echo(
                f"in one process {episodes - len(left)} of {episodes} episodes were compared; "
                f"ticks were held in those of seed {', '.join(map(str, left))}"
            )
        for camera in lossy:
            echo(
                f"camera {camera} sends JPEG, which is lossy: pictures are compared as decoded, "
                "and are not the pixels that were rendered"
            )
    if not same:
        raise typer.Exit(1)


def _again(
    deployment: Deployment, skill: SkillManifest, deployed: list[DeployedEpisode]
) -> list[Comparison]:
    """What the policy saw and said, computed in one process where no tick was held."""
    found = []
    for one in deployed:
        if not _is_held(one):
            steps = len(one.trace.packed)
            local = local_episode(deployment, skill, one.seed, one.reset, steps)
            pictures = ("pictures",) if skill.images else ()
            found += compare(one.trace, local, ("observations", *pictures, "actions"))
    return found


def _is_held(one: DeployedEpisode) -> bool:
    """Whether a tick inside the episode was."""
    return any(one.trace.held[one.reset.held_ticks :])


def _lossy(deployment: Deployment, skill: SkillManifest) -> list[str]:
    """Cameras of the skill that send JPEG."""
    from fairlead_hal_sim import HalSimOptions

    hal = deployment.only("hal_sim")
    cameras = check_options(deployment, hal, HalSimOptions).cameras
    wanted = {spec.camera for spec in skill.images.values()}
    return [one.name for one in cameras if one.jpeg_quality and one.name in wanted]


def _rows(rows: list[Comparison]) -> list[dict[str, object]]:
    return [dataclasses.asdict(row) | {"same": row.same} for row in rows]


def _documents(
    plain: list[PlainComparison], deployed: list[DeployedEpisode]
) -> list[dict[str, object]]:
    return [
        dataclasses.asdict(one)
        | {"rows": _rows(one.rows), "same": one.same, "succeeded": other.trace.succeeded}
        for one, other in zip(plain, deployed, strict=True)
    ]


def _print(
    again: list[Comparison], plain: list[PlainComparison], same: bool, compared: bool
) -> None:
    header = ("SEED", "QUANTITY", "DEPLOYED", "BESIDE IT", "")
    table = [
        (
            str(one.seed),
            _NAMES[row.quantity],
            row.deployed,
            row.local,
            row.difference or "identical",
        )
        for one in plain
        for row in one.rows
    ]
    table += [
        ("", _NAMES[row.quantity], row.deployed, row.local, row.difference or "identical")
        for row in again
    ]
    print_table(header, table)
    for one in plain:
        held = f"{one.held} ticks held inside the episode"
        if one.held:
            held += f", after which qpos is up to {one.apart:.3g} from plain robosuite's"
        echo(f"seed {one.seed}: {one.compared} of {one.ticks} rows compared; {held}")
    verdict = "identical, bit for bit" if same else "DIFFERENT"
    if not compared:
        verdict = "NOTHING COMPARED: ticks were held"
    beside = f"plain robosuite and {len(plain)} episode(s)" if plain else "deployed and in process"
    echo(f"{beside}: {verdict}")


_NAMES = {
    "packed": "vectors to env.step",
    "qpos": "qpos",
    "qvel": "qvel",
    "observations": "observations, in one process",
    "pictures": "pictures, in one process",
    "actions": "actions, in one process",
}
