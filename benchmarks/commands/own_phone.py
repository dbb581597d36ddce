"""`obstaclewatch beep` and `obstaclewatch calibrate`: from a phone of one's own to what `detect` asks for."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from benchmarks.commands import SOUNDS, Real, RealRange, check_output
from obstaclewatch.support.words import counted

if TYPE_CHECKING:
    from obstaclewatch import BeepDesign, PhoneGeometry, Recording
    from obstaclewatch.recordings.health import RecordingHealth

PIECE_SAMPLES = 1 << 20
"""Samples read at a time: 5.5 s at 192 kHz, 8 MB. The first piece with a beep is inspected."""
PLAY_RATE_HZ = 48_000.0
NAME = "my phone"
ASSUMED = "galaxy-s5"
"""The phone whose geometry is taken where nobody says which it is."""


def beep_options(command: Callable[..., Any]) -> Callable[..., Any]:
    """The options that say which beep is meant."""
    for option in (
        click.option("--gap-ms", type=Real(), default=40.0, show_default=True, help="gap between two beeps"),
        click.option("--beep-ms", type=Real(), default=50.0, show_default=True, help="length of the beep emitted"),
        click.option("--band", default="18000-23000", show_default=True, metavar="HZ-HZ", help="of the beep emitted"),
    ):
        command = option(command)
    return command


def beep_shape(band: str, beep_ms: float, gap_ms: float) -> tuple[float, float, float, float]:
    """Arguments of `BeepDesign` but the rate.

    Raises:
        ValueError: the band is not two frequencies.
    """
    try:
        low, high = (float(part) for part in band.split("-"))
    except ValueError:
        raise ValueError(f"band must be two frequencies in Hz such as 18000-23000, got '{band}'") from None
    return low, high, 1e-3 * beep_ms, 1e-3 * gap_ms


@click.command()
@click.argument("output", type=click.Path(path_type=Path))
@click.option("--seconds", type=RealRange(min=0.1, max=3600.0), default=60.0, show_default=True)
@click.option(
    "--rate", type=Real(), default=PLAY_RATE_HZ, show_default=True, help="samples per second, as the phone plays"
)
@click.option("--level", type=RealRange(0.0, 1.0, min_open=True), default=0.5, show_default=True,
              help="amplitude, full scale is 1")  # fmt: skip
@click.option("--side", type=click.Choice(["both", "left", "right"]), default="both", show_default=True,
              help="channel of the top speaker, if only that is to sound")  # fmt: skip
@beep_options
def beep(
    output: Path, seconds: float, rate: float, level: float, side: str, band: str, beep_ms: float, gap_ms: float
) -> None:
    """Write the beeps for a phone to play to OUTPUT, a .wav or .flac file.

    Play it with the top speaker while the same phone records both microphones: stereo, unprocessed, WAV or FLAC, at
    48 kHz or more.
    """
    from obstaclewatch import BeepDesign, Recording, write_recording
    from obstaclewatch.recordings.live import played_period

    check_output(output, "OUTPUT", SOUNDS)
    design = BeepDesign(*beep_shape(band, beep_ms, gap_ms), rate)
    sounds = [[side in ("both", "left")], [side in ("both", "right")]]
    period = np.where(sounds, played_period(design, level), 0.0)
    count = max(1, round(seconds / design.period_s))
    write_recording((Recording(period, rate) for _ in range(count)), output)
    click.echo(f"{output}: {counted(count, 'beep')} of {band} Hz, {count * design.period_s:.1f} s at {rate:.0f} Hz")


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--phone", help=f"a name of `ls phones` of the same build  [{ASSUMED}, and says so]")
@click.option(
    "--speaker-cm", type=Real(), help="from the top microphone down to the speaker, by ruler, instead of --phone"
)
@click.option("--mics-cm", type=Real(), help="between the microphones, by ruler, with --speaker-cm; -o needs both")
@click.option("--wall", type=RealRange(0.4, 5.0), metavar="M",
              help="speaker to a wall at which the top edge points squarely, by tape")  # fmt: skip
@click.option("--temperature", type=Real(), default=20.0, show_default=True, help="of the air, degrees Celsius")
@click.option("--swap", is_flag=True, help="the file's first channel is the bottom microphone")
@click.option("-o", "--output", type=click.Path(path_type=Path), help="a .yaml file for `detect --phone`")
@beep_options
def calibrate(
    recording: Path, phone: str | None, speaker_cm: float | None, mics_cm: float | None, wall: float | None,
    temperature: float, swap: bool, output: Path | None, band: str, beep_ms: float, gap_ms: float,
) -> None:  # fmt: skip
    """Read what RECORDING, a stereo WAV or FLAC file, shows of the phone that played and recorded the beeps.

    The direct sound shows level, delay and band of the microphones, and their distance if the sound comes through the
    air. A wall at a known distance shows the delay of the direct sound after emission, and the phase between the
    channels, which TrackingDetector needs for bearings.
    """
    from benchmarks.own_phone import (
        SUFFIXES,
        TAPE_M,
        check_replaceable,
        measured_at_wall,
        measured_separation_m,
        middle_line,
        phone_file,
        phone_text,
    )
    from benchmarks.runs.store import write_atomically
    from obstaclewatch import BeepDesign, assumed_sound_speed
    from simulator import Phone

    if mics_cm is not None and speaker_cm is None:
        raise click.UsageError("--mics-cm needs --speaker-cm")
    if phone is not None and speaker_cm is not None:
        raise click.UsageError(f"either --phone or --speaker-cm must be given, got {phone} and {speaker_cm:g}")
    if output is not None and speaker_cm is not None and mics_cm is None:
        raise click.UsageError(
            "--output needs --mics-cm beside --speaker-cm: whether the direct sound comes through the air, of which a "
            "distance could be read, only a ruler says"
        )
    if output is not None:
        check_output(output, "--output", SUFFIXES, [recording])
        check_replaceable(output)
    speed = assumed_sound_speed(temperature)
    rate_hz = next(pieces_of(recording, swap)).sample_rate_hz
    design = BeepDesign(*beep_shape(band, beep_ms, gap_ms), rate_hz)
    first = sounding_piece(recording, swap, design)
    geometry = Phone.named(phone or ASSUMED).geometry
    assumed_m = geometry.mic_separation_m
    if speaker_cm is not None:
        geometry = middle_line(NAME, assumed_m if mics_cm is None else 1e-2 * mics_cm, 1e-2 * speaker_cm)
    health = inspect(first, design, geometry, to_stderr=False)
    if speaker_cm is not None and mics_cm is None and health.calibration is not None:
        apart_m = measured_separation_m(health.calibration, 1e-2 * speaker_cm, speed)
        geometry = middle_line(NAME, apart_m, 1e-2 * speaker_cm)
        click.echo(
            f"microphones {100 * apart_m:.1f} cm apart, if the direct sound comes through air: check by ruler; lines "
            f"above take the {100 * assumed_m:.1f} cm of {ASSUMED}"
        )
    if speaker_cm is None:
        assumed = "" if phone else ", which is assumed: --phone or --speaker-cm say what yours is"
        click.echo(f"geometry of {geometry.name}{assumed}")
    known = phone_file(geometry)
    if wall is not None:
        found = measured_at_wall(first, design, geometry, wall, speed)
        click.echo(
            f"direct sound {1e6 * found.direct_delay_s:+.0f} +- {1e6 * found.direct_delay_std_s:.0f} us after emission "
            f"(the wall at {wall:g} m +- {100 * TAPE_M:g} cm)\n"
            f"phase of the bottom channel {math.degrees(found.phase.phase_rad):+.0f} +- "
            f"{math.degrees(found.phase.std_rad):.0f} degrees, from {counted(found.phase.beeps, 'beep')}"
        )
        known = phone_file(geometry, found.direct_delay_s, found.phase.phase_rad)
    if output is not None:
        write_atomically(output, phone_text(known))
        click.echo(f"{output}: for `obstaclewatch detect RECORDING --phone {output}`")


def pieces_of(path: Path, swap: bool) -> Iterator[Recording]:
    """A file piece by piece, its channels exchanged if asked for."""
    from obstaclewatch import Recording
    from obstaclewatch.recordings.audio import read_blocks

    for piece in read_blocks(path, PIECE_SAMPLES):
        yield Recording(piece.samples[::-1], piece.sample_rate_hz) if swap else piece


def sounding_piece(path: Path, swap: bool, beep: BeepDesign) -> Recording:
    """The first piece of a file that holds a beep, with the end of what is before it; without any, the first of all.

    So it is if something else repeats there: that is to be named.
    """
    from obstaclewatch import NoBeepError, Recording
    from obstaclewatch.recordings.alignment import BeepFinder
    from obstaclewatch.recordings.beep_identification import detected_beep

    pieces = pieces_of(path, swap)
    finder, first, before = BeepFinder(beep, 0.0), next(pieces), np.empty((2, 0), dtype=np.float32)
    for piece in chain([first], pieces):
        joined = Recording(np.concatenate([before, piece.samples], axis=1), piece.sample_rate_hz)
        try:
            if finder.first_emission(joined.samples) + beep.period_samples <= joined.samples.shape[1]:
                return joined
        except NoBeepError:
            if piece is first and detected_beep(piece.samples[0], piece.sample_rate_hz) is not None:
                return first
        before = joined.samples[:, -2 * beep.period_samples :]
    return first


def inspect(
    first: Recording,
    beep: BeepDesign,
    geometry: PhoneGeometry,
    to_stderr: bool,
    say: Callable[..., object] = click.echo,
) -> RecordingHealth:
    """Say what a recording is worth and what to do about it.

    Args:
        first: what is inspected.
        beep, geometry: what it should hold, and the phone.
        to_stderr: whether standard output is for something else.
        say: takes a line and a stream, None for standard output: `click.echo`, or `tell` of `benchmarks.interrupts`.

    Raises:
        ValueError: no detector can use it.
    """
    from benchmarks.own_phone import ADVICE
    from obstaclewatch import inspect_recording

    health = inspect_recording(first, beep, geometry)
    advice = [
        f"{finding.fault.label}: {ADVICE[finding.fault]}" for finding in health.findings if finding.fault in ADVICE
    ]
    if not health.usable:
        raise ValueError("; ".join([*map(str, health.findings), *(f"to mend it, {each}" for each in advice)]))
    stream = sys.stderr if to_stderr else None
    for line in map(str, health.findings) if to_stderr else health.lines():
        say(line, stream)
    for line in advice:
        say(f"to mend {line}", stream)
    return health
