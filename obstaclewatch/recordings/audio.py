"""Recordings as files: two-channel WAV and FLAC, 24 bits.

The one module of the package that needs soundfile; it is imported on use, so that the detectors run without it.
"""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from itertools import chain
from pathlib import Path
from types import ModuleType
from typing import IO, Any

import numpy as np
from numpy.typing import NDArray

from obstaclewatch.recording import Recording
from obstaclewatch.recordings.wav_header import check_wav_header
from obstaclewatch.support.argument_types import check_counts, check_types
from obstaclewatch.support.arrays import Singles
from obstaclewatch.support.whole_file import whole_file

FORMATS = {".wav": "WAV", ".flac": "FLAC"}
BITS = 24
_STEPS = 1 << (BITS - 1)
MOST_WAV_BYTES = (1 << 32) - 1024  # a WAV's lengths are 32 bits wide
_MAX_RATE_HZ = (1 << 31) - 1  # libsndfile's
_PIECE = 1 << 20  # samples read, or turned into steps, at a time
_MOST_SAMPLES = 1 << 30  # of a microphone in memory: an hour and a half at 192 kHz, 8 GiB


def write_recording(recording: Recording | Iterable[Recording], path: str | os.PathLike[str]) -> None:
    """Write a .wav or .flac of 24 bits; the same recording always gives the same bytes, also in pieces.

    The file appears complete or not at all: it is written beside its place and renamed. Samples are rounded to 2^-23 of
    full scale; +1 itself becomes the largest step, 1 - 2^-23. Pieces are written as they come, in constant memory.

    Raises:
        FileNotFoundError: the folder does not exist.
        ValueError: no Recording or no path, an unknown suffix, samples beyond full scale (they would clip), a rate that
            is not a whole number of hertz or more than the format has, more samples than a WAV holds, no pieces, or
            pieces of different rates.

    >>> import tempfile
    >>> from obstaclewatch import Recording, read_recording, write_recording
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_recording(Recording([[0.0, 0.5], [0.0, 0.25]], 192_000.0), f"{folder}/two.wav")
    ...     read_recording(f"{folder}/two.wav").samples.tolist()
    [[0.0, 0.5], [0.0, 0.25]]
    """
    target = _as_path(path)
    if not target.parent.is_dir():
        raise FileNotFoundError(f"no folder '{target.parent}' to write '{target.name}' to")
    file_format = _format_of(target)
    with whole_file(target) as partial, partial.open("wb") as stream:
        _write(_pieces(recording), stream, target, file_format)


def read_recording(path: str | os.PathLike[str]) -> Recording:
    """All samples of a two-channel file; any format and rate that libsndfile reads.

    Whether the rate suits the beep is for the detector to say. Samples come back in units of full scale, as float32:
    exact for 16 and 24 bits.

    Raises:
        FileNotFoundError: there is no such file.
        ValueError: no path, not audio, cut short, empty, not two channels, more than 2^30 samples of each, or samples
            that are not finite.

    >>> import tempfile
    >>> from obstaclewatch import Recording, read_recording, write_recording
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     write_recording(Recording([[0.0, 0.5], [0.0, 0.25]], 192_000.0), f"{folder}/two.wav")
    ...     read_recording(f"{folder}/two.wav").samples.tolist()
    [[0.0, 0.5], [0.0, 0.25]]
    """
    source = _as_path(path)
    with _opened(source) as sound:
        if sound.frames > _MOST_SAMPLES:
            raise ValueError(f"'{path}' says {sound.frames} samples, more than {_MOST_SAMPLES}: use read_blocks")
        samples = _read(sound, sound.frames, source)
        return Recording(samples, float(sound.samplerate))


def read_blocks(path: str | os.PathLike[str], block_samples: int) -> Iterator[Recording]:
    """The same file piece by piece, in constant memory: for recordings of hours. The last piece may be shorter.

    Raises:
        FileNotFoundError, ValueError: as `read_recording`; a block of no samples.
    """
    check_counts(1, block_samples=block_samples)
    source = _as_path(path)
    with _opened(source) as sound:
        for start in range(0, sound.frames, block_samples):
            samples = _read(sound, min(block_samples, sound.frames - start), source)
            yield Recording(samples, float(sound.samplerate))


def _as_path(path: str | os.PathLike[str]) -> Path:
    check_types(path=(path, str | os.PathLike))
    return Path(path)


