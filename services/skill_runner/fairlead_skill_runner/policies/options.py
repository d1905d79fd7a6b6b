"""Check a policy's ``options`` block, naming every field that does not fit."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TypeVar

from pydantic import BaseModel, JsonValue, ValidationError

from fairlead.errors import ConfigError

Options = TypeVar("Options", bound=BaseModel)


def check_options(who: str, model: type[Options], options: Mapping[str, JsonValue]) -> Options:
    """Validate ``options`` as ``model``.

    Raises:
        ConfigError: saying who complains, and about which fields.
    """
    try:
        return model.model_validate(dict(options))
    except ValidationError as error:
        problems = [
            f"{'.'.join(str(part) for part in item['loc']) or 'options'}: {item['msg']}"
            for item in error.errors()
        ]
        raise ConfigError(f"{who}: {'; '.join(problems)}") from None
