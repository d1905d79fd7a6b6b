"""A service as a process, for tests: ``python stubborn_service.py MODE`` + usual arguments."""

from __future__ import annotations

import sys
import threading

from fairlead.deploy import stop_signals
from fairlead.service import ServiceContext, announce_ready, run_service

MODE = sys.argv.pop(1)


def body(context: ServiceContext) -> None:
    """Wait to be stopped; ``deaf`` then hangs, ``thread`` hangs in a thread at the end.

    ``starting`` never becomes ready.
    """
    if MODE == "starting":
        print("not ready for a long time", flush=True)
        threading.Event().wait()
    announce_ready(context)
    context.stopping.wait()
    if MODE == "deaf":
        threading.Event().wait()
    if MODE == "thread":
        threading.Thread(target=threading.Event().wait).start()


if __name__ == "__main__":
    stop_signals.END_S = 0.5
    sys.exit(run_service("stubborn", body))
