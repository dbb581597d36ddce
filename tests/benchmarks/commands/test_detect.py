"""`obstaclewatch detect`: what it prints, what it refuses, and what it draws."""

from __future__ import annotations

import json
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.cli import cli, main
from benchmarks.commands.own_phone import PIECE_SAMPLES
from benchmarks.echogram import MOST_COLUMNS, Columns
from obstaclewatch import BeepDesign, Detection, Flag, PhoneGeometry, Recording, write_recording
from obstaclewatch.detection import COLUMNS, Decision
from simulator import Phone
from tests.benchmarks.closed_output import unread

PHONE: PhoneGeometry = Phone.named("ideal").geometry
C = 343.0


def walk(rate=192_000.0, beeps=24, speed_m_s=1.3, start_m=4.5):
    """(2, N) direct sound and the echo of a mirror straight ahead that closes in, in some noise."""
    beep = BeepDesign(stop_hz=21_500.0, sample_rate_hz=rate)
    time = np.arange(beeps * beep.period_samples) / rate
    samples = 1e-4 * np.random.default_rng(1).standard_normal((2, len(time)))
    ahead = PHONE.speaker_m[1]
    for mic in range(2):
        direct = float(PHONE.speaker_to_mic_m[mic]) / C
        legs = 2.0 * start_m - ahead - PHONE.mics_m[mic, 1]
        emitted = ((C + speed_m_s) * time - legs) / (C - speed_m_s)
        for gain, when in ((1.0 - 0.6 * mic, time - direct), (0.02, emitted)):
            samples[mic] += gain * np.where(when >= 0.0, beep.waveform(np.mod(when, beep.period_s)), 0.0)
    return Recording((0.4 * samples).astype(np.float32), rate)


@pytest.fixture(scope="module")
def stored(tmp_path_factory):
    path = tmp_path_factory.mktemp("walk") / "walk.wav"
    write_recording(walk(), path)
    return path


def run(*arguments):
    band = ["--phone", "ideal", "--band", "18000-21500"]
    return CliRunner().invoke(cli, ["detect", *map(str, arguments), *band], catch_exceptions=False)


def complaint(monkeypatch, capsys, *arguments):
    """One line on stderr and exit code 2, as a shell would see it."""
    monkeypatch.setattr("sys.argv", ["obstaclewatch", "detect", *map(str, arguments), "--phone", "ideal"])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    line = capsys.readouterr().err.strip()
    assert "\n" not in line
    return line


def test_a_table_with_health_candidates_and_the_alert(stored):
    told = run(stored).stdout.splitlines()
    assert told[0] == "recording: nothing wrong found"
    assert told[1].startswith("beep received: 18.0-21.5 kHz in 50 ms every 90.0 ms")
    assert any("speed of sound: 34" in line for line in told[:6])
    assert sum(" deg r " in line for line in told) >= 18
    head = next(k for k, line in enumerate(told) if line.strip().startswith("time"))
    assert "range, bearing" in told[head]
    assert "?: no estimate" in told[head + 1]
    assert all(" deg r " not in line for line in told[:head])
    assert "24 beeps, first alert at" in told[-1]


def test_json_is_one_object_a_beep(stored):
    rows = [json.loads(line) for line in run(stored, "--json").output.splitlines()]
    assert [row["index"] for row in rows] == list(range(24))
    nearest = [row["range_m"][0] for row in rows if row["range_m"]]
    assert len(nearest) >= 18
    assert nearest[0] > nearest[-1]
    assert any(row["alert"] for row in rows)


@pytest.mark.parametrize("noise", [0.0, 1e-4])
@pytest.mark.parametrize("begin", [PIECE_SAMPLES - 2_000, PIECE_SAMPLES + 3_001, 2 * PIECE_SAMPLES - 5_000])
def test_beeps_may_begin_long_after_the_recording(tmp_path, begin, noise):
    """Where the first piece held none, 22 s at 48 kHz, the recording was refused: "no beep"."""
    sound = walk(48_000.0).samples
    before = noise * np.random.default_rng(2).standard_normal((2, begin))
    write_recording(Recording(np.hstack([before, sound]), 48_000.0), tmp_path / "late.wav")
    write_recording(Recording(sound, 48_000.0), tmp_path / "walk.wav")
    late, soon = (run(tmp_path / name).stdout.splitlines() for name in ("late.wav", "walk.wav"))
    assert late[0] == soon[0] == "recording: nothing wrong found"
    assert late[-1].startswith("24 beeps, first alert at")
    alerts_s = [float(lines[-1].split(" at ")[1].split(" s")[0]) for lines in (late, soon)]
    assert alerts_s[0] - begin / 48_000.0 == pytest.approx(alerts_s[1], abs=0.02)


