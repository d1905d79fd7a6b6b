"""Options of `run: hal_sim` that were valid once."""

from __future__ import annotations

import pytest

from fairlead.errors import ConfigError
from fairlead_hal_sim import read_options


def test_a_backend_is_refused_naming_the_hal_to_run_instead() -> None:
    with pytest.raises(ConfigError) as caught:
        read_options("hal", {"backend": "kinematic"})
    text = str(caught.value)
    assert "backend: expected none, as `run` chooses the HAL, got 'kinematic' (valid: " in text
    assert "run: hal_kinematic" in text
