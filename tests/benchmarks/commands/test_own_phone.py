"""`beep` and `calibrate`: what is written to be played, and what a wall at a known distance says of a phone."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from benchmarks.own_phone import load_phone, measured_at_wall, middle_line, phone_file, phone_text
from obstaclewatch import BeepDesign, Recording, assumed_sound_speed, read_recording, write_recording

WALL_M, CASE_S, PHASE_RAD = 1.0, 10e-6, 0.6
RATE_HZ = 48_000.0
SPEED = assumed_sound_speed(20.0)
PHONE = middle_line("mine", mics_m=0.15, speaker_m=0.03)


def run(*arguments: object) -> str:
    done = CliRunner().invoke(cli, [*map(str, arguments)], catch_exceptions=False)
    assert done.exit_code == 0, done.output
    return done.output


def before_a_wall(beeps: int = 20, case_s: float = CASE_S) -> Recording:
    """A phone whose direct sound reaches microphone 0 after `case_s`, and microphone 1 through the air, before a wall
    by the image of its speaker; the bottom channel is `PHASE_RAD` ahead."""
    beep = BeepDesign(sample_rate_hz=RATE_HZ)
    time_s = np.arange(beeps * beep.period_samples) / RATE_HZ - 0.01
    image = PHONE.speaker_m + np.array([0.0, 2.0 * WALL_M, 0.0])
    samples = 1e-5 * np.random.default_rng(0).standard_normal((2, len(time_s)))
    for mic, place in enumerate(PHONE.mics_m):
        direct_s = (case_s, PHONE.speaker_to_mic_m[1] / SPEED)[mic]
        for gain, delay_s in ((0.2 - 0.14 * mic, direct_s), (0.01, np.linalg.norm(image - place) / SPEED)):
            t = np.mod(time_s - delay_s, beep.period_s)
            samples[mic] += gain * beep.window(t) * np.cos(beep.phase_rad(t) + mic * PHASE_RAD)
    return Recording(samples, RATE_HZ)


def test_delay_and_phase_follow_from_a_wall():
    """To a sample's fiftieth: the error of the tape is far greater, so that nothing but the sign could hide in it."""
    found = measured_at_wall(before_a_wall(), BeepDesign(sample_rate_hz=RATE_HZ), PHONE, WALL_M, SPEED)
    assert found.direct_delay_s == pytest.approx(CASE_S, abs=0.5e-6)
    assert found.phase.phase_rad == pytest.approx(PHASE_RAD, abs=0.05)
    assert found.phase.distance_m == pytest.approx(WALL_M, abs=1e-3)


def test_the_file_is_what_detect_takes(tmp_path: Path):
    write_recording(before_a_wall(), tmp_path / "wall.wav")
    ruler = ["--speaker-cm", 3, "--mics-cm", 15]
    said = run("calibrate", tmp_path / "wall.wav", *ruler, "--wall", WALL_M, "-o", tmp_path / "mine.yaml")
    assert "direct sound +10 +- 29 us after emission" in said
    phone = load_phone(tmp_path / "mine.yaml")
    assert phone.geometry.mics_m.tolist() == PHONE.mics_m.tolist()
    assert phone.mic_phase_rad == pytest.approx(PHASE_RAD, abs=0.05)
    told = run("detect", tmp_path / "wall.wav", "--phone", tmp_path / "mine.yaml", "--detector", "TrackingDetector")
    assert "beeps, " in told.splitlines()[-1]


def test_microphones_0_cm_apart_are_refused(tmp_path: Path):
    """Cause: 0 was taken for not given, and became the distance of the preset."""
    write_recording(before_a_wall(), tmp_path / "wall.wav")
    ruler = ["--speaker-cm", "3", "--mics-cm", "0"]
    done = CliRunner().invoke(cli, ["calibrate", str(tmp_path / "wall.wav"), *ruler])
    assert "must be between the microphones, 0 m apart, got 0.03 m" in str(done.exception)


