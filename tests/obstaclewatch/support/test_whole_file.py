"""Files that are there whole or not at all, and errors that name them."""

from __future__ import annotations

from pathlib import Path

import pytest

from obstaclewatch.support.whole_file import whole_file


def test_an_error_names_the_file_and_not_its_forerunner(tmp_path: Path) -> None:
    """Cause: who could not write walk.wav read of '.walk.wav.4711.partial'."""
    missing = tmp_path / "missing" / "walk.wav"
    with pytest.raises(FileNotFoundError) as refused, whole_file(missing) as partial:
        partial.write_bytes(b"all of it")
    assert str(refused.value) == f"[Errno 2] No such file or directory: '{missing}'"
    (folder := tmp_path / "folder.wav").mkdir()
    with pytest.raises(IsADirectoryError) as refused, whole_file(folder) as partial:
        partial.write_bytes(b"all of it")
    assert str(refused.value) == f"[Errno 21] Is a directory: '{folder}'"
    assert [path.name for path in tmp_path.iterdir()] == ["folder.wav"]


def test_errors_of_other_files_stay_as_they_are(tmp_path: Path) -> None:
    other = tmp_path / "other.wav"
    with pytest.raises(FileNotFoundError) as refused, whole_file(tmp_path / "walk.wav"):
        other.read_bytes()
    assert refused.value.filename == str(other)