@pytest.mark.parametrize("rate", [44_100.0, 48_000.0, 96_000.0])
def test_other_rates(tmp_path, rate):
    write_recording(walk(rate), tmp_path / "walk.flac")
    assert "24 beeps, first alert at" in run(tmp_path / "walk.flac").stdout


def test_a_picture_of_the_whole(stored, tmp_path):
    assert run(stored, "--plot", tmp_path / "echogram.png").exit_code == 0
    assert (tmp_path / "echogram.png").stat().st_size > 10_000


def test_a_picture_is_drawn_though_nobody_reads_the_table(stored, tmp_path):
    """Cause: `detect --plot walk.png | head` ended after the lines that `head` takes, without a picture."""
    picture = tmp_path / "walk.png"
    asked = "detect", str(stored), "--phone", "ideal", "--band", "18000-21500"
    assert unread(*asked, "--plot", str(picture)) == (0, "")
    assert picture.stat().st_size > 10_000
    assert unread(*asked) == (141, "")


def test_swapped_channels_are_refused_and_can_be_swapped(stored, tmp_path, monkeypatch, capsys):
    clean = walk()
    write_recording(Recording(clean.samples[::-1], clean.sample_rate_hz), tmp_path / "swapped.wav")
    refused = complaint(monkeypatch, capsys, tmp_path / "swapped.wav", "--band", "18000-21500")
    assert refused.startswith("obstaclewatch: swapped channels: microphone 1 receives the speaker")
    assert run(tmp_path / "swapped.wav", "--swap").stdout == run(stored).stdout


def test_another_beep_is_refused_and_named(stored, monkeypatch, capsys):
    refused = complaint(monkeypatch, capsys, stored, "--band", "15000-17000")
    assert "other beep: expected 15.0-17.0 kHz in 50 ms every 90.0 ms, received 18.0-21.5 kHz" in refused


def test_the_band_must_fit_the_files_rate(tmp_path, monkeypatch, capsys):
    write_recording(walk(44_100.0), tmp_path / "walk.wav")
    assert "got 23000.0 Hz at 44100.0 Hz" in complaint(monkeypatch, capsys, tmp_path / "walk.wav")


@pytest.mark.parametrize(
    ("wrong", "rule"),
    [
        (("--plot", "missing/walk.png"), "the folder of 'missing/walk.png' must exist"),
        (("--plot", "walk.txt"), "--plot must end in .png, got 'walk.txt'"),
        (("--plot", "."), "--plot must end in .png, got '.'"),
        (("--pitch", "nan"), "Invalid value for '--pitch': must be a finite number, got nan"),
        (("--beep-ms", "1e9"), "duration_s must be at most 10 s, got 1e+06 s"),
        (("--reach", "20"), "far_m must be received within one beep period, got 20.0 m"),
        (("--reach", "20"), "--reach is too far: far_m must be received"),
        (("--reach", "0"), "--reach must be above 0.3 m, got 0 m"),
        (("--temperature", "200"), "temperature_c must lie within -80..70, got 200.0"),
    ],
)
def test_wrong_options_are_told_before_anything_else(stored, monkeypatch, capsys, wrong, rule):
    """A picture's place was tried when the whole recording had been listened to, and all was already printed."""
    monkeypatch.setattr("sys.argv", ["obstaclewatch", "detect", str(stored), "--phone", "ideal", *wrong])
    with pytest.raises(SystemExit) as stop:
        main()
    assert stop.value.code == 2
    told = capsys.readouterr()
    assert told.out == ""
    assert rule in told.err


