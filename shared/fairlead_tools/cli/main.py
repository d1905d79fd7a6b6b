"""``fairlead``: runs a command line, errors without tracebacks.

Exit codes: 0 it worked, 1 it was refused or failed, 2 the command line was wrong, 130 it was
interrupted (Ctrl-C). With ``--json`` an error is a JSON document on standard output:
``{"error": {"kind": ..., "message": ..., "fix": ...}}``.
"""

from __future__ import annotations

import io
import os
import sys
import warnings

NO_THREAD = "can't start new thread"  # what Python says
INTERRUPTED = 130  # what typer and a shell say after Ctrl-C
try:
    from fairlead.errors import FairleadError, RefusedError, expected
    from fairlead.wire.printable import printable_lines
    from fairlead_tools.cli.console import forget_output, print_json
except KeyboardInterrupt:  # they take a moment
    print("interrupted", file=sys.stderr)
    sys.exit(INTERRUPTED)


def main() -> None:
    """Entry point of the ``fairlead`` command."""
    as_json = "--json" in sys.argv[1:]
    _open_closed_streams()
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):  # what a terminal has no letter for is spelled out
            stream.reconfigure(errors="backslashreplace")
    try:
        _check_letters(as_json)
        _run(as_json)
    except KeyboardInterrupt:
        _leave_quietly()
        _end("interrupted", INTERRUPTED)
    except SystemExit as end:
        if end.code == INTERRUPTED:
            _leave_quietly()
            print("interrupted", file=sys.stderr)
        raise
    except FairleadError as error:
        if as_json:
            fix = error.fix if isinstance(error, RefusedError) else ""
            _end_json(type(error).__name__, str(error), fix, 1)
        _end(f"ERROR {error}", 1)
    except (OSError, RuntimeError) as error:
        _end_by_system(error, as_json)


def _end_by_system(error: OSError | RuntimeError, as_json: bool) -> None:
    """A full disk, a folder that may not be written, no room for a thread."""
    where = " ".join(["fairlead", *sys.argv[1:2]])
    if isinstance(error, OSError):
        said = f"{error.filename or where}: {error.strerror or error}"
        is_for_reader = as_json and bool(error.filename)  # else the output may not be writable
    elif str(error) == NO_THREAD:
        said = f"{where}: the system starts no more threads; its limits: ulimit -a"
        is_for_reader = as_json
    else:
        raise error
    if is_for_reader:
        _end_json("OSError", said, "", 1)
    forget_output()
    _end(f"ERROR {said}", 1)


def _open_closed_streams() -> None:
    """Where the caller closed one, nothing reads or is written; no socket gets its number."""
    for name, mode in (("stdin", "r"), ("stdout", "w"), ("stderr", "w")):
        if getattr(sys, name) is None:
            nothing = os.open(os.devnull, os.O_RDWR)  # gets the lowest number that is free
            os.set_inheritable(nothing, True)  # for a service that takes this process over
            setattr(sys, name, os.fdopen(nothing, mode, encoding="utf-8"))


def _check_letters(as_json: bool) -> None:
    """Words that are not UTF-8 fit no message; they are no reason not to stop."""
    if sys.argv[1:2] == ["stop"]:
        return
    for word in sys.argv[1:]:
        spelled = word.encode(errors="backslashreplace").decode()
        if spelled != word:
            said = expected("command line", "words in UTF-8", repr(spelled))
            if as_json:
                _end_json("UsageError", said, "fairlead --help", 2)
            _end(f"ERROR {said}", 2)


def _run(as_json: bool) -> None:
    # Imported here: it takes a moment, in which Ctrl-C is no error either.
    from typer.exceptions import Abort, TyperException

    from fairlead_tools.cli.app import app

    if not as_json:
        app(prog_name="fairlead")
    try:
        sys.exit(app(prog_name="fairlead", standalone_mode=False))
    except TyperException as error:  # a wrong command line
        fix = "fairlead --help"
        _end_json("UsageError", error.format_message(), fix, error.exit_code)
    except Abort:  # the answer to a question
        _end_json("Aborted", "not confirmed", "", 1)


def _leave_quietly() -> None:
    """At exit, nothing is said of a coroutine or event loop that Ctrl-C left half made."""
    warnings.simplefilter("ignore")
    sys.unraisablehook = lambda _: None


def _end_json(kind: str, message: str, fix: str, code: int) -> None:
    try:
        print_json({"error": {"kind": kind, "message": message, "fix": fix}})
    except OSError:  # a full disk, or nobody reads
        forget_output()
        _end(f"ERROR {message}", code)
    sys.exit(code)


def _end(text: str, code: int) -> None:
    print(printable_lines(text), file=sys.stderr)
    sys.exit(code)


if __name__ == "__main__":
    main()
