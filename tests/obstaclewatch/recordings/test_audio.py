"""Recordings as files: exact round trips, equal bytes, and one clear error for every bad file."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
import soundfile
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from obstaclewatch.recording import Recording
from obstaclewatch.recordings.audio import read_blocks, read_recording, write_recording

STEP = 2.0**-23


@pytest.fixture
def recording():
    samples = np.random.default_rng(0).uniform(-0.9, 0.9, (2, 5000))
    return Recording(samples.astype(np.float32), 192_000.0)


@pytest.mark.parametrize("suffix", [".wav", ".flac", ".WAV"])
@pytest.mark.parametrize("rate_hz", [44_100, 48_000, 96_000, 192_000])
def test_round_trip(tmp_path, recording, suffix, rate_hz):
    path = tmp_path / f"walk{suffix}"
    write_recording(Recording(recording.samples, rate_hz), path)
    back = read_recording(path)
    assert back.sample_rate_hz == rate_hz
    assert back.samples.shape == (2, 5000)
    assert back.samples.dtype == np.float32
    assert np.abs(back.samples - recording.samples).max() <= 0.5 * STEP


@pytest.mark.parametrize("suffix", [".wav", ".flac"])
def test_second_trip_is_exact(tmp_path, recording, suffix):
    first, second = tmp_path / f"a{suffix}", tmp_path / f"b{suffix}"
    write_recording(recording, first)
    write_recording(read_recording(first), second)
    np.testing.assert_array_equal(read_recording(first).samples, read_recording(second).samples)
    assert first.read_bytes() == second.read_bytes()


@settings(max_examples=20, suppress_health_check=[HealthCheck.function_scoped_fixture], deadline=None)
@given(st.lists(st.integers(-(2**23), 2**23 - 1), min_size=1, max_size=20))
def test_every_24_bit_step_survives(tmp_path, steps):
    samples = np.array([steps, steps[::-1]]) * STEP
    write_recording(Recording(samples, 48_000.0), tmp_path / "steps.wav")
    np.testing.assert_array_equal(read_recording(tmp_path / "steps.wav").samples, samples)


@pytest.mark.parametrize("suffix", [".wav", ".flac"])
def test_same_recording_same_bytes(tmp_path, recording, suffix):
    paths = [tmp_path / f"{name}{suffix}" for name in "ab"]
    for path in paths:
        write_recording(recording, path)
    assert paths[0].read_bytes() == paths[1].read_bytes()


def test_channels_keep_their_order(tmp_path):
    samples = np.zeros((2, 10))
    samples[0, 3], samples[1, 7] = 0.5, -0.25
    write_recording(Recording(samples, 48_000.0), tmp_path / "order.flac")
    np.testing.assert_array_equal(read_recording(tmp_path / "order.flac").samples, samples)


def test_full_scale_is_kept_and_beyond_is_refused(tmp_path, recording):
    edge = Recording(np.array([[1.0, -1.0], [0.0, 0.0]]), 48_000.0)
    write_recording(edge, tmp_path / "edge.wav")
    np.testing.assert_array_equal(read_recording(tmp_path / "edge.wav").samples[0], [1.0 - STEP, -1.0])
    loud = Recording(2.0 * recording.samples, 48_000.0)
    with pytest.raises(ValueError, match=r"within full scale .* got \d+ beyond it, up to 1.8"):
        write_recording(loud, tmp_path / "loud.wav")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["edge.wav"]


def test_a_failed_write_leaves_the_old_file(tmp_path, recording, monkeypatch):
    path = tmp_path / "walk.wav"
    write_recording(recording, path)
    before = path.read_bytes()
    monkeypatch.setattr(soundfile.SoundFile, "write", _full_disk)
    with pytest.raises(OSError, match="disk full"):
        write_recording(recording, path)
    assert path.read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["walk.wav"]


def _full_disk(_sound, _steps):
    raise OSError("disk full")


@pytest.mark.parametrize("suffix", [".wav", ".flac"])
def test_pieces_give_the_bytes_of_the_recording(tmp_path, recording, suffix):
    cuts = [recording.samples[:, a:b] for a, b in ((0, 7), (7, 3000), (3000, None))]
    write_recording((Recording(cut, recording.sample_rate_hz) for cut in cuts), tmp_path / f"pieces{suffix}")
    write_recording(recording, tmp_path / f"one{suffix}")
    assert (tmp_path / f"pieces{suffix}").read_bytes() == (tmp_path / f"one{suffix}").read_bytes()


def test_pieces_must_be_of_one_recording(tmp_path, recording):
    other = Recording(recording.samples, 44_100.0)
    with pytest.raises(ValueError, match="all pieces must be of 192000 Hz, got one of 44100 Hz"):
        write_recording([recording, other], tmp_path / "walk.flac")
    with pytest.raises(ValueError, match="got no pieces"):
        write_recording([], tmp_path / "walk.flac")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("name", "rate_hz", "message"),
    [
        ("walk.mp3", 48e3, r"written as .wav or .flac, got '.*walk.mp3'"),
        ("walk.wav", 44_100.5, "whole number.*44100.5"),
        ("walk.wav", 3e9, r"whole number below 2\^31 in a file, got 3000000000.0"),  # was an OverflowError
        (
            "walk.flac",
            768e3,
            "walk.flac' cannot be written at 768000 Hz: .*flac does not support",
        ),  # was libsndfile's own
    ],
)
def test_what_cannot_be_written(tmp_path, recording, name, rate_hz, message):
    with pytest.raises(ValueError, match=message):
        write_recording(Recording(recording.samples, rate_hz), tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_missing_folder(tmp_path, recording):
    with pytest.raises(FileNotFoundError, match=r"no folder '.*nowhere' to write 'walk.wav' to"):
        write_recording(recording, tmp_path / "nowhere" / "walk.wav")


def test_blocks_are_the_whole(tmp_path, recording):
    path = tmp_path / "walk.flac"
    write_recording(recording, path)
    blocks = list(read_blocks(path, 1728))
    assert [block.samples.shape[1] for block in blocks] == [1728, 1728, 1544]
    np.testing.assert_array_equal(np.hstack([b.samples for b in blocks]), read_recording(path).samples)
    with pytest.raises(ValueError, match="block_samples must be a whole number, 1 or more, got 0"):
        next(read_blocks(path, 0))


def test_16_bit_files_of_a_real_phone_are_exact(tmp_path):
    values = np.random.default_rng(1).integers(-32768, 32767, (2, 300), dtype=np.int16)
    soundfile.write(tmp_path / "phone.wav", values.T, 48_000, subtype="PCM_16")
    np.testing.assert_array_equal(read_recording(tmp_path / "phone.wav").samples, values / np.float32(32768.0))


def test_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError, match=r"no recording at .*nowhere\.wav"):
        read_recording(tmp_path / "nowhere.wav")


@pytest.mark.parametrize("channels", [1, 3])
def test_wrong_number_of_channels(tmp_path, channels):
    soundfile.write(tmp_path / "x.wav", np.zeros((100, channels)), 48_000)
    with pytest.raises(ValueError, match=f"must have two channels.*got {channels}"):
        read_recording(tmp_path / "x.wav")


def test_no_samples(tmp_path):
    soundfile.write(tmp_path / "x.wav", np.zeros((0, 2)), 48_000)
    with pytest.raises(ValueError, match="at least one sample"):
        read_recording(tmp_path / "x.wav")


@pytest.mark.parametrize(
    ("content", "message"),
    [(b"", "got an empty file"), (b"not audio at all, only a line of text", "must be readable audio")],
)
def test_not_audio(tmp_path, content, message):
    (tmp_path / "x.wav").write_bytes(content)
    with pytest.raises(ValueError, match=message):
        read_recording(tmp_path / "x.wav")


@pytest.mark.parametrize("suffix", [".wav", ".flac"])
@pytest.mark.parametrize("kept", [20, 60, 9000])
def test_truncated_file(tmp_path, recording, suffix, kept):
    whole, cut = tmp_path / f"whole{suffix}", tmp_path / f"cut{suffix}"
    write_recording(recording, whole)
    assert whole.stat().st_size > 9000
    cut.write_bytes(whole.read_bytes()[:kept])
    with pytest.raises(ValueError, match=r"cut short|cannot be decoded|must be readable audio"):
        read_recording(cut)


def test_nan_in_a_float_file(tmp_path):
    soundfile.write(tmp_path / "x.wav", np.full((100, 2), np.nan), 48_000, subtype="FLOAT")
    with pytest.raises(ValueError, match="finite, got 200"):
        read_recording(tmp_path / "x.wav")


def test_soundfile_is_imported_on_use_only():
    code = "import sys, obstaclewatch.recordings.audio; raise SystemExit('soundfile' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
