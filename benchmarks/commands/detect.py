"""`obstaclewatch detect`: a detector on a recording, or on what this machine records."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Iterator
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import numpy as np

from benchmarks.commands import Real, check_output, check_pitch
from benchmarks.commands.own_phone import beep_options, beep_shape, inspect, pieces_of, sounding_piece
from benchmarks.interrupts import tell
from obstaclewatch.support.words import counted

if TYPE_CHECKING:
    from benchmarks.own_phone import PhoneFile
    from obstaclewatch import BeepDesign, Detection, Recording

DETECTORS = ("PaperDetector", "DistanceOnlyDetector", "TrackingDetector")
LIVE_RATE_HZ = 48_000.0
LIVE_LOOK_S = 1.0
LEGEND = """   time    candidates: range, bearing off the walking direction, r = radius
           ?: no estimate   !: on a collision course   ALERT: the walker is alerted"""


@click.command()
@click.argument("recording", type=click.Path(path_type=Path), required=False)
@click.option("--live", type=Real(), metavar="SECONDS", help="play beeps and record here instead (extra `live`)")
@click.option(
    "--phone", default="galaxy-s5", show_default=True, help="of `ls phones`, of a file of `calibrate` or a scene file"
)
@click.option("--detector", type=click.Choice(DETECTORS), default=DETECTORS[0], show_default=True)
@click.option("--pitch", type=Real(), help="pitch of the phone's top edge, degrees, if known")
@click.option(
    "--mic-phase", type=Real(), help="of the bottom microphone's channel, degrees; TrackingDetector  [default: 0]"
)
@click.option("--temperature", type=Real(), default=20.0, show_default=True, help="of the air, degrees Celsius")
@beep_options
@click.option("--reach", type=Real(), default=7.0, show_default=True, help="greatest range searched, m")
@click.option("--swap", is_flag=True, help="the file's first channel is the bottom microphone")
@click.option("--json", "as_json", is_flag=True, help="one JSON object a beep; what is wrong with the file on stderr")
@click.option("--plot", type=click.Path(path_type=Path), help="also draw the echogram with track and alerts, PNG")
def detect(
    recording: Path | None, live: float | None, phone: str, detector: str, pitch: float | None, mic_phase: float | None,
    temperature: float, band: str, beep_ms: float, gap_ms: float, reach: float, swap: bool, as_json: bool,
    plot: Path | None,
) -> None:  # fmt: skip
    """Run a detector on RECORDING, a stereo WAV or FLAC file of any rate and length that holds the beep.

    The file is inspected first: what no detector can use ends here, with the reason.
    """
    import obstaclewatch
    from obstaclewatch import BeepDesign
    from obstaclewatch.recordings.live import live_pieces

    _check_source(recording, live, plot, swap)
    if mic_phase is not None and detector != "TrackingDetector":
        raise click.UsageError(f"--mic-phase is for TrackingDetector, got {detector}")
    if pitch is not None:
        check_pitch(pitch)
    if plot is not None:
        check_output(plot, "--plot", (".png",))  # before the detector runs: that may take long
    held = _phone(phone)
    geometry, shape = held.geometry, beep_shape(band, beep_ms, gap_ms)
    if recording is not None:
        pieces = pieces_of(recording, swap)
        first = next(pieces)
    else:
        pieces = live_pieces(BeepDesign(*shape, LIVE_RATE_HZ), float(live or 0.0))
        first = _joined(pieces, LIVE_LOOK_S)
    beep = BeepDesign(*shape, first.sample_rate_hz)
    speed = obstaclewatch.assumed_sound_speed(temperature)
    _check_reach(reach, beep, speed)
    settings = obstaclewatch.PaperSettings(far_m=reach, direct_delay_s=held.direct_delay_s)
    pitch_rad = None if pitch is None else math.radians(pitch)
    phase_rad = held.mic_phase_rad if mic_phase is None else math.radians(mic_phase)
    known = {} if phase_rad is None or detector != "TrackingDetector" else {"mic_phase_rad": phase_rad}
    detecting = getattr(obstaclewatch, detector)(beep, geometry, settings, speed, pitch_rad, **known)
    looked_at = first if recording is None else sounding_piece(recording, swap, beep)
    say = click.echo if plot is None else tell  # a picture is drawn though nobody reads on, as after `| head`
    inspect(looked_at, beep, geometry, to_stderr=as_json, say=say)
    found = detecting.stream_pieces(chain([first], pieces))
    if plot is None:
        _say_all(found, as_json, say)
        return
    from benchmarks.echogram import Columns, draw_echogram

    columns = Columns()
    _say_all(_noting(found, columns), as_json, say)
    title = f"{geometry.name}, {detector}"
    draw_echogram(pieces_of(Path(str(recording)), swap), beep, title, columns, plot)


def _check_source(recording: Path | None, live: float | None, plot: Path | None, swap: bool) -> None:
    """Refuse a file and live sound together, neither, and what is of files alone."""
    if (recording is None) == (live is None):
        raise click.UsageError("either RECORDING or --live SECONDS must be given")
    if live is not None and plot is not None:
        raise click.UsageError("--plot needs a RECORDING: a live recording is not kept")
    if live is not None and swap:
        raise click.UsageError("--swap is for the channels of a RECORDING, and --live has none")


def _check_reach(reach_m: float, beep: BeepDesign, sound_speed_m_s: float) -> None:
    """Refuse a range below the first that detectors search, or beyond what is received before the next beep."""
    from obstaclewatch import PaperSettings
    from obstaclewatch.recordings.streaming import reach_s

    if not reach_m > PaperSettings.near_m:
        raise ValueError(f"--reach must be above {PaperSettings.near_m:g} m, got {reach_m:g} m")
    try:
        reach_s(beep, reach_m, sound_speed_m_s)
    except ValueError as error:
        raise ValueError(f"--reach is too far: {error}") from error


def _joined(pieces: Iterator[Recording], duration_s: float) -> Recording:
    """The first pieces of together that duration, as one."""
    from obstaclewatch import Recording

    taken = [next(pieces)]
    while sum(piece.duration_s for piece in taken) < duration_s and (piece := next(pieces, None)) is not None:
        taken.append(piece)
    return Recording(np.concatenate([piece.samples for piece in taken], axis=1), taken[0].sample_rate_hz)


def _noting(found: Iterable[Detection], columns: Any) -> Iterator[Detection]:
    for detection in found:
        columns.add(detection)
        yield detection


def _say_all(found: Iterable[Detection], as_json: bool, say: Callable[[str], object]) -> None:
    """Print every detection as it comes, between a legend and a summary."""
    if not as_json:
        say(LEGEND)
    count, first = 0, None
    for detection in found:
        say(json.dumps(_entry(detection)) if as_json else _line(detection))
        count += 1
        first = first or (detection.decision if detection.decision.alert else None)
    if not as_json:
        alert = f"first alert at {first.time_s:.2f} s, {first.range_m:.2f} m" if first else "no alert"
        say(f"{counted(count, 'beep')}, {alert}")


def _phone(text: str) -> PhoneFile:
    """The preset of that name, the phone of a scene file, or one that was calibrated."""
    from benchmarks.own_phone import SUFFIXES, load_phone, phone_file
    from simulator import Phone

    return load_phone(Path(text)) if text.endswith(SUFFIXES) else phone_file(Phone.named(text).geometry)


def _entry(detection: Detection) -> dict[str, Any]:
    import obstaclewatch
    from benchmarks.cells.association import ESTIMATES

    decision = detection.decision
    columns = {name: _numbers(getattr(detection, name)) for name in ESTIMATES}
    return {
        "index": detection.index, "time_s": detection.time_s, **columns,
        "collides": np.asarray(detection.collides).tolist(),
        "alert": bool(decision.alert), "alert_range_m": _numbers([decision.range_m])[0], "votes": int(decision.votes),
        "collision_probability": _numbers([decision.collision_probability])[0],
        "flags": [flag.name for flag in obstaclewatch.Flag if flag and flag in detection.beep_flags],
    }  # fmt: skip


def _numbers(values: Any) -> list[float | None]:
    return [float(value) if math.isfinite(value) else None for value in values]


def _line(detection: Detection) -> str:
    import obstaclewatch

    candidates = "  ".join(
        f"{range_m:.2f} m {_angle(bearing)} r {_size(radius)}{'!' if hit else ''}"
        for range_m, bearing, radius, hit in zip(
            detection.range_m, detection.bearing_rad, detection.radius_m, detection.collides, strict=True
        )
    )
    alert = "  ALERT" if detection.decision.alert else ""
    lost = "no beep here" if obstaclewatch.Flag.NO_BEEP in detection.beep_flags else ""
    lost = "damaged" if obstaclewatch.Flag.DAMAGED in detection.beep_flags else lost
    return f"{round(detection.time_s, 2) + 0.0:7.2f} s  {candidates}{lost}{alert}"  # + 0.0: never "-0.00"


def _angle(bearing_rad: float) -> str:
    return f"{math.degrees(bearing_rad):3.0f} deg" if math.isfinite(bearing_rad) else "  ? deg"


def _size(radius_m: float) -> str:
    return f"{radius_m:.2f} m" if math.isfinite(radius_m) else "?"
