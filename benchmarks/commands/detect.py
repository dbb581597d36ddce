"""`obstaclewatch detect`: a detector on a recording."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import click
import numpy as np

import obstaclewatch
from obstaclewatch import BeepDesign, Detection, read_recording
from simulator import Phone

DETECTORS = ("PaperDetector", "DistanceOnlyDetector", "TrackingDetector")


@click.command()
@click.argument("recording", type=click.Path(path_type=Path))
@click.option("--phone", default="galaxy-s5", show_default=True, help="a name of `obstaclewatch ls phones`")
@click.option("--detector", type=click.Choice(DETECTORS), default=DETECTORS[0], show_default=True)
@click.option("--pitch", type=float, help="lift of the phone's top edge, degrees, if known")
@click.option("--band", default="18000-23000", show_default=True, metavar="HZ-HZ", help="of the beep emitted")
@click.option("--json", "as_json", is_flag=True, help="one JSON object a beep")
@click.option("--plot", type=click.Path(path_type=Path), help="also draw the echogram with the candidates, PNG")
def detect(
    recording: Path, phone: str, detector: str, pitch: float | None, band: str, as_json: bool, plot: Path | None
) -> None:
    """Run a detector on RECORDING, a stereo WAV or FLAC file at the beep's rate."""
    geometry = Phone.named(phone).geometry
    heard = read_recording(recording)
    low, high = _band(band)
    beep = BeepDesign(low, high)
    pitch_rad = None if pitch is None else math.radians(pitch)
    found = list(getattr(obstaclewatch, detector)(beep, geometry, pitch_rad=pitch_rad).stream(heard))
    if plot is not None:
        from benchmarks.echogram import draw_echogram

        draw_echogram(heard, beep, geometry, found, plot)
    for detection in found:
        click.echo(json.dumps(_entry(detection)) if as_json else _line(detection))
    alerts = [d.decision for d in found if d.decision.alert]
    if not as_json:
        first = f"first alert at {alerts[0].time_s:.2f} s, {alerts[0].range_m:.2f} m" if alerts else "no alert"
        click.echo(f"{len(found)} beeps, {first}")


def _band(text: str) -> tuple[float, float]:
    try:
        low, high = (float(part) for part in text.split("-"))
    except ValueError:
        raise ValueError(f"band must be two frequencies in Hz such as 18000-23000, got '{text}'") from None
    return low, high


def _entry(detection: Detection) -> dict[str, Any]:
    decision = detection.decision
    columns = {name: _numbers(getattr(detection, name)) for name in ("range_m", "range2_m", "bearing_rad", "radius_m")}
    return {
        "index": detection.index, "time_s": detection.time_s, **columns,
        "snr_db": _numbers(detection.snr_db), "collides": np.asarray(detection.collides).tolist(),
        "alert": bool(decision.alert), "alert_range_m": _numbers([decision.range_m])[0], "votes": int(decision.votes),
    }  # fmt: skip


def _numbers(values: Any) -> list[float | None]:
    return [float(value) if math.isfinite(value) else None for value in values]


def _line(detection: Detection) -> str:
    candidates = "  ".join(
        f"{range_m:.2f} m {_angle(bearing)} r {_size(radius)}{'!' if hit else ''}"
        for range_m, bearing, radius, hit in zip(
            detection.range_m, detection.bearing_rad, detection.radius_m, detection.collides, strict=True
        )
    )
    alert = "  ALERT" if detection.decision.alert else ""
    return f"{detection.time_s:7.2f} s  {candidates}{alert}"


def _angle(bearing_rad: float) -> str:
    return f"{math.degrees(bearing_rad):3.0f} deg" if math.isfinite(bearing_rad) else "  ? deg"


def _size(radius_m: float) -> str:
    return f"{radius_m:.2f} m" if math.isfinite(radius_m) else "?"
