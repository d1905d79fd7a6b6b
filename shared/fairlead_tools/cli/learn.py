"""``fairlead dataset``, ``export`` and ``train``: from recorded episodes to a policy."""

from __future__ import annotations

from contextlib import closing
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import msgspec
import typer

from fairlead.deploy.deployment import load_deployment
from fairlead.errors import ConfigError, expected
from fairlead.paths import deployment_path
from fairlead.robot.manifest import load_robot
from fairlead.skill.admission import Admission
from fairlead.skill.manifest import load_skill
from fairlead_tools.cli.console import (
    ProgressLine,
    echo,
    ends_like_ctrl_c,
    print_json,
    print_table,
)
from fairlead_tools.cli.evaluate import MAX_EPISODES, parse_seeds
from fairlead_tools.cli.options import (
    JsonOption,
    SkillArgument,
    complete_skill,
    deployment_option,
    example,
    make_group,
)
from fairlead_tools.cli.skill import installed_skill
from fairlead_tools.writable import require_writable

if TYPE_CHECKING:
    from fairlead_tools.learn.dataset import Header
    from fairlead_tools.learn.record import Teacher

DATASETS = Path("out/datasets")
MAX_SEED = 2**32 - 1  # scikit-learn's
SOURCE, CLONED = "panda_mobile_sim", "oracle-counter-to-cabinet"
DatasetArgument = Annotated[Path, typer.Argument(help="a folder that dataset record made")]


@example("fairlead dataset record oracle-counter-to-cabinet --episodes 20")
def record_command(
    skill: SkillArgument,
    seeds: Annotated[
        str | None,
        typer.Option(metavar="FIRST:END", help="0:20 is 0 to 19; or single ones: 3,5,8"),
    ] = None,
    episodes: Annotated[
        int | None,
        typer.Option(min=1, max=MAX_EPISODES, help="of the first so many seeds, from 0 on"),
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option(file_okay=False, help="a new folder; default: out/datasets/SKILL"),
    ] = None,
    noise: Annotated[
        float,
        typer.Option(
            min=0.0,
            max=1.0,
            help="added to the rows: in each episode up to this standard deviation, of full scale",
        ),
    ] = 0.0,
    ticks: Annotated[int, typer.Option(min=1, help="longest episode")] = 500,
    expert: Annotated[
        str | None,
        typer.Option(help="a scripted skill, asked in each tick", autocompletion=complete_skill),
    ] = None,
    beta: Annotated[
        float,
        typer.Option(min=0.0, max=1.0, help="share of the answers that the expert acts out"),
    ] = 1.0,
    deployed: Annotated[
        bool,
        typer.Option(
            "--deployed", help="through the services and the gate, in lockstep; logs in OUT-state"
        ),
    ] = False,
    deployment: Annotated[
        Path | None,
        deployment_option(
            "--deployment", "-d", what="whose robot and simulator: ", without="panda_mobile_sim"
        ),
    ] = None,
) -> None:
    """Record SKILL in simulated episodes: states, rows, what acted, success.

    In one process no gate judges; what it would refuse is recorded too. With --deployed it does,
    and of each row is recorded whether it was released. With --expert, what it would do is recorded
    beside, and with --beta 1 it acts and SKILL only sees.
    """
    from fairlead_tools.learn.dataset import add, begin
    from fairlead_tools.learn.record import record
    from fairlead_tools.learn.record_deployed import record_deployed

    if seeds is None and episodes is None:
        one_of = "--episodes N, --seeds FIRST:END or both"
        raise ConfigError(expected("dataset record", one_of, "neither"))
    wanted = parse_seeds(f"0:{episodes}" if seeds is None else seeds)[:episodes]
    source = deployment or deployment_path(SOURCE)
    chosen = load_deployment(source)
    manifest = load_skill(installed_skill(skill))
    out = out or DATASETS / manifest.id
    Admission(manifest, load_robot(chosen.robot)).require()
    require_writable("dataset record: --out", out)
    teacher = _teacher(expert, beta, noise, deployed)
    header = begin(out, manifest, chosen.robot, noise, expert or "", deployed=deployed)
    with ProgressLine() as line:

        def show(seed: int, tick: int) -> None:
            done = header.episodes
            won = sum(one.succeeded for one in done)
            count = f"{len(done) + 1} of {len(wanted)}, {won} succeeded"
            line.show(f"seed {seed}, {count} | tick {tick}")

        runs = (
            record_deployed(
                source, manifest, wanted, ticks, out.with_name(f"{out.name}-state"), show
            )
            if deployed
            else record(chosen, manifest, wanted, noise, ticks, show, teacher)
        )
        try:
            with ends_like_ctrl_c(), closing(runs):
                for episode in runs:
                    header = add(out, header, episode)
        finally:
            line.end()
            _tell(out, header, len(wanted))


