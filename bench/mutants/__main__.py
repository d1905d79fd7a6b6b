"""Do the tests of the gate's core notice when the core is wrong?

    python -m bench.mutants                    every mutant (make mutate)
    python -m bench.mutants shape.cpp codec    only those of some files
    python -m bench.mutants --json FILE        the fates as JSON besides
    python -m bench.mutants --update           list what survives as open in reviewed.json
    FAIRLEAD_MUTANT_JOBS=1                     how many run at once (2)

Exits 1 if a mutant survives that bench/mutants/reviewed.json does not explain, or if an
explanation there has no survivor any more.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import time
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from bench.mutants.hunt import Fate, Hunt
from bench.mutants.mutations import Mutant
from bench.mutants.population import ROOT, build, populate

BUILD = Path(os.environ.get("FAIRLEAD_MUTANT_BUILD", ROOT / "build/mutants"))
REVIEWED = Path(__file__).with_name("reviewed.json")
NOTICED = BUILD / "noticed.json"
PROGRESS_EVERY = 250
ALIVE = (Fate.SURVIVED, Fate.NOT_REACHED)


def key_of(mutant: Mutant) -> tuple[str, str, str]:
    """What stays the same when lines move."""
    return mutant.file, mutant.text, mutant.change


def reviewed() -> dict[str, dict[tuple[str, str, str], str]]:
    """Known survivors: ``equivalent`` ones with the reason, ``open`` ones with what is missing."""
    lists = json.loads(REVIEWED.read_text())
    return {
        kind: {(one["file"], one["text"], one["change"]): one["why"] for one in entries}
        for kind, entries in lists.items()
    }


def name_of(mutant: Mutant) -> str:
    """Its key as one text."""
    return " | ".join(key_of(mutant))


def past_notices(mutants: dict[int, Mutant]) -> dict[int, str]:
    """Which test noticed a mutant in the last run here: it is tried first, and decides nothing."""
    if not NOTICED.exists():
        return {}
    noticed = json.loads(NOTICED.read_text())
    return {i: noticed[name_of(one)] for i, one in mutants.items() if name_of(one) in noticed}


def keep_notices(mutants: dict[int, Mutant], noticed: dict[int, str]) -> None:
    """The same for the next run."""
    NOTICED.write_text(json.dumps({name_of(mutants[i]): test for i, test in noticed.items()}))


def print_fates(fates: dict[int, Fate], mutants: dict[int, Mutant]) -> None:
    """A row for each file and the total."""
    kinds = [Fate.KILLED, Fate.TIMED_OUT, Fate.SURVIVED, Fate.NOT_REACHED]
    print(f"{'file':24}" + "".join(f"{kind.value:>13}" for kind in kinds))
    for name in [*sorted({mutants[i].file for i in fates}), "total"]:
        counts = Counter(fate for i, fate in fates.items() if name in (mutants[i].file, "total"))
        print(f"{name:24}" + "".join(f"{counts[kind]:>13}" for kind in kinds))


def print_survivors(fates: dict[int, Fate], mutants: dict[int, Mutant], whole: bool) -> int:
    """Each survivor with its line and what is known of it; how many are unknown or outdated."""
    known = reviewed()
    alive = {i: mutants[i] for i, fate in fates.items() if fate in ALIVE}
    unknown = 0
    for number, mutant in alive.items():
        kind = next((k for k, entries in known.items() if key_of(mutant) in entries), None)
        unknown += kind is None
        print(f"\nservices/safety/src/core/{mutant.file}:{mutant.line}: {mutant.change}")
        print(f"    {mutant.text}")
        if kind:
            print(f"    {kind}: {known[kind][key_of(mutant)]}")
        else:
            print(f"    NEW; run it: FAIRLEAD_MUTANT={number} {BUILD}/fairlead-safety-tests")
    found = {key_of(mutant) for mutant in alive.values()}
    gone = [key for entries in known.values() for key in entries if whole and key not in found]
    for key in gone:
        print(f"\nno survivor any more, take it off {REVIEWED.name}: {' | '.join(key)}")
    return unknown + len(gone)


@dataclass
class Progress:
    """How far the hunt is, on standard error: each survivor at once, a line now and then."""

    mutants: dict[int, Mutant]
    total: int
    alive: int = 0

    def tell(self, count: int, number: int, fate: Fate) -> None:
        """One more is known."""
        if fate in ALIVE:
            self.alive += 1
            mutant = self.mutants[number]
            place = f"{mutant.file}:{mutant.line}"
            print(f"{fate.value}: {number} {place}: {mutant.change}", file=sys.stderr, flush=True)
        if count % PROGRESS_EVERY == 0 or count == self.total:
            done = f"{count} of {self.total} mutants, {self.alive} alive"
            print(f"[mutants] {done}", file=sys.stderr, flush=True)


def update(fates: dict[int, Fate], mutants: dict[int, Mutant]) -> None:
    """Rewrite the list of open survivors; what is explained stays where it is."""
    lists = json.loads(REVIEWED.read_text())
    explained = reviewed()["equivalent"]
    alive = sorted({key_of(mutants[i]) for i, fate in fates.items() if fate in ALIVE})
    why = reviewed()["open"]
    lists["open"] = [
        dict(zip(("file", "text", "change"), key, strict=True))
        | {"why": why.get(key, "not looked at yet")}
        for key in alive
        if key not in explained
    ]
    REVIEWED.write_text(json.dumps(lists, indent=1) + "\n")


def main() -> int:
    """The exit status."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.mutants",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="*", help="names of files of the core, or parts of names")
    parser.add_argument("--json", type=Path, help="write id, file, line, text, change and fate")
    parser.add_argument("--update", action="store_true", help="rewrite the list of open ones")
    options = parser.parse_args()
    if options.update and options.files:
        parser.error("--update needs every file")
    begun = time.monotonic()
    population = populate()
    program = build(population, BUILD)
    built = time.monotonic()
    wanted = {
        number: mutant.file
        for number, mutant in population.mutants.items()
        if not options.files or any(part in mutant.file for part in options.files)
    }
    search = Hunt(program, wanted, past_notices(population.mutants))
    progress = Progress(population.mutants, len(wanted))
    fates = search.run(int(os.environ.get("FAIRLEAD_MUTANT_JOBS", "2")), progress.tell)
    keep_notices(population.mutants, search.noticed)
    if options.update:
        update(fates, population.mutants)
    faults = print_survivors(fates, population.mutants, whole=not options.files)
    print()
    print_fates(fates, population.mutants)
    print(f"built in {built - begun:.0f} s, run in {time.monotonic() - built:.0f} s")
    if options.json:
        rows = [vars(population.mutants[i]) | {"id": i, "fate": f.value} for i, f in fates.items()]
        options.json.write_text(json.dumps(rows, indent=1))
    if faults:
        print(f"FAILED: {faults} mutants survive unexplained, or are explained and dead")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
