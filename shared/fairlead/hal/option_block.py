"""The ``options`` block of a HAL in a deployment file."""

from __future__ import annotations

from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from fairlead.errors import ConfigError

Options = TypeVar("Options", bound=BaseModel)


def check_option_block(service: str, model: type[Options], options: dict[str, Any]) -> Options:
    """Check a service's ``options`` block against its model.

    Raises:
        ConfigError: naming each option that does not fit, and the valid ones.
    """
    try:
        return model.model_validate(options)
    except ValidationError as error:
        lines = [
            f"  {'.'.join(str(place) for place in item['loc'])}: {item['msg']}, "
            f"got {item['input']!r}"
            for item in error.errors()
        ]
        valid = ", ".join(model.model_fields)
        raise ConfigError(
            f"{service}: options do not fit (valid: {valid}):\n" + "\n".join(lines)
        ) from None
