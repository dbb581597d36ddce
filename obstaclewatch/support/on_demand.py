"""Public names of a package are loaded when the first is used.

Python runs a package's `__init__` before any module in it. A process that needs one of them alone is spared the
libraries that the others need.
"""

from __future__ import annotations

import sys
from collections.abc import Callable
from importlib import import_module
from typing import Any


def loaded_on_demand(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """`__getattr__` and `__dir__` of a package whose public names are those of its module `public`.

    >>> found, listed = loaded_on_demand("obstaclewatch")
    >>> found("BeepDesign").__name__
    'BeepDesign'
    >>> "BeepDesign" in listed()
    True
    """

    def found(name: str) -> Any:
        if name == "__all__" or not name.startswith("_"):
            public, own = import_module(f"{package}.public"), vars(sys.modules[package])
            if name == "__all__" or name in public.__all__:
                return getattr(public, name)
            if name in own:  # a room, which was imported with them
                return own[name]
        raise AttributeError(f"module '{package}' has no attribute '{name}'")

    def listed() -> list[str]:
        return sorted({*vars(sys.modules[package]), *found("__all__")})

    return found, listed
