"""Prints the sentences of the two records and their tests, or writes them into docs/records.md.

python -m tests.records            # the page, in Markdown
python -m tests.records --write    # into docs/records.md
python -m tests.records --json     # as data
"""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict

from tests.records.page import PAGE, current_page, sentences


def main() -> None:
    """What the page says, from the tests."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--write", action="store_true", help="write it into docs/records.md")
    parser.add_argument("--json", action="store_true", help="print one JSON document instead")
    arguments = parser.parse_args()
    if arguments.write:
        PAGE.write_text(current_page())
        print(f"records: written into {PAGE}")
    else:
        one = [asdict(sentence) for sentence in sentences()]
        print(json.dumps(one, indent=2) if arguments.json else current_page())


if __name__ == "__main__":
    main()
