"""Names of the public contract go on being importable from the modules in which they stood before the rooms."""

from __future__ import annotations

import sys
from collections.abc import Mapping


def keep(package: str, places: Mapping[str, str]) -> None:
    """Let `from package.old import name` find what now stands in `package.new`, which is loaded already.

    Args:
        package: name of the package.
        places: old name of a module to its new one, both within the package.

    Raises:
        KeyError: the new module is not loaded.
    """
    for old, new in places.items():
        sys.modules[f"{package}.{old}"] = sys.modules[f"{package}.{new}"]
