"""What `obstaclewatch simulate` leaves of a walk towards a wall, and what `detect` makes of it."""

from __future__ import annotations

import json
from pathlib import Path

import soundfile
from click.testing import CliRunner

from benchmarks.cli import cli


def assert_detected(audio: Path, paths: Path) -> None:
    """A stereo file of 24 bits whose paths are known, with the wall in many beeps; and a picture of it."""
    info = soundfile.info(audio)
    assert (info.channels, info.samplerate, info.subtype) == (2, 192_000, "PCM_24")
    assert any(path["kind"] == "specular" for path in json.loads(paths.read_text())["paths"])
    picture = audio.with_suffix(".png")
    call = ["detect", str(audio), "--phone", "galaxy-s8-plus", "--pitch", "30", "--json", "--plot", str(picture)]
    found = CliRunner().invoke(cli, call, catch_exceptions=False)
    rows = [json.loads(line) for line in found.output.splitlines()]
    assert len(rows) == info.frames // 17_280
    assert sum(bool(row["range_m"]) for row in rows) > 0.4 * len(rows)
    assert picture.stat().st_size > 10_000
