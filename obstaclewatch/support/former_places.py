"""Names of the public contract go on being importable from the modules in which they stood before the rooms."""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType


class FormerPlaces(MetaPathFinder, Loader):
    """Finds modules under their old names.

    Args:
        places: old name of a module to its new one.
    """

    def __init__(self, places: Mapping[str, str]) -> None:
        self._places = places

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        """This is the loader of old names."""
        return ModuleSpec(fullname, self) if fullname in self._places else None

    def exec_module(self, module: ModuleType) -> None:
        """Put the module with the new name in the place of an empty one."""
        sys.modules[module.__name__] = import_module(self._places[module.__name__])


def keep(package: str, places: Mapping[str, str]) -> None:
    """Let `from package.old import name` find what now stands in `package.new`.

    Args:
        package: name of the package.
        places: old name of a module to its new one, both within the package.
    """
    sys.meta_path.append(FormerPlaces({f"{package}.{old}": f"{package}.{new}" for old, new in places.items()}))
