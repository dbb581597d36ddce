"""Where errors and losses come from, and how claimed deviations compare with errors."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import scipy

from benchmarks.cells.spec import counts_as
from benchmarks.figures.bench.alerts import plain_detectors
from benchmarks.figures.measured import binned_rates, finite_quantile, judged_detectors, sentences
from benchmarks.figures.plots import Line, Panel, PlotFigure, Style
from benchmarks.runs.results import RunData
from benchmarks.scoring.scores import LEFT_M, Table, approach_table, beep_table, chosen, in_time
from obstaclewatch import BeepDesign
from obstaclewatch.signal.pulse import rms_bandwidth_hz
from obstaclewatch.support.arrays import Flags, Floats
from obstaclewatch.tracking.detector import FARTHEST_M

SPEED_M_S = 343.0
DETECTED_BEEPS = 5
"""Beeps with an estimate of the target, between 5 and 1 m, without which a collision counts as not detected."""
CORRECT_RANGE_DOPPLER = ("TrackingDetector",)
"""Detectors that correct the range-Doppler bias themselves."""
STATED_PERCENT = (0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 60.0, 70.0, 80.0, 90.0, 100.1)
LOSSES = ("1 m left or more", "later", "detected, not judged a collision", "not detected")
_FATE_COLOURS = ("2", "1", "3", "muted")


def range_budget(run: RunData) -> PlotFigure:
    """The walking range error taken apart: what range-Doppler coupling, and what noise, must amount to."""
    panels, said = [], []
    ticks = ("walking", "walking, without\nrange-Doppler bias", "standing", "noise alone,\none beep (bound)")
    for detector in judged_detectors(run):
        walking, still = beep_table(run, detector, "approach"), beep_table(run, detector, "standing")
        parts = _budget(run, walking, still, detector not in CORRECT_RANGE_DOPPLER)
        held = [(tick, part) for tick, part in zip(ticks, parts, strict=True) if np.isfinite(part).any()]
        lines = []
        for k, (label, quantile) in enumerate((("median", 0.5), ("P90", 0.9))):
            heights = np.array([100 * finite_quantile(part, quantile) for _, part in held])
            lines.append(Line(label, str(k), np.arange(float(len(held))), heights, "points" if k == 0 else "ring"))
        signed = 100 * finite_quantile(walking["range_m"] - walking["true_range_m"], 0.5)
        shown = tuple(tick for tick, _ in held)
        panels.append(
            Panel(detector, "", "absolute range error (cm)", tuple(lines), log="y", ticks=shown, width_in=4.0)
        )
        said.append(f"{detector}: signed median while walking {signed:+.1f} cm" if np.isfinite(signed) else detector)
    return PlotFigure(
        "error_budget",
        "Range error: walking, without range-Doppler bias, standing, and what noise alone leaves of one beep",
        tuple(panels),
        "; ".join(said) + ".",
        "Range-Doppler bias: 0.205 s times the true closing speed; TrackingDetector corrects it itself. Bound: "
        "Cramer-Rao, from the SNR of every beep alone, walking and standing together. A detector that averages over "
        "beeps, as TrackingDetector does where the phone stands, may stay below it. What walking errors exceed it by "
        "is association, multipath and gait.",
    )


def losses(run: RunData) -> PlotFigure:
    """What becomes of collisions: alerted with 1 m left, later, detected but not judged one, or not detected at all."""
    detectors = plain_detectors(run)
    lines = []
    shares = np.array([_fates(run, detector) for detector in detectors]).reshape(len(detectors), 4)
    place = np.arange(len(detectors), dtype=float)
    for k, fate in enumerate(LOSSES):
        lines.append(Line(fate, _FATE_COLOURS[k], shares[:, k], place, "parts"))
    panel = Panel(
        "",
        "share of collisions (%)",
        "",
        tuple(lines),
        ticks=tuple(detectors),
        flat=True,
        x_range=(0.0, 100.5),
        width_in=5.2,
    )
    said = [
        f"{name}: {row[0]:.0f} % alerted with 1 m left, {row[1]:.0f} % later, {row[2]:.0f} % detected "
        f"but not judged a collision, {row[3]:.0f} % not detected"
        for name, row in zip(detectors, shares, strict=True)
        if np.isfinite(row).all()
    ]
    return PlotFigure(
        "losses",
        "Collisions by outcome: alerted with 1 m left, later, detected only, not detected",
        (panel,),
        sentences(said),
        f"Detected: a candidate within the gate of the true range in {DETECTED_BEEPS} beeps or more between 5 and 1 m. "
        "Later: with less than 1 m left, or after contact, where it is no true positive.",
        height_in=0.9 + 0.45 * max(1, len(detectors)),
    )


def calibration(run: RunData) -> PlotFigure:
    """Claimed deviations against errors: the share of errors within k deviations, beside a normal distribution's; and
    stated probabilities against the share of collisions."""
    panels, said = [], []
    k = np.linspace(0.0, 4.0, 81)
    for title, column, truth, claim in (
        ("range", "range_m", "true_range_m", "range_std_m"),
        ("bearing", "bearing_rad", "true_bearing_rad", "bearing_std_rad"),
    ):
        lines = []
        for detector in judged_detectors(run):
            for kind, state in (("approach", "walking"), ("standing", "standing")):
                table = beep_table(run, detector, kind)
                ratio = np.abs(table[column] - table[truth]) / table[claim]
                ratio = ratio[np.isfinite(ratio)]
                if len(ratio) == 0:
                    continue
                share = 100.0 * np.searchsorted(np.sort(ratio), k, side="right") / len(ratio)
                style: Style = "line" if kind == "approach" else "dashed"
                lines.append(Line(f"{detector}, {state}", detector, k, share, style))
                said.append(f"{title}, {detector} {state}: {100 * np.mean(ratio <= 1.0):.0f} % within one deviation")
        ideal = Line("as claimed", "muted", k, 100.0 * (2.0 * scipy.stats.norm.cdf(k) - 1.0), "dotted")
        panels.append(
            Panel(
                title,
                "claimed deviations",
                "errors within (%)",
                (*lines, ideal) if lines else (),
                x_range=(0.0, 4.0),
                y_range=(0.0, 103.0),
            )
        )
    stated = [line for name in judged_detectors(run) if len((line := _stated(run, name)).x)]
    span, ends = (-3.0, 103.0), np.array([0.0, 100.0])
    lines = [*stated, Line("as claimed", "muted", ends, ends, "dotted")] if stated else []
    words = "stated probability (%)", "walks with a collision (%)"
    panels.append(
        Panel(f"collision, within the next {FARTHEST_M:g} m", *words, tuple(lines), x_range=span, y_range=span)
    )
    return PlotFigure(
        "calibration",
        "Calibration of the claimed deviations and of the stated probabilities",
        tuple(panels),
        sentences(said, " (normal errors: 68 %)."),
        "Dotted: normal errors of the claimed deviation, and probabilities as stated. Below it deviations are "
        "claimed too small, or probabilities stated too high. PaperDetector's claim is the bound from noise, without "
        "range-Doppler bias and body. Probabilities: of beeps at which one above 0 is stated, on collisions "
        f"those with at most {FARTHEST_M:g} m left, on other walks all, both outcomes weighed the same, as in "
        "learning; whiskers: 95 % intervals over walks, of which all beeps have the same outcome.",
    )


def _stated(run: RunData, detector: str) -> Line:
    """Share of collisions by the probability that was stated; of collisions from `FARTHEST_M` left to contact."""
    pairs = [
        (100.0 * probability, record["result"]["truth"]["collides"], walk)
        for walk, record in enumerate(run.ok)
        if counts_as(record["cell"], "approach") and detector in record["result"]["detectors"]
        for left_m, probability in _decisions(record, detector)
        if probability > 0.0 and not (record["result"]["truth"]["collides"] and not 0.0 <= left_m <= FARTHEST_M)
    ]
    place, collides, walks = np.array(pairs, dtype=np.float64).reshape(-1, 3).T
    found = binned_rates(detector, STATED_PERCENT, place, collides > 0.0, walks=walks)
    with_collision = int((collides > 0.0).sum())
    odds = (len(place) - with_collision) / with_collision if 0 < with_collision < len(place) else 1.0
    y, low, high = (_reweighed(np.asarray(share, float), odds) for share in (found.y, found.low, found.high))
    return replace(found, label=f"{detector}, probability", y=y, low=low, high=high)


def _reweighed(percent: Floats, odds: float) -> Floats:
    """Shares whose odds are multiplied, %: as if one outcome counted so many times."""
    share = 0.01 * percent
    reweighed: Floats = 100.0 * odds * share / (odds * share + 1.0 - share)
    return reweighed


def _decisions(record: Mapping[str, Any], detector: str) -> Iterator[tuple[float, float]]:
    """Distance left, NaN without a collision, and probability, of every beep at which one is stated."""
    stated = record["result"]["detectors"][detector]["decisions"]
    for left_m, probability in zip(stated["left_m"], stated["probability"], strict=True):
        yield (np.nan if left_m is None else left_m), probability


def detected_enough(walks: Table, beeps: Table) -> Flags:
    """(walks,) whether each walk's target has an estimate in `DETECTED_BEEPS` beeps between 5 and 1 m."""
    near = (beeps["true_range_m"] < 5.0) & (beeps["true_range_m"] > 1.0) & np.isfinite(beeps["range_m"])
    labels, counts = np.unique(beeps["label"][near], return_counts=True)
    return np.isin(walks["label"], labels[counts >= DETECTED_BEEPS])


