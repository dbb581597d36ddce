"""Compiled functions are kept for the next start until any source that they are made of changes.

numba compares the file of a function alone, although what it calls in other files is compiled into it: after an update
of those it would go on computing by the old ones. Here the stamp of a stored function is that of its file and of all
files of these packages that this one imports, directly and through others. Importing this module is enough; functions
of other libraries are stored as before.
"""

from __future__ import annotations

import hashlib
import re
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

from numba.core import caching, config

PACKAGES = ("obstaclewatch", "simulator", "scenes", "benchmarks")
PLACES = (caching.UserProvidedCacheLocator, caching.InTreeCacheLocator, caching.UserWideCacheLocator)
"""numba's own, in its own order: where its settings say, beside the source, in the user's folder."""
SETTING = "CACHE_LOCATOR_CLASSES"
OTHERS = [*(place.__name__ for place in PLACES), "IPythonCacheLocator", "ZipCacheLocator"]
"""What numba asks where nothing is set."""
MODULE = rf"(?:{'|'.join(PACKAGES)})[\w.]*"
IMPORT = re.compile(rf"^[ \t]*(?:from|import)[ ]+({MODULE})(?:[ ]+import[ ]+([\w ,]+|\([\w\s,]+\)))?", re.MULTILINE)
"""A module of these packages, and what is taken from it: modules, too."""
WORD = re.compile(r"\w+")


class SourcesLocator:
    """Whom numba asks for the place and the stamp of a compiled function (its NUMBA_CACHE_LOCATOR_CLASSES)."""

    @staticmethod
    def from_function(function: Callable[..., Any], file: str) -> Any:
        """For a function of these packages, numba's locator with a stamp over all its sources; else None.

        Raises:
            OSError: no place can be written: without one every start would compile for minutes.
        """
        if function.__module__.partition(".")[0] not in PACKAGES:
            return None
        found = next(filter(None, (place.from_function(function, file) for place in PLACES)), None)
        if found is None:
            raise OSError(
                f"compiled functions must be stored beside '{file}' or in the user's cache, and neither can be "
                "written: name a folder in NUMBA_CACHE_DIR"
            )
        root = Path(file).parents[function.__module__.count(".")]
        found.get_source_stamp = partial(sources_stamp, root, Path(file))
        line, stamp = found.get_disambiguator(), sources_stamp(root, Path(file)).hex()
        # The file's name depends on the sources as well: numba looks at the stamp only after it has unpickled
        # classes of theirs, which an update may have renamed.
        found.get_disambiguator = lambda: f"{line}-{stamp[:8]}"
        return found


@cache
def sources_stamp(root: Path, file: Path) -> bytes:
    """SHA-256 over the names and contents of a module's `sources`."""
    stamp = hashlib.sha256()
    for source in sorted(sources(root, file)):
        stamp.update(source.relative_to(root).as_posix().encode() + b"\0" + _content(source))
    return stamp.digest()


def sources(root: Path, file: Path) -> set[Path]:
    """A module's file, and those that it imports from the packages in a folder, directly and through others.

    What a package's `__init__` imports is not followed: compiled functions take nothing from there.
    """
    found: set[Path] = set()
    waiting = [file]
    while waiting:
        source = waiting.pop()
        if source not in found:
            found.add(source)
            waiting += _imported(root, source)
    return found


@cache
def _imported(root: Path, file: Path) -> tuple[Path, ...]:
    found = []
    for module, taken in IMPORT.findall(_content(file).decode()):
        folder = root.joinpath(*module.split("."))
        found += [folder.with_suffix(".py"), *(folder / f"{name}.py" for name in WORD.findall(taken))]
    return tuple(path for path in found if path.is_file())


@cache
def _content(file: Path) -> bytes:
    return file.read_bytes()


def _ask_here_first() -> None:
    """Name `SourcesLocator` to numba before those that it asks anyway."""
    mine = f"{__name__}.{SourcesLocator.__name__}"
    usual = getattr(config, SETTING, "") or ",".join(name for name in OTHERS if hasattr(caching, name))
    if mine not in usual:
        setattr(config, SETTING, f"{mine},{usual}")


_ask_here_first()
