"""Is what the gate releases safe, and does it release what is good?

    .venv/bin/python -m bench.soundness [--chunks 100000] [--rows 5000] [--first 0] [--write]

Three campaigns for each robot, against the real core. Of adversarial chunks every row that the gate
lets act is followed by pinocchio and numpy, tick by tick: at both ends of each mode's gain, in its
middle and at random shares. Nowhere on the way, nor where a hold would end, may it break a bound,
leave the workspace, touch itself or leave the zones. More of them run in the real simulator, whose
state is held against the same rules. Then the scripted demonstrations, of which nothing may be
refused. Exits 1 on any breach, and if more than 0.1 % of the good chunks were refused.
"""

from __future__ import annotations

import argparse
import json
import sys
import tempfile
from datetime import UTC, datetime
from pathlib import Path

from bench.page import Write
from bench.soundness.demonstrations import SKILLS
from bench.soundness.results import Amount, Results, run_all
from bench.soundness.table import document, tables, write
from fairlead.paths import repo_root

PAGE = Path("docs/soundness.md")
SHARES = {
    "panda_mobile": 0.2,
    "panda": 0.3,
    "dual_panda": 0.15,
    "ur5e": 0.125,
    "kinova3": 0.1,
    "so101": 0.125,
}
MOST_REFUSED = 0.001


def main() -> int:
    """Run and print; 1 where something is not as it has to be."""
    parser = argparse.ArgumentParser(
        prog="python -m bench.soundness",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--robot", choices=SKILLS, action="append", help="only this one")
    parser.add_argument("--chunks", type=int, default=100_000, help="judged, all robots together")
    parser.add_argument("--rows", type=int, default=5_000, help="executed by each robot")
    parser.add_argument("--episodes", type=int, default=50, help="demonstrations of each robot")
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first block: another has other seeds"
    )
    parser.add_argument("--workers", type=int, default=2, help="processes (default: %(default)s)")
    parser.add_argument(
        "--keep", type=Path, help="folder of finished blocks; what is there is not done again"
    )
    parser.add_argument("--write", action=Write, page=PAGE, help=f"write {PAGE}'s tables")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    arguments = parser.parse_args()
    amounts = {
        robot: Amount(
            round(arguments.chunks * SHARES[robot]),
            arguments.rows,
            arguments.episodes,
            arguments.first,
        )
        for robot in arguments.robot or SHARES
    }
    keep = arguments.keep or Path(tempfile.mkdtemp(prefix="soundness-"))
    results = run_all(amounts, arguments.workers, keep, _say)
    amount = f"--chunks {arguments.chunks} --rows {arguments.rows} --episodes {arguments.episodes}"
    command = f"python -m bench.soundness {amount} --first {arguments.first}"
    text = tables(results, command, f"{datetime.now(UTC):%Y-%m-%d}")
    print(json.dumps(document(results), indent=1) if arguments.json else text)
    if arguments.write:
        write(repo_root() / PAGE, text)
    return 0 if all(_is_sound(one) for one in results) else 1


def _is_sound(one: Results) -> bool:
    refused = sum(one.usability.refused.values()) / max(1, one.usability.chunks)
    breaches = one.kinematic.breaches.total() + one.simulated.breaches.total()
    return breaches == 0 and refused <= MOST_REFUSED and not one.usability.stops


def _say(what: str) -> None:
    print(f"soundness: {what}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