def _budget(run: RunData, walking: Table, still: Table, biased: bool) -> tuple[Floats, ...]:
    cells = [record["cell"]["beep"] for record in run.cells if record["cell"]["kind"] == "approach"][:1]
    beep = BeepDesign(**(cells[0] if cells else {}))
    error = walking["range_m"] - walking["true_range_m"]
    ahead = beep.range_doppler_s * closing_speed(walking)
    both = np.concatenate([walking["snr_db"], still["snr_db"]])
    bound = 0.5 * SPEED_M_S / (2 * np.pi * rms_bandwidth_hz(beep)) * 10.0 ** (-both / 20.0)
    normal = np.abs(scipy.stats.norm.ppf((np.arange(len(bound)) + 0.5) / max(len(bound), 1)))
    noise = np.random.default_rng(0).permutation(normal) * bound
    rest = np.abs(error + ahead) if biased else np.full(len(error), np.nan)
    return np.abs(error), rest, np.abs(still["range_m"] - still["true_range_m"]), noise


def closing_speed(table: Table) -> Floats:
    """Fall of the true range per second, over each walk; NaN where a walk has one beep."""
    speed = np.full(len(table["label"]), np.nan)
    for label in np.unique(table["label"]):
        rows = np.flatnonzero(table["label"] == label)
        if len(rows) > 1:
            speed[rows] = -np.gradient(table["true_range_m"][rows], table["time_s"][rows])
    return speed


def _fates(run: RunData, detector: str) -> list[float]:
    """Shares of `LOSSES`, %."""
    walks, beeps = approach_table(run, detector), beep_table(run, detector, "approach")
    walks = chosen(walks, walks["collides"])
    if len(walks["label"]) == 0:
        return [np.nan] * 4
    detected = detected_enough(walks, beeps)
    alert, right = walks["alert"], in_time(walks, LEFT_M[0])
    parts = (right, alert & ~right, ~alert & detected, ~alert & ~detected)
    return [100.0 * float(part.mean()) for part in parts]