def test_a_pitch_of_a_right_angle_is_refused_in_degrees(stored):
    refused = run(stored, "--pitch", "95")
    assert refused.exit_code == 2
    assert "--pitch must lie between -90 and 90 degrees, got 95" in refused.output


def test_time_zero_has_no_sign(tmp_path):
    """A beep emitted 5 us before the file's start was one at -0.00 s."""
    write_recording(Recording(walk().samples[:, 1:], 192_000.0), tmp_path / "walk.wav")
    assert "\n   0.00 s  " in run(tmp_path / "walk.wav").stdout


def test_either_a_file_or_live(stored, monkeypatch, capsys):
    assert run().exit_code == 2
    assert run(stored, "--live", "1").exit_code == 2
    assert run("--live", "1", "--plot", "x.png").exit_code == 2
    monkeypatch.setitem(sys.modules, "sounddevice", None)
    assert "extra 'live'" in complaint(monkeypatch, capsys, "--live", "1")


def test_live(monkeypatch):
    """A sound device that hears a recorded walk, whatever is played."""
    heard = walk(48_000.0).samples.T

    class Device:
        def __init__(self, **_):
            self.place = 0

        def __enter__(self):
            return self

        def __exit__(self, *_):
            return False

        def write(self, samples):
            assert np.abs(samples).max() == pytest.approx(0.5, rel=1e-3)

        def read(self, count):
            self.place += count
            return heard[self.place - count : self.place], False

    monkeypatch.setitem(sys.modules, "sounddevice", SimpleNamespace(Stream=Device, PortAudioError=OSError))
    assert "24 beeps, first alert at" in run("--live", 24 * 0.09).stdout


def test_a_picture_keeps_so_many_columns_of_any_recording():
    none, no = np.empty(0), np.empty(0, dtype=bool)
    columns = Columns()
    for index in range(10 * MOST_COLUMNS):
        decision = Decision(index == 12_345, 0.09 * index, np.nan, np.nan, 0)
        columns.add(
            Detection(
                **dict.fromkeys(COLUMNS, none), index=index, time_s=0.09 * index, collides=no,
                flags=np.empty(0, int), beep_flags=Flag.NONE, decision=decision,
            )
        )  # fmt: skip
    assert MOST_COLUMNS / 2 <= len(columns.kept) <= MOST_COLUMNS
    assert columns.alerts_s == [pytest.approx(0.09 * 12_345)]
    assert np.diff([one.index for one in columns.kept]).tolist() == [columns.stride] * (len(columns.kept) - 1)


def test_the_air_s_temperature_scales_the_ranges(stored):
    """From 20 to 0 degrees the speed of sound falls by 3.5 %."""
    warm, cold = (
        {row["index"]: row["range_m"][0] for row in map(json.loads, run(stored, "--json", *air).output.splitlines())
         if row["range_m"]}
        for air in ((), ("--temperature", 0.0))
    )  # fmt: skip
    both = sorted(warm.keys() & cold.keys())
    assert len(both) >= 15
    assert np.median([cold[k] / warm[k] for k in both]) == pytest.approx(np.sqrt(273.15 / 293.15), abs=0.003)


def test_the_microphones_phase_is_for_the_detector_that_uses_it(stored):
    refused = run(stored, "--mic-phase", 30.0)
    assert refused.exit_code == 2
    assert "--mic-phase is for TrackingDetector, got PaperDetector" in refused.output
    bearings = [
        [row["bearing_rad"] for row in map(json.loads, run(stored, "--json", "--detector", "TrackingDetector",
                                                           "--mic-phase", degrees).output.splitlines())]
        for degrees in (0.0, 170.0)
    ]  # fmt: skip
    assert any(bearings[0])
    assert bearings[0] != bearings[1]


def test_every_estimate_has_its_deviation(stored):
    rows = [json.loads(line) for line in run(stored, "--json", "--detector", "TrackingDetector").output.splitlines()]
    told = [row for row in rows if row["range_m"]]
    assert len(told) >= 5
    for row in told:
        assert len(row["range_std_m"]) == len(row["bearing_std_rad"]) == len(row["range_m"])
        assert row["radius_m"] == [None] * len(row["range_m"])
        assert 0.0 <= row["collision_probability"] <= 1.0
