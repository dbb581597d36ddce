"""A real phone's echo profile beside a simulated one, bin by bin.

    python -m docs.studies.real_vs_simulated REALDATA -o docs/real_vs_simulated.png

REALDATA is the folder that holds `open/traces`. The simulated recording goes through the same processing as the real
ones did: correlation with the chirp, magnitude, and the mean over four samples.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np
import trimesh
from matplotlib.figure import Figure

from docs.studies.real_traces import Trace, load_trace
from obstaclewatch.support.arrays import Floats
from simulator import Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.phone.noise import noise_rms

RATE_HZ, PERIOD, CHIRP = 48_000.0, 2400, 1200
LOW_HZ, HIGH_HZ = 18_000.0, 24_000.0
BINS, SAMPLES = 300, 1201
SPEED_M_S = 343.0
PITCH_RAD = 0.5
BEEPS = 40


@dataclass(frozen=True)
class Case:
    """A hold and what is known of its place.

    Attributes:
        trace: name of the file.
        wall_m, phone_height_m: ranges of the first line and of the floor's.
        mics: names of the channels, in their order.
    """

    trace: str
    wall_m: float
    phone_height_m: float
    mics: tuple[str, str] = ("bottom", "top")


CASES = (Case("6p_mic_2m_1", 1.98, 1.39), Case("6p_mic_3m_2", 2.90, 1.40))


def excitation() -> Floats:
    """(1200,) the chirp that was played: 18-24 kHz in 25 ms, 10 % Hamming fades, peak 1."""
    time = np.arange(CHIRP) / RATE_HZ
    chirp = np.cos(2.0 * np.pi * (LOW_HZ * time + (HIGH_HZ - LOW_HZ) / (2.0 * time[-1]) * time**2))
    fade = np.hamming(CHIRP // 5)
    fade = (fade - fade.min()) / (fade.max() - fade.min())
    top = int(fade.argmax())
    chirp[: top + 1] *= fade[: top + 1]
    chirp[CHIRP - (len(fade) - top - 1) :] *= fade[top + 1 :]
    peak: Floats = chirp / np.abs(chirp).max()
    return peak


def to_magnitude(period: Floats) -> Floats:
    """(300,) magnitudes of one period of samples that starts at the direct sound, as the recordings were processed.

    Rectified correlation at delays 0 to 1200 samples, each bin a triangle of +-4 samples, mirrored at the ends.
    """
    whole = np.abs(np.convolve(period, excitation()[::-1]))[CHIRP - 1 : CHIRP - 1 + SAMPLES]
    center = (np.arange(BINS) + 0.5) * SAMPLES / BINS - 0.5
    reach = np.arange(-5, 6)
    index = np.round(center)[:, None].astype(int) + reach
    weight = np.maximum(0.0, 1.0 - np.abs(index - center[:, None]) * BINS / SAMPLES)
    mirrored = np.where(index < 0, -1 - index, index)
    mirrored = np.where(mirrored >= SAMPLES, 2 * SAMPLES - 1 - mirrored, mirrored)
    mean: Floats = np.sum(weight * whole[mirrored], axis=1) / weight.sum(axis=1)
    return mean


def simulated_levels(case: Case, phone: Phone, seed: int = 0) -> Floats:
    """(300, 2) median magnitude over beeps of the same place, channels in the file's order, in noise."""
    ground = trimesh.creation.box((40.0, 40.0, 1.0))
    ground.apply_translation([0.0, 0.0, -0.5])
    wall = trimesh.creation.box((0.3, 8.0, 4.0))
    wall.apply_translation([case.wall_m + 0.5 * phone.geometry.mic_separation_m + 0.15, 0.0, 2.0])
    scene = Scene([
        Obstacle(ground, Material.named("concrete"), "ground"),
        Obstacle(wall, Material.named("brick"), "wall"),
    ])  # fmt: skip
    pose = Pose(np.array([0.0, 0.0, case.phone_height_m]), held_rotation(heading_rad=0.0, pitch_rad=PITCH_RAD))
    paths = trace_paths(scene, phone, pose)
    frequency = np.fft.rfftfreq(PERIOD, 1.0 / RATE_HZ)
    spectrum = np.fft.rfft(excitation(), PERIOD) * paths.transfer_function(frequency)
    clean = np.fft.irfft(np.where(frequency > 15_000.0, spectrum, 0.0), PERIOD, axis=1)[::-1]
    start = int(np.argmax(np.abs(np.convolve(clean[0], excitation()[::-1])))) - (CHIRP - 1)
    noise = noise_rms(phone, RATE_HZ) / phone.full_scale_gain
    rng = np.random.default_rng(seed)
    beeps = np.roll(clean, -start, axis=1) + noise * rng.standard_normal((BEEPS, 2, PERIOD))
    return np.median([[to_magnitude(channel) for channel in beep] for beep in beeps], axis=0).T


