"""Files that are there whole or not at all: written beside their place and renamed to it."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole_file(path: Path, lasting: bool = True) -> Iterator[Path]:
    """A place to write to, which becomes the file; where something fails the file stays as it was.

    Args:
        path: the file, in a folder that exists.
        lasting: wait for the disk, so that the file is whole also after a crash of the machine.

    Raises:
        OSError: the folder cannot be written; the error names the file, and nothing is left behind.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     with whole_file(Path(folder, "one.txt")) as partial:
    ...         _ = partial.write_text("all of it")
    ...     [file.name for file in Path(folder).iterdir()]
    ['one.txt']
    """
    partial = path.with_name(f".{path.name}.{os.getpid()}.partial")
    try:
        yield partial
        if lasting:
            with partial.open("rb") as written:
                os.fsync(written.fileno())
        os.replace(partial, path)
    except OSError as error:
        if error.filename is not None and Path(error.filename) == partial:
            raise OSError(error.errno, error.strerror, str(path)) from error  # under the name that people gave
        raise
    finally:
        partial.unlink(missing_ok=True)
