"""Every layout, one file each: a file put here is a layout, found by its name."""

from __future__ import annotations

import importlib
import pkgutil

from fairlead_state_assembler.registry import remember_example

for _found in pkgutil.iter_modules(__path__):
    remember_example(importlib.import_module(f"{__name__}.{_found.name}"), _found.name)
