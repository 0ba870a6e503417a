"""Settings: made from presets and values, and checked."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from footfix.config import nested, presets, read_preset
from footfix.errors import ArgumentError
from footfix.settings import Layer, Settings
from footfix.settings import compose as settings_of

__all__ = ["check_settings", "make_settings", "presets"]


def make_settings(preset: str | None = None, values: Mapping[str, Any] | None = None) -> Settings:
    """Make settings from a preset and from values, as a config file and `--set` do.

    Examples:
        >>> make_settings("video", {"detect.method": "threshold"}).detect.method
        'threshold'

    Args:
        preset: one of `presets()`.
        values: dotted names, or groups of them as mappings, over the preset.

    Raises:
        UsageError: an unknown preset or setting, or a value of the wrong kind; says which ones there are.
    """
    layers = [] if preset is None else [Layer(f"preset {preset}", read_preset(preset))]
    layers += [Layer("values", nested(name, value)) for name, value in (values or {}).items()]
    return settings_of(layers)


def check_settings(settings: Any) -> Settings:
    """Raise if this is no valid Settings value.

    Args:
        settings: what was given; None stands for the defaults.

    Returns:
        The settings.

    Raises:
        ArgumentError: it is a mapping, a name or something else.
    """
    if settings is None:
        return Settings()
    if isinstance(settings, (dict, str)):
        raise ArgumentError(f"Settings are wanted, not {settings!r}; footfix.make_settings(preset, values) makes them")
    if not isinstance(settings, Settings):
        raise ArgumentError(f"Settings are wanted, not {type(settings).__name__}")
    return settings