def _tell(out: Path, header: Header, wanted: int) -> None:
    """Say what there is, also of a recording that was ended before."""
    won, done = sum(one.succeeded for one in header.episodes), len(header.episodes)
    missing = f", {wanted - done} not recorded" if done < wanted else ""
    if done:
        echo(f"{out}: {won} of {done} episodes succeeded{missing}")


def _teacher(expert: str | None, beta: float, noise: float, deployed: bool) -> Teacher | None:
    """Of these options of dataset record.

    Raises:
        ConfigError: they do not go together.
    """
    from fairlead_tools.learn.record import Teacher

    if beta != 1.0 and expert is None:
        raise ConfigError(expected("dataset record: --beta", "--expert SKILL with it", "none"))
    if deployed and (noise or expert):
        wanted = "no --noise and no --expert: they are of one process"
        got = "--noise" if noise else "--expert"
        raise ConfigError(expected("dataset record: --deployed", wanted, got))
    return Teacher(load_skill(installed_skill(expert)), beta) if expert else None


@example("fairlead dataset show out/dataset")
def show_command(dataset: DatasetArgument, as_json: JsonOption = False) -> None:
    """Say what a dataset holds, after reading all of it: an error names what is not whole."""
    from fairlead_tools.learn.dataset import episodes, read_header

    header = read_header(dataset)
    for _ in episodes(dataset):
        pass
    if as_json:
        print_json(msgspec.to_builtins(header))
        return
    rows = [
        (one.seed, one.ticks, "-" if one.released is None else one.released,
         "yes" if one.succeeded else "no")
        for one in header.episodes
    ]  # fmt: skip
    print_table(("SEED", "TICKS", "RELEASED", "SUCCEEDED"), rows)
    echo(
        f"{header.skill} on {header.robot}, {header.layout} at {header.rate_hz:g} Hz, noise "
        f"{header.noise:g}: {len(rows)} episodes, {sum(row[1] for row in rows)} ticks"
        + ("" if header.deployed else ", no gate judged them")
    )


@example("fairlead export lerobot out/dataset out/lerobot")
def lerobot_command(
    dataset: DatasetArgument,
    target: Annotated[Path, typer.Argument(help="a new folder", file_okay=False)],
    failed: Annotated[
        bool, typer.Option("--failed", help="also episodes that did not succeed")
    ] = False,
) -> None:
    """Write a dataset as a LeRobotDataset, format v3.0; its actions are what acted.

    Of deployed episodes it also says in which ticks that was a released row.
    """
    from fairlead_tools.learn.dataset import read_header
    from fairlead_tools.learn.lerobot_export import export_lerobot

    skill = load_skill(read_header(dataset).skill)
    count = export_lerobot(dataset, target, skill, failed)
    echo(f"{target}: {count} episodes")


@example("fairlead train out/dataset --out rskills/my-policy")
def train_command(
    datasets: Annotated[list[Path], typer.Argument(help="folders that dataset record made")],
    out: Annotated[Path, typer.Option(file_okay=False, help="the skill that is made")],
    expert: Annotated[
        str | None,
        typer.Option(
            help=f"the scripted skill that is cloned; default: {CLONED}; not with pictures",
            autocompletion=complete_skill,
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, max=MAX_SEED, help="of all that is drawn")] = 0,
    beside: Annotated[
        int | None,
        typer.Option(
            min=0,
            help="states beside each second recorded one, labelled too; default: 5; not with "
            "pictures",
        ),
    ] = None,
    epochs: Annotated[
        int | None,
        typer.Option(min=1, help="how often each label is seen; default: 60, with pictures 30"),
    ] = None,
) -> None:
    """Clone a scripted skill from recorded episodes into a new skill with an ONNX policy.

    The expert is asked in each recorded state, so episodes of the clone itself teach it too. Of
    episodes with a picture, what dataset record --expert wrote down is learned.
    """
    from fairlead_tools.learn.dataset import read_header

    if read_header(datasets[0]).pictures:
        from fairlead_tools.learn.train_sight import SightRecipe, train_sight

        for option, value in (("--expert", expert), ("--beside", beside)):
            if value is not None:
                wanted = "it only for datasets without pictures, whose states it labels"
                raise ConfigError(expected(f"train: {option}", wanted, value))
        train_sight(datasets, SightRecipe(seed, epochs or SightRecipe.epochs), out, echo)
    else:
        from fairlead_tools.learn.train import Recipe, train

        states = Recipe.beside if beside is None else beside
        recipe = Recipe(seed, states, epochs or Recipe.epochs)
        train(datasets, load_skill(expert or CLONED), recipe, out, echo)


dataset_group = make_group(
    "dataset", "Record episodes to learn from.", {"record": record_command, "show": show_command}
)
export_group = make_group(
    "export", "Write a dataset in another's format.", {"lerobot": lerobot_command}
)