def test_a_phone_that_detect_would_refuse_is_not_written(tmp_path: Path):
    """Cause: a phone 10 m long was written, and refused by `detect` alone."""
    write_recording(before_a_wall(), tmp_path / "wall.wav")
    ruler = ["--speaker-cm", "3", "--mics-cm", "1000", "-o", str(tmp_path / "mine.yaml")]
    done = CliRunner().invoke(cli, ["calibrate", str(tmp_path / "wall.wav"), *ruler])
    assert "speaker and microphones must be within 1.5 m, got 10 m" in str(done.exception)
    assert not (tmp_path / "mine.yaml").exists()


@pytest.mark.parametrize(
    ("name", "rule"),
    [
        ("wall.wav", "--output must end in .yaml or .yml, got '.*wall.wav'"),
        ("foo.txt", "--output must end in .yaml or .yml, got '.*foo.txt'"),
        ("same.yaml", "--output must be another file than '.*wall.wav', got '.*same.yaml'"),
        ("scene.yml", "--output must be new or hold a phone that `calibrate` wrote, got '.*scene.yml'"),
    ],
)
def test_calibrate_replaces_nothing_but_a_calibration(tmp_path: Path, name: str, rule: str):
    """Cause: -o took any name. That of the recording was replaced by YAML, and `detect` did not take foo.txt."""
    write_recording(before_a_wall(), tmp_path / "wall.wav")
    (tmp_path / "same.yaml").symlink_to("wall.wav")
    (tmp_path / "scene.yml").write_text("name: mine\nobstacles: []\n")
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    done = CliRunner().invoke(cli, ["calibrate", str(tmp_path / "wall.wav"), "-o", str(tmp_path / name)])
    assert isinstance(done.exception, ValueError)
    assert re.search(rule, str(done.exception))
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_phone_may_be_calibrated_again(tmp_path: Path):
    write_recording(before_a_wall(), tmp_path / "wall.wav")
    for _ in range(2):
        run("calibrate", tmp_path / "wall.wav", "--wall", WALL_M, "-o", tmp_path / "mine.yaml")
    assert load_phone(tmp_path / "mine.yaml").mic_phase_rad is not None


@pytest.mark.parametrize(
    ("options", "rule"),
    [
        (["--speaker-cm", "3", "-o", "mine.yaml"], "--output needs --mics-cm beside --speaker-cm"),
        (["--speaker-cm", "3", "--phone", "galaxy-s5"], "either --phone or --speaker-cm must be given, got galaxy-s5"),
    ],
)
def test_only_what_was_measured_is_written(tmp_path: Path, monkeypatch, options: list[str], rule: str):
    """Causes: a distance was written of which the line above said that it is that of the case's sound, 17.7 cm of 15;
    and of a phone and a ruler together the phone was ignored."""
    write_recording(before_a_wall(), tmp_path / "wall.wav")
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(cli, ["calibrate", "wall.wav", *options])
    assert done.exit_code == 2
    assert rule in done.output
    assert not Path("mine.yaml").exists()


def test_whose_geometry_is_taken_is_said(tmp_path: Path):
    """Cause: without --phone that of galaxy-s5 was taken, and nothing said so."""
    write_recording(before_a_wall(), tmp_path / "wall.wav")
    said = run("calibrate", tmp_path / "wall.wav")
    assert "geometry of galaxy-s5, which is assumed: --phone or --speaker-cm say what yours is" in said.splitlines()
    said = run("calibrate", tmp_path / "wall.wav", "--phone", "galaxy-s8-plus")
    assert "geometry of galaxy-s8-plus" in said.splitlines()
    assert "geometry of" not in run("calibrate", tmp_path / "wall.wav", "--speaker-cm", 3, "--mics-cm", 15)


def test_a_phone_as_large_as_the_sky_is_refused(tmp_path: Path):
    """Cause: any finite place passed, and the delay of its direct sound overflowed within the detector."""
    path = tmp_path / "mine.yaml"
    path.write_text(phone_text(phone_file(PHONE)).replace("-0.075", "1.0e+300"))
    with pytest.raises(ValueError, match=r"mics_m.*1e\+300|less than or equal to 10"):
        load_phone(path)