def _pieces(recording: Recording | Iterable[Recording]) -> Iterator[Recording]:
    """The recording in pieces that cost little while they are written."""
    check_types(recording=(recording, Recording | Iterable))
    if isinstance(recording, np.ndarray) and recording.ndim == 0:
        raise ValueError(f"recording must be of type Recording or Iterable, got {recording!r}")
    for piece in [recording] if isinstance(recording, Recording) else recording:
        check_types(recording=(piece, Recording))
        for start in range(0, piece.samples.shape[1], _PIECE):
            yield Recording(piece.samples[:, start : start + _PIECE], piece.sample_rate_hz)


def _write(pieces: Iterator[Recording], stream: IO[bytes], target: Path, file_format: str) -> None:
    """All pieces to an open file."""
    soundfile, first = _soundfile(), next(pieces, None)
    if first is None:
        raise ValueError(f"'{target}' must hold at least one sample per microphone, got no pieces")
    rate, written = _whole_rate(first.sample_rate_hz), 0
    try:
        with soundfile.SoundFile(stream, "w", rate, 2, f"PCM_{BITS}", format=file_format) as sound:
            for piece in chain([first], pieces):
                if piece.sample_rate_hz != rate:
                    raise ValueError(f"all pieces must be of {rate} Hz, got one of {piece.sample_rate_hz:g} Hz")
                written += piece.samples.size * BITS // 8
                if file_format == "WAV" and written > MOST_WAV_BYTES:
                    raise ValueError(f"a WAV holds {MOST_WAV_BYTES} bytes, '{target.name}' has more; write .flac")
                sound.write(_to_steps(piece.samples).T)
    except soundfile.LibsndfileError as error:
        raise ValueError(f"'{target}' cannot be written at {rate} Hz: {error.error_string}") from error


def _to_steps(samples: Singles) -> NDArray[np.int32]:
    """(2, N) samples to the upper 24 bits of int32."""
    beyond = np.abs(samples) > 1.0
    if beyond.any():
        raise ValueError(
            f"samples must lie within full scale (-1 to 1), got {int(beyond.sum())} beyond it, up to "
            f"{float(np.abs(samples).max()):.3g}; lower the level or raise the phone's full_scale_spl_db"
        )
    steps = np.rint(samples.astype(np.float64) * _STEPS)
    return np.minimum(steps, _STEPS - 1).astype(np.int32) << (32 - BITS)


def _whole_rate(sample_rate_hz: float) -> int:
    if sample_rate_hz != round(sample_rate_hz) or sample_rate_hz > _MAX_RATE_HZ:
        raise ValueError(f"sample_rate_hz must be a whole number below 2^31 in a file, got {sample_rate_hz}")
    return round(sample_rate_hz)


def _format_of(path: Path) -> str:
    if path.suffix.lower() not in FORMATS:
        raise ValueError(f"recordings are written as {' or '.join(FORMATS)}, got '{path}'")
    return FORMATS[path.suffix.lower()]


def _opened(path: Path) -> Any:
    """An open soundfile.SoundFile of two channels and at least one sample."""
    if not path.is_file():
        raise FileNotFoundError(f"no recording at '{path}'")
    if path.stat().st_size == 0:
        raise ValueError(f"'{path}' must hold audio, got an empty file")
    check_wav_header(path)
    soundfile = _soundfile()
    try:
        sound = soundfile.SoundFile(path)
    except soundfile.LibsndfileError as error:
        raise ValueError(f"'{path}' must be readable audio: {error.error_string}") from error
    try:
        _check_contents(sound, path)
    except ValueError:
        sound.close()
        raise
    return sound


def _check_contents(sound: Any, path: Path) -> None:
    if sound.channels != 2:
        raise ValueError(f"'{path}' must have two channels, one per microphone, got {sound.channels}: record in stereo")
    if sound.frames == 0:
        raise ValueError(f"'{path}' must hold at least one sample per microphone, got none")


def _read(sound: Any, count: int, path: Path) -> Singles:
    """(2, count) samples, in pieces: memory goes to what is there, not to what a header says."""
    pieces, left = [], count
    while left:
        try:
            piece = sound.read(min(left, _PIECE), dtype="float32", always_2d=True)
        except _soundfile().LibsndfileError as error:
            raise ValueError(f"'{path}' cannot be decoded: {error.error_string}") from error
        if not len(piece):
            raise ValueError(f"'{path}' is cut short: {count} samples announced, {count - left} read")
        pieces.append(piece)
        left -= len(piece)
    return np.ascontiguousarray(np.concatenate(pieces).T)


def _soundfile() -> ModuleType:
    import soundfile

    return soundfile