def real_levels(trace: Trace) -> Floats:
    """(300, C) median over the hold."""
    return np.asarray(np.median(trace.level[trace.hold], axis=0))


def to_db(level: Floats) -> Floats:
    """Relative to the strongest of the first eight bins: the direct sound."""
    return 20.0 * np.log10(level / level[:8].max(axis=0))


def line_db(profile_db: Floats, range_m: Floats, at_m: float) -> float:
    """Highest level within 12 cm of a range."""
    return float(profile_db[np.abs(range_m - at_m) < 0.12].max())


def draw(cases: Sequence[Case], folder: Path, output: Path) -> list[str]:
    """Draw all cases, and give a table of their lines as Markdown."""
    phone = Phone.named("nexus-6p")
    figure = Figure(figsize=(11.0, 6.5), layout="constrained")
    panels = figure.subplots(2, len(cases), sharex=True, sharey=True)
    table = ["| hold | microphone | line | real, dB | simulated, dB |", "| --- | --- | --- | --- | --- |"]
    for column, case in enumerate(cases):
        trace = load_trace(folder / "open" / "traces" / f"{case.trace}.npz")
        real, simulated = to_db(real_levels(trace)), to_db(simulated_levels(case, phone))
        for mic, name in enumerate(case.mics):
            axes = panels[1 - mic, column]
            axes.plot(trace.range_m, real[:, mic], color="#1f4e79", linewidth=1.3, label="recorded")
            axes.plot(trace.range_m, simulated[:, mic], color="#d9541a", linewidth=1.1, label="simulated")
            axes.set_title(f"Nexus 6P, {case.wall_m:.0f} m before the object, {name} microphone", fontsize=10)
            axes.grid(alpha=0.3)
            table += _lines(case, name, trace.range_m, real[:, mic], simulated[:, mic])
    panels[0, 0].legend()
    panels[0, 0].set(xlim=(0.0, 4.2), ylim=(-85.0, 3.0))
    figure.supxlabel("range (m)")
    figure.supylabel("level (dB re direct sound)")
    figure.savefig(output, dpi=110, metadata={"Software": None})
    return table


def _lines(case: Case, mic: str, range_m: Floats, real_db: Floats, simulated_db: Floats) -> list[str]:
    far = (range_m > 3.6) & (range_m < 4.2)
    rows = [
        (f"{name} at {at_m:.2f} m", *(line_db(profile, range_m, at_m) for profile in (real_db, simulated_db)))
        for name, at_m in (("floor", case.phone_height_m), ("wall", case.wall_m))
    ]
    rows.append(("noise", float(np.median(real_db[far])), float(np.median(simulated_db[far]))))
    return [f"| {case.trace} | {mic} | {name} | {one:.0f} | {other:.0f} |" for name, one, other in rows]


@click.command()
@click.argument("folder", type=click.Path(path_type=Path, exists=True))
@click.option("-o", "--output", type=click.Path(path_type=Path), required=True)
def main(folder: Path, output: Path) -> None:
    """Draw the picture and print the table."""
    click.echo("\n".join(draw(CASES, folder, output)))


if __name__ == "__main__":
    main()
