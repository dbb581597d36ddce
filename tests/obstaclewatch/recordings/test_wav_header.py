"""Headers that lie about lengths, rates and frames are refused by name; what a stream could not know is not."""

from __future__ import annotations

import struct
from pathlib import Path

import numpy as np
import pytest

from obstaclewatch import Recording, read_recording, write_recording

SIZE_AT, RATE_AT, BYTES_AT, FRAME_AT, DATA_AT = 4, 24, 28, 32, 40


@pytest.fixture
def sound(tmp_path: Path) -> bytearray:
    import soundfile

    path = tmp_path / "plain.wav"
    soundfile.write(path, np.random.default_rng(0).uniform(-0.5, 0.5, (960, 2)), 48_000, subtype="PCM_16")
    data = bytearray(path.read_bytes())
    assert data[36:40] == b"data"
    return data


@pytest.mark.parametrize(
    ("place", "form", "value", "message"),
    [
        (SIZE_AT, "<I", 100, r"as long as its header says, 108 bytes, the file has 3884"),
        (SIZE_AT, "<I", 1 << 30, r"is cut short: its header says 1073741832 bytes"),
        (DATA_AT, "<I", 1 << 20, r"is cut short: its 'data' chunk says 1048576 bytes, 3840 are left"),
        (DATA_AT, "<I", 400, r"cut short|as long as"),
        (BYTES_AT, "<I", 1, r"agrees with itself, got 2 channels of 16 bits in 4 bytes a frame, and 1 bytes a second"),
        (FRAME_AT, "<H", 3, r"agrees with itself"),
        (RATE_AT, "<I", 8_000, r"agrees with itself"),
    ],
)
def test_a_header_that_lies_is_refused(
    tmp_path: Path, sound: bytearray, place: int, form: str, value: int, message: str
) -> None:
    """Cause: only a total length beyond the file's was looked at; libsndfile reads the rest without a word."""
    struct.pack_into(form, sound, place, value)
    path = tmp_path / "lie.wav"
    path.write_bytes(sound)
    with pytest.raises(ValueError, match=message):
        read_recording(path)


@pytest.mark.parametrize("value", [0, 0xFFFFFFFF])
def test_lengths_that_a_stream_could_not_know_are_read(tmp_path: Path, sound: bytearray, value: int) -> None:
    struct.pack_into("<I", sound, SIZE_AT, value)
    if value:
        struct.pack_into("<I", sound, DATA_AT, value)
    path = tmp_path / "stream.wav"
    path.write_bytes(sound)
    assert read_recording(path).samples.shape == (2, 960)


@pytest.mark.parametrize("count", [1, 2, 7])
@pytest.mark.parametrize("suffix", ["wav", "flac"])
def test_files_of_our_own_agree_with_themselves(tmp_path: Path, suffix: str, count: int) -> None:
    path = tmp_path / f"own.{suffix}"
    write_recording(Recording(np.zeros((2, count)) + 0.25, 44_100.0), path)
    assert read_recording(path).samples.shape == (2, count)
