"""``fairlead``: runs a command line, errors without tracebacks.

Exit codes: 0 it worked, 1 it was refused or failed, 2 the command line was wrong, 130 it was
interrupted (Ctrl-C). With ``--json`` an error of exit code 1 is a JSON document on standard output:
``{"error": {"kind": ..., "message": ..., "fix": ...}}``.
"""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path

from fairlead.errors import FairleadError, RefusedError

INTERRUPTED = 130  # what typer and a shell say after Ctrl-C


def main() -> None:
    """Entry point of the ``fairlead`` command."""
    try:
        # Imported here: it takes a moment, in which Ctrl-C is no error either.
        from fairlead.cli.app import app

        app(prog_name="fairlead")
    except KeyboardInterrupt:
        _end("interrupted", INTERRUPTED)
    except SystemExit as end:
        if end.code == INTERRUPTED:
            print("interrupted", file=sys.stderr)
        raise
    except FairleadError as error:
        if "--json" in sys.argv[1:]:
            _print_document(error)
            sys.exit(1)
        _end(f"ERROR {error}", 1)
    except OSError as error:  # a full disk, a folder that may not be written
        where = f"{error.filename}: " if error.filename else ""
        _forget_output()
        _end(f"ERROR {where}{error.strerror or error}", 1)


def _print_document(error: FairleadError) -> None:
    told = {"kind": type(error).__name__, "message": str(error)}
    fix = error.fix if isinstance(error, RefusedError) else ""
    print(json.dumps({"error": told | {"fix": fix}}, indent=2))


def _forget_output() -> None:
    """What could not be written is not tried again at exit: that would be another error."""
    with Path(os.devnull).open("w", encoding="utf-8") as nowhere:
        os.dup2(nowhere.fileno(), sys.stdout.fileno())


def _end(text: str, code: int) -> None:
    print(text, file=sys.stderr)
    sys.exit(code)


if __name__ == "__main__":
    main()
