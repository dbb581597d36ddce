"""Live input, on a sound device made of arrays."""

from __future__ import annotations

import sys
from types import SimpleNamespace

import numpy as np
import pytest

from obstaclewatch import BeepDesign, PaperSettings, PaperStandingDetector, PhoneGeometry
from obstaclewatch.recordings.live import live_pieces

BEEP = BeepDesign(18_000.0, 23_000.0, sample_rate_hz=48_000.0)
PHONE = PhoneGeometry("laptop", [0.0, 0.0, 0.0], [[0.0, 0.0, 0.0], [0.0, -0.15, 0.0]])


class PortAudioError(Exception):
    """As sounddevice names it."""


class Room:
    """What is played comes back at once, and again from 3 m, on two channels."""

    def __init__(self, samplerate, channels, dtype):
        assert (samplerate, channels, dtype) == (48_000.0, (2, 1), "float32")
        self.echo = round(2.0 * 3.0 / 343.0 * samplerate)
        self.played = np.zeros(0, dtype=np.float32)
        self.read_so_far = 0

    def __enter__(self):
        return self

    def __exit__(self, *_):
        return False

    def write(self, samples):
        assert samples.shape == (BEEP.period_samples, 1)
        self.played = np.concatenate([self.played, samples[:, 0]])

    def read(self, count):
        late = np.concatenate([np.zeros(self.echo, dtype=np.float32), self.played])
        received = (self.played + 0.02 * late[: len(self.played)])[self.read_so_far : self.read_so_far + count]
        self.read_so_far += count
        return np.stack([received, 0.5 * np.roll(received, 1)], axis=1), False


@pytest.fixture
def room(monkeypatch):
    monkeypatch.setitem(sys.modules, "sounddevice", SimpleNamespace(Stream=Room, PortAudioError=PortAudioError))


def test_beeps_are_played_and_their_echo_is_found(room):
    detector = PaperStandingDetector(BEEP, PHONE, PaperSettings(near_m=0.5, far_m=5.0))
    found = list(detector.stream_pieces(live_pieces(BEEP, 0.9)))
    assert len(found) == 10
    assert all(abs(one.range_m[0] - 3.0) < 0.01 for one in found)


def test_it_stops_when_nobody_listens(room):
    pieces = live_pieces(BEEP, np.inf)
    assert [next(pieces).samples.shape for _ in range(3)] == [(2, BEEP.period_samples)] * 3
    pieces.close()


def test_no_sounddevice_is_one_clear_error(monkeypatch):
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    with pytest.raises(ValueError, match=r"needs the package sounddevice.*extra 'live'"):
        live_pieces(BEEP, 1.0)


def test_no_device_is_one_clear_error(monkeypatch):
    def refuse(**_):
        raise PortAudioError("Invalid number of channels")

    fake = SimpleNamespace(Stream=refuse, PortAudioError=PortAudioError)
    monkeypatch.setitem(sys.modules, "sounddevice", fake)
    with pytest.raises(ValueError, match="stereo input and an output at 48000 Hz are needed: Invalid number"):
        next(live_pieces(BEEP, 1.0))


@pytest.mark.parametrize(("duration_s", "level"), [(0.0, 0.5), (np.nan, 0.5), (1.0, 0.0), (1.0, 1.5)])
def test_bad_arguments(room, duration_s, level):
    with pytest.raises(ValueError, match=r"must be positive|must lie in"):
        live_pieces(BEEP, duration_s, level)
