"""WAV headers that contradict themselves or their file: libsndfile reads what is left without a word."""

from __future__ import annotations

import os
import struct
from pathlib import Path

UNKNOWN_LENGTHS = (0, 0xFFFFFFFF)
"""What a recorder writes that cannot go back to its header."""
MOST_CHUNKS = 10_000
INTEGERS, FLOATS, EXTENSIBLE = 1, 3, 0xFFFE


def check_wav_header(path: Path) -> None:
    """Refuse a WAV whose lengths or rates do not agree; other formats are left to their readers.

    Raises:
        ValueError: cut short, more bytes than announced, or a format whose figures contradict each other.
    """
    size = path.stat().st_size
    with path.open("rb") as stream:
        head = stream.read(12)
        if head[:4] != b"RIFF" or head[8:12] != b"WAVE":
            return
        announced = int.from_bytes(head[4:8], "little")
        if announced not in UNKNOWN_LENGTHS:
            _check_size(path, announced + 8, size)
        for _ in range(MOST_CHUNKS):
            chunk = stream.read(8)
            if len(chunk) < 8:
                return
            name, length = chunk[:4], int.from_bytes(chunk[4:], "little")
            begin = stream.tell()
            if name == b"data" and length in UNKNOWN_LENGTHS:
                return
            if begin + length > size:
                raise ValueError(
                    f"'{path}' is cut short: its {_shown(name)} chunk says {length} bytes, {size - begin} are left"
                )
            if name == b"fmt ":
                _check_format(path, stream.read(min(length, 40)))
            stream.seek(begin + length + length % 2, os.SEEK_SET)
    raise ValueError(f"'{path}' must have at most {MOST_CHUNKS} chunks")


def _check_size(path: Path, announced: int, size: int) -> None:
    if announced > size:
        raise ValueError(f"'{path}' is cut short: its header says {announced} bytes, the file has {size}")
    if announced + 1 < size:  # an odd last chunk may be padded outside of the count
        raise ValueError(f"'{path}' must be as long as its header says, {announced} bytes, the file has {size}")


def _check_format(path: Path, text: bytes) -> None:
    """Channels, rate, bytes a second, bytes a frame and bits of a plain format are one arithmetic."""
    if len(text) < 16:
        raise ValueError(f"'{path}' must have a format of 16 bytes or more in its header, got {len(text)}")
    kind, channels, rate, byte_rate, frame, bits = struct.unpack("<HHIIHH", text[:16])
    if kind not in (INTEGERS, FLOATS, EXTENSIBLE):
        return
    if frame != channels * ((bits + 7) // 8) or byte_rate != rate * frame:
        raise ValueError(
            f"'{path}' must have a header that agrees with itself, got {channels} channels of {bits} bits in {frame} "
            f"bytes a frame, and {byte_rate} bytes a second at {rate} Hz"
        )


def _shown(name: bytes) -> str:
    return repr(name.decode("latin-1"))
