"""Import robosuite without its start-up notes, and keep its loggers at ERROR.

Import this module before any module of robosuite: its notes about optional packages are
printed while it is being imported.
"""

from __future__ import annotations

import logging

logging.disable(logging.WARNING)
try:
    import robosuite
    from robosuite.utils.log_utils import ROBOSUITE_DEFAULT_LOGGER
finally:
    logging.disable(logging.NOTSET)

ROBOSUITE_DEFAULT_LOGGER.setLevel(logging.ERROR)

__all__ = ["robosuite"]
