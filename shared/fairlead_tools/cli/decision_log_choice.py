"""Which decision log a command is about: of what runs here, or ran last."""

from __future__ import annotations

from pathlib import Path

from fairlead.deploy.registry import Registry
from fairlead.errors import NoAnswerError
from fairlead_tools.cli.deployment_choice import choose_running

_LOGS = "decisions/*.decisions"


def choose_decision_log(wanted: str | None, state_dir: Path | None) -> Path:
    """The newest log of the deployment that is named, runs, or ran last.

    Args:
        wanted: name or file of a deployment that runs.
        state_dir: state folder of one that need not run.

    Raises:
        NoAnswerError: there is none, with where it was looked for.
        ConfigError: several deployments run and none was named.
    """
    registry = Registry()
    if state_dir is not None:
        return _newest(state_dir, f"*/{_LOGS}")
    if wanted is not None or registry.entries():
        return _newest(Path(choose_running(wanted).state_dir), f"*/{_LOGS}")
    return _newest(registry.root, f"*/*/{_LOGS}")


def _newest(folder: Path, pattern: str) -> Path:
    found = sorted(folder.glob(pattern), key=lambda path: path.stat().st_mtime_ns)
    if not found:
        raise NoAnswerError(
            f"no decision log in {folder}/{pattern}; a running gate writes one; "
            "name another place: --state-dir DIR or --log FILE"
        )
    return found[-1]