def test_distance_between_microphones_from_the_direct_sound(tmp_path: Path):
    """The direct sound through the air at both microphones."""
    write_recording(before_a_wall(case_s=float(PHONE.speaker_to_mic_m[0]) / SPEED), tmp_path / "wall.wav")
    said = run("calibrate", tmp_path / "wall.wav", "--speaker-cm", 3)
    (apart_cm,) = re.findall(r"microphones ([\d.]+) cm apart", said)
    assert float(apart_cm) == pytest.approx(15.0, abs=0.2)


def test_beeps_are_those_that_detect_expects(tmp_path: Path):
    said = run("beep", tmp_path / "beeps.wav", "--seconds", 0.9, "--side", "left")
    played, design = read_recording(tmp_path / "beeps.wav"), BeepDesign(sample_rate_hz=RATE_HZ)
    assert "10 beeps" in said
    assert played.samples.shape == (2, 10 * design.period_samples)
    assert not played.samples[1].any()
    period = played.samples[0, 3 * design.period_samples :][: len(design.samples())]
    assert period == pytest.approx(0.5 * design.samples(), abs=1e-6)


@pytest.mark.parametrize(
    ("samples", "advice"),
    [
        (lambda r: 1e-3 * np.random.default_rng(0).standard_normal(r.samples.shape), "volume up"),
        (lambda r: r.samples[::-1], "--swap"),
    ],
)
def test_what_is_wrong_comes_with_what_to_do(tmp_path: Path, samples, advice):
    recording = before_a_wall(case_s=float(PHONE.speaker_to_mic_m[0]) / SPEED)
    write_recording(Recording(np.asarray(samples(recording)), RATE_HZ), tmp_path / "bad.wav")
    done = CliRunner().invoke(cli, ["detect", str(tmp_path / "bad.wav"), "--phone", "galaxy-s5"])
    assert isinstance(done.exception, ValueError)
    assert advice in str(done.exception)


def test_one_channel_twice_is_said_with_what_to_do(tmp_path: Path):
    recording = before_a_wall()
    write_recording(Recording(recording.samples[[0, 0]], RATE_HZ), tmp_path / "twice.wav")
    assert "to mend identical channels: choose stereo" in run("detect", tmp_path / "twice.wav")


@pytest.mark.parametrize(
    ("arguments", "rule"),
    [
        (["beep", "b.wav", "--seconds", "nan"], "'--seconds': must be a finite number, got nan"),
        (["beep", "b.wav", "--level", "nan"], "'--level': must be a finite number, got nan"),
        (["beep", "b.wav", "--gap-ms", "inf"], "'--gap-ms': must be a finite number, got inf"),
        (["calibrate", "b.wav", "--wall", "nan"], "'--wall': must be a finite number, got nan"),
        (["detect", "b.wav", "--phone", "none.yaml"], "phone 'none.yaml' must be a file, got none of that name"),
        (["beep", "b.wav", "--rate", "1e12"], r"sample_rate_hz must be at most 1e\+06 Hz, got 1e\+12 Hz"),
        (["beep", "b.wav", "--gap-ms", "1e6"], "gap_s must be at most 10 s, got 1000 s"),
        (["beep", "b.wav", "--beep-ms", "1e7"], "duration_s must be at most 10 s, got 10000 s"),
        (["beep", "."], "got '.'"),
        (["calibrate", "b.wav", "-o", "nowhere/x.yaml"], "the folder of 'nowhere/x.yaml' must exist"),
        (["calibrate", "b.wav", "-o", "."], "--output must end in .yaml or .yml, got '.'"),
    ],
)
def test_what_cannot_be_is_refused_at_once(tmp_path: Path, monkeypatch, arguments, rule):
    """NaN passes ranges, as it compares with nothing; any length was a beep's, and 1e12 samples a second a defect of
    the program; `calibrate` made the folder of what it wrote."""
    monkeypatch.chdir(tmp_path)
    done = CliRunner().invoke(cli, arguments)
    assert re.search(rule, done.output + str(done.exception))
    assert not list(tmp_path.iterdir())


def test_beeps_are_not_written_over_a_folder(tmp_path: Path):
    """It ended in the system's own words, "[Errno 21] Is a directory", and those of a file beside it."""
    (folder := tmp_path / "folder.wav").mkdir()
    done = CliRunner().invoke(cli, ["beep", str(folder)])
    assert f"OUTPUT must be a file, got the folder '{folder}'" in str(done.exception)
