"""Packages that only add to this one, imported where they are needed."""

from __future__ import annotations

import importlib
from typing import Any

from .errors import MissingPackage


def needed(package: str, for_what: str) -> Any:
    try:
        return importlib.import_module(package)
    except ImportError as error:
        name = package.partition(".")[0]
        raise MissingPackage(f"{for_what} needs {name}, which is not installed: pip install {name}, "
                             f"or on Debian apt install python3-{name}") from error
