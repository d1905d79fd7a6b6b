"""``fairlead serve-policy`` as a process."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

VARIABLE = "FAIRLEAD_TEST_SERVER_KEY"


@contextmanager
def served(skill: str, key: str = "") -> Iterator[str]:
    """Its address, from when it says that it listens."""
    command = [str(Path(sys.executable).with_name("fairlead")), "serve-policy", skill]
    command += ["--port", "0", *(["--api-key-env", VARIABLE] if key else [])]
    environment = os.environ | {VARIABLE: key, "PYTHONUNBUFFERED": "1"}
    with subprocess.Popen(
        command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    ) as server:
        try:
            assert server.stdout is not None
            said = server.stdout.readline()
            found = re.search(r"listening on (ws://\S+)", said)
            assert found, said + (server.stdout.read() if server.poll() is not None else "")
            yield found[1]
        finally:
            server.terminate()
