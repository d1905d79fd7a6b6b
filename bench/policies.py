"""Scripted, learned, remote and late policies on the same tasks: how often they succeed.

    .venv/bin/python -m bench.policies [--seeds 0:10] [--only TEXT] [--json] [--write]

Each line is one ``fairlead eval`` on a robot of its own. *remote*: the same policy behind
``fairlead serve-policy``, asked over openpi's protocol. --write puts the table into
docs/learned-policies.md.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from bench.page import Write, write_table
from fairlead.paths import deployment_path, repo_root
from fairlead.skill.manifest import skill_ids

PAGE = Path("docs/learned-policies.md")
FAIRLEAD = str(Path(sys.executable).with_name("fairlead"))
MOBILE, ARM = "panda_mobile_sim", "panda_mujoco"
EXPERT, LEARNED, REACH = "oracle-counter-to-cabinet", "bc-counter-to-cabinet", "panda-joint-reach"


@dataclass(frozen=True)
class Case:
    """One line of the table."""

    name: str
    skill: str
    deployment: str
    pacing: str = "realtime"
    latency_ms: float = 0.0
    remote: bool = False


CASES = (
    Case("scripted", EXPERT, MOBILE, "lockstep"),
    Case("scripted", EXPERT, MOBILE),
    Case("scripted, late", EXPERT, MOBILE, latency_ms=200.0),
    Case("learned", LEARNED, MOBILE, "lockstep"),
    Case("learned", LEARNED, MOBILE),
    Case("learned, remote", LEARNED, MOBILE, remote=True),
    Case("learned, late", LEARNED, MOBILE, latency_ms=200.0),
    Case("joint targets", REACH, ARM),
    Case("joint targets, late", REACH, ARM, latency_ms=200.0),
    Case("joint targets, late", REACH, ARM, latency_ms=400.0),
)


def evaluate(case: Case, seeds: str, folder: Path) -> dict[str, Any]:
    """The document of ``fairlead eval --json``.

    Raises:
        SystemExit: it failed; what it said is on standard error.
    """
    source = deployment_path(case.deployment)
    with served(case.skill) if case.remote else nullcontext("") as address:
        if address:
            source = asking(source, case.skill, address, folder)
        words = [
            FAIRLEAD, "eval", case.skill, "-d", str(source), "--seeds", seeds, "--json",
            "--pacing", case.pacing, "--latency-ms", str(case.latency_ms), "--reset-stops",
            "--out", str(folder / "out"),
        ]  # fmt: skip
        done = subprocess.run(words, stdout=subprocess.PIPE, text=True, check=False)
    if done.returncode:
        raise SystemExit(f"bench.policies: {case.name}: eval failed: {done.stdout[-500:]}")
    document: dict[str, Any] = json.loads(done.stdout)
    for one in document["episodes"]:
        if one["why"].startswith("policy_error"):
            raise SystemExit(f"bench.policies: {case.name}: seed {one['seed']}: {one['why']}")
    return document


def kept(keep: Path | None, case: Case, seeds: str) -> dict[str, Any]:
    """What `evaluate` found, now or before."""
    words = (case.name, case.skill, case.pacing, f"{case.latency_ms:g}", seeds)
    file = keep / f"{'_'.join(words).replace(' ', '-')}.json" if keep else None
    if file and file.is_file():
        before: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        return before
    with tempfile.TemporaryDirectory() as folder:
        found = evaluate(case, seeds, Path(folder))
    if file:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(json.dumps(found), encoding="utf-8")
    return found


@contextmanager
def served(skill: str) -> Iterator[str]:
    """The address of a server of the skill's policy."""
    words = [FAIRLEAD, "serve-policy", skill, "--port", "0"]
    with subprocess.Popen(words, stdout=subprocess.PIPE, text=True) as server:
        try:
            assert server.stdout is not None
            address = server.stdout.readline().split()[-1:]
            if not address:
                raise SystemExit(f"bench.policies: {' '.join(words)} ended: see above")
            yield address[0]
        finally:
            server.terminate()


def asking(source: Path, skill: str, address: str, folder: Path) -> Path:
    """A copy of a deployment whose runner asks that server instead of the skill's own policy."""
    content = yaml.safe_load(source.read_text(encoding="utf-8"))
    (runner,) = [one for one in content["services"].values() if one["run"] == "skill_runner"]
    options = {
        "address": address,
        "start": f"fairlead serve-policy {skill}",
        "connect_timeout_s": 4.0,
        "answer_timeout_s": 4.0,
    }
    policy = {"backend": "openpi", "options": options}
    runner["options"] = {"policies": {skill: policy}}
    copy = folder / source.name
    copy.write_text(yaml.safe_dump(content), encoding="utf-8")
    return copy


def row(case: Case, found: dict[str, Any]) -> str:
    """Markdown."""
    episodes = found["episodes"]
    refused: Counter[str] = Counter()
    for one in episodes:
        refused.update(one["refusals"])
    codes = ", ".join(f"{count} {code}" for code, count in sorted(refused.items())) or "-"
    ticks = f"{found['median_ticks']:g}" if found["median_ticks"] is not None else "-"
    cells = (
        f"{case.name.removesuffix(', late')}, {case.pacing}"
        f"{f', {case.latency_ms:g} ms late' if case.latency_ms else ''}",
        f"{found['succeeded']} of {len(episodes)}", ticks, codes,
        str(sum(one["stalls"] or 0 for one in episodes)),
    )  # fmt: skip
    return f"| {' | '.join(cells)} |"


HEADER = "| policy | succeeded | median ticks | refused or cut | stalls |\n|---|---|---|---|---|"


def main() -> int:
    """Evaluate and print."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.policies",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--seeds", default="0:10", help="as fairlead eval takes them")
    parser.add_argument("--only", default="", help="cases whose name has this in it")
    parser.add_argument(
        "--keep", type=Path, help="folder of finished cases, which are not done again"
    )
    parser.add_argument("--json", action="store_true", help="print the documents instead")
    parser.add_argument("--write", action=Write, page=PAGE, help=f"put the table into {PAGE}")
    args = parser.parse_args()
    if args.write and args.only:
        parser.error("--write: not with --only, the table has every case")
    known = set(skill_ids())
    lines, documents = [HEADER], []
    for case in CASES:
        if args.only not in case.name or case.skill not in known:
            continue
        print(f"bench.policies: {case.name}, {case.skill}, {case.pacing}", file=sys.stderr)
        found = kept(args.keep, case, args.seeds)
        lines.append(row(case, found))
        documents.append({"case": case.name, **found})
    text = "\n".join(lines)
    if args.write:
        write_table("policies", text, repo_root() / PAGE)
    print(json.dumps(documents, indent=2) if args.json else text)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
