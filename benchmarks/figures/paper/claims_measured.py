"""How each claim of the paper is measured in a run."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
import scipy

from benchmarks.figures.bench.sensitivity import side_calls
from benchmarks.figures.measured import significant
from benchmarks.figures.paper.energies import PERIOD_S, cpu_per_beep_s
from benchmarks.figures.paper.signals import signals_of
from benchmarks.figures.paper.sizes import radius_medians
from benchmarks.runs.results import RunData
from benchmarks.runs.variants import band_name, variants
from benchmarks.scoring import scores
from benchmarks.scoring.energy import EnergyModel, charge_range_mah
from benchmarks.scoring.paired import change_of
from benchmarks.scoring.paper_values import SHOWN
from benchmarks.scoring.scores import PAPER_RECIPE, Table, approach_table, beep_table, chosen, judged, recipe_of
from benchmarks.scoring.statistics import Rate, mcnemar, quantile_with_interval
from obstaclewatch.support.arrays import Flags, Floats


@dataclass(frozen=True)
class Measurement:
    """A number with its interval, in SI or as a fraction; n is 0 where nothing was measured.

    Attributes:
        count: how many observations, in words.
        unit: "1" (a fraction), "m", "rad", "mAh" or "" (a plain number).
        p_value: of the test that decides a claim of an order; None for numbers.
        text: words instead of the number, for a claim of an order.
    """

    value: float
    low: float
    high: float
    n: int
    count: str
    unit: str
    p_value: float | None = None
    text: str = ""

    def shown(self, value: float) -> str:
        """A value in the unit people read."""
        scale, unit = (SHOWN | {"mAh": (1.0, " mAh"), "": (1.0, "")})[self.unit]
        digits = f"{scale * value:.1f}" if self.unit == "1" else significant(scale * value)
        return f"{digits}{unit}"


Measure = Callable[[RunData, str], Measurement]
FEW = 7
"""Up to so many objects all orders are tried."""
NO_MEASUREMENT = Measurement(np.nan, np.nan, np.nan, 0, "0", "1")


def tp(run: RunData, detector: str) -> Measurement:
    """Collisions alerted before contact."""
    return measured_rate(scores.true_positive_rate(_walks(run, detector)))


def tn(run: RunData, detector: str) -> Measurement:
    """Other walks without an alert."""
    return measured_rate(scores.true_negative_rate(_walks(run, detector)))


def accuracy(run: RunData, detector: str) -> Measurement:
    """Walks judged rightly, of all."""
    return measured_rate(scores.rate(_right(_walks(run, detector))))


def accuracy_in(range_m: float) -> Measure:
    """Accuracy over the walks that begin within a range or come within it: all that the paper evaluates."""

    def measure(run: RunData, detector: str) -> Measurement:
        table, beeps = _walks(run, detector), beep_table(_first(run), detector, "approach")
        near = np.unique(beeps["label"][beeps["true_range_m"] <= range_m])
        return measured_rate(scores.rate(_right(chosen(table, np.isin(table["label"], near)))))

    return measure


def by_scene(measure: Measure, scene: str) -> Measure:
    """The measure in one scene."""

    def within(run: RunData, detector: str) -> Measurement:
        return measure(_cells(run, lambda cell: cell["scene"] == scene), detector)

    return within


def in_band(measure: Measure, band: str) -> Measure:
    """The measure with one band of the beep, of a run that sweeps bands."""

    def within(run: RunData, detector: str) -> Measurement:
        part = _bands(run).get(band)
        return NO_MEASUREMENT if part is None else measure(part, detector)

    return within


def false_alerts(run: RunData, detector: str) -> Measurement:
    """Alerts on walks without a collision, over all walks."""
    return measured_rate(scores.false_alerts_over_all(_walks(run, detector)))


def error_of(column: str, quantile: float, standing_m: float | None = None) -> Measure:
    """Quantile of an absolute error: standing at a distance, or walking.

    Radii are those of targets up to a metre wide, as in the paper's Figure 11.
    """
    unit = {"range_m": "m", "range2_m": "m", "radius_m": "m", "bearing_rad": "rad"}[column]

    def measure(run: RunData, detector: str) -> Measurement:
        table = beep_table(_first(run), detector, "approach" if standing_m is None else "standing")
        if standing_m is not None:
            table = chosen(table, table["standing_range_m"] == standing_m)
        table = judged(table, column)
        errors = scores.absolute_errors(table, column, f"true_{column}")
        value, low, high, count = quantile_with_interval(errors, quantile, table["label"])
        return Measurement(value, low, high, count, f"{count} of {len(errors)} beeps", unit)

    return measure


def charge(run: RunData, detector: str) -> Measurement:
    """The modelled charge of 30 minutes; its interval is that of the model's stated constants."""
    cpu = cpu_per_beep_s(run, detector) if run.manifest.get("suite") == "energy" else np.zeros(0)
    if len(cpu) == 0:
        return NO_MEASUREMENT
    middle = float(np.median(cpu))
    low, high = charge_range_mah(middle, PERIOD_S)
    return Measurement(EnergyModel().charge_mah(middle, PERIOD_S), low, high, len(cpu), f"{len(cpu)} walks", "mAh")


def radius_correlation(run: RunData, detector: str) -> Measurement:
    """Pearson's correlation of estimated and true radius with Fisher's interval."""
    pairs = [radius_medians(_first(run), detector, kind) for kind in ("standing", "approach")]
    true, found = (np.concatenate([pair[k] for pair in pairs]) for k in (0, 1))
    if len(true) < 4 or np.ptp(true) == 0.0 or np.ptp(found) == 0.0:
        return NO_MEASUREMENT
    result = scipy.stats.pearsonr(true, found)
    ends = result.confidence_interval(0.95)
    return Measurement(
        float(result.statistic), float(ends.low), float(ends.high), len(true), f"{len(true)} objects", ""
    )


def band_gain(run: RunData, detector: str) -> Measurement:
    """True positives with 16-23 kHz against 18-23 kHz."""
    bands = _bands(run)
    if not {"16-23 kHz", "18-23 kHz"} <= set(bands):
        return NO_MEASUREMENT
    tables = [_walks(bands[name], detector) for name in ("16-23 kHz", "18-23 kHz")]
    return oftener_of_pairs(*(_by_walk(chosen(table, table["collides"])) for table in tables))


def size_gain(run: RunData, detector: str) -> Measurement:
    """Accuracy before walls against accuracy before people."""
    table = _walks(run, detector)
    return _more_accurate(*(chosen(table, table["category"] == name) for name in ("wall", "pedestrian")))


def phone_gain(run: RunData, detector: str) -> Measurement:
    """Accuracy with the S8+ against the S5 in the supermarket, where both walk."""
    table = _walks(_cells(run, lambda cell: cell["scene"] == "supermarket"), detector)
    return _more_accurate(*(chosen(table, table["phone"] == name) for name in ("galaxy-s8-plus", "galaxy-s5")))


def crest_nearer(run: RunData, _detector: str) -> Measurement:
    """Rank correlation of crest width and nearness, the middle of all walks up to obstacles, by a sign test over walks.

    Consecutive beeps of a walk are no measurements of their own.
    """
    found = [
        _ranked(-np.array(s["true_m"], dtype=float), np.array(s["crest_samples"], dtype=float), "beeps")
        for s in signals_of(run, "approach")
    ]
    value = np.array([each.value for each in found if each.n])
    if len(value) == 0:
        return NO_MEASUREMENT
    middle = float(np.median(value))
    words = f"rank correlation {middle:.2f}"
    return Measurement(middle, np.nan, np.nan, len(value), f"{len(value)} walks", "", _sign_test(value), words)


def crest_wider(run: RunData, _detector: str) -> Measurement:
    """Rank correlation of crest width and radius over objects at one distance."""
    found = signals_of(run, "crests")
    if not found:
        return NO_MEASUREMENT
    signal = found[0]
    return _ranked(
        np.array(signal["true_radius_m"], dtype=float), np.array(signal["crest_samples"], dtype=float), "objects"
    )


def side_known(run: RunData, detector: str) -> Measurement:
    """Beeps beyond 5 degrees whose side is called rightly when held horizontally; by a sign test over walks."""
    parts = [part for name, part in variants(run).items() if "horizontal" in name]
    if not parts:
        return NO_MEASUREMENT
    bearing, right, label = side_calls(parts[0], detector)
    right, label = right[bearing >= 5.0], label[bearing >= 5.0]
    if len(right) == 0:
        return NO_MEASUREMENT
    share = np.array([right[label == each].mean() for each in np.unique(label)])
    words, count = f"{100 * right.mean():.1f} % of sides right", f"{len(right)} beeps of {len(share)} walks"
    value = float(np.sign(share - 0.5).mean())  # what the test is of: walks, however many beeps they have
    return Measurement(value, np.nan, np.nan, len(share), count, "1", _sign_test(share - 0.5), words)


def other_band(run: RunData, detector: str) -> Measurement:
    """Accuracy with a second phone at 1 m in another band against one in the same band."""
    parts = variants(run)
    names = ("other half at 1 m", "same band at 1 m")
    if not set(names) <= set(parts):
        return NO_MEASUREMENT
    return oftener_of_pairs(*(_by_walk(approach_table(parts[name], detector)) for name in names))


def measured_rate(found: Rate) -> Measurement:
    """A rate as all others show it."""
    return Measurement(found.value, found.low, found.high, found.n, f"{found.k}/{found.n}", "1")


def oftener_of_pairs(first: Mapping[str, bool], second: Mapping[str, bool]) -> Measurement:
    """Difference of two shares of the same walks, decided by McNemar's exact test."""
    found = change_of(second, first)
    if found.n == 0:
        return NO_MEASUREMENT
    shares = [np.mean([part[label] for label in first.keys() & second.keys()]) for part in (first, second)]
    words = f"{100 * shares[0]:.1f} against {100 * shares[1]:.1f} %"
    return Measurement(float(shares[0] - shares[1]), np.nan, np.nan, found.n, f"{found.n} walks", "1", found.p, words)


def more_often(first: Flags, second: Flags) -> Measurement:
    """Difference of two shares of different walks, decided by Fisher's exact test."""
    if len(first) == 0 or len(second) == 0:
        return NO_MEASUREMENT
    counts = [[int(part.sum()), int((~part).sum())] for part in (first, second)]
    p = float(scipy.stats.fisher_exact(counts).pvalue)
    words = f"{100 * first.mean():.1f} against {100 * second.mean():.1f} %"
    number = len(first) + len(second)
    return Measurement(
        float(first.mean() - second.mean()), np.nan, np.nan, number, f"{len(first)} and {len(second)}", "1", p, words
    )


def _sign_test(value: Floats) -> float:
    """Exact two-sided p of as many values above 0 as below."""
    above, below = int((value > 0.0).sum()), int((value < 0.0).sum())
    return mcnemar(above, below)


def _ranked(x: Floats, y: Floats, of: str) -> Measurement:
    kept = np.isfinite(x) & np.isfinite(y)
    if kept.sum() < 3 or np.ptp(y[kept]) == 0.0:
        return NO_MEASUREMENT
    result = scipy.stats.spearmanr(x[kept], y[kept])
    count, p = int(kept.sum()), float(result.pvalue)
    if count <= FEW:
        # scipy's p is asymptotic: 0 for any perfect order, which 4 objects reach by chance 1 time in 12
        p = float(scipy.stats.permutation_test(
            (x[kept],), lambda a: scipy.stats.spearmanr(a, y[kept]).statistic, permutation_type="pairings",
            n_resamples=np.inf, vectorized=False,
        ).pvalue)  # fmt: skip
    return Measurement(
        float(result.statistic),
        np.nan,
        np.nan,
        count,
        f"{count} {of}",
        "",
        p,
        f"rank correlation {result.statistic:.2f}",
    )


def _more_accurate(*tables: Table) -> Measurement:
    """`more_often` of right judgements, where each table has walks of both kinds: else TP is held against TN."""
    if any(len(np.unique(table["collides"])) < 2 for table in tables):
        return NO_MEASUREMENT
    return more_often(*map(_right, tables))


def _right(table: Table) -> Flags:
    return np.where(table["collides"], table["true_alert"], ~table["alert"])


def _by_walk(table: Table) -> dict[str, bool]:
    """Whether each walk was judged rightly, by its label without the point of a sweep."""
    return {label.partition("[")[0]: bool(right) for label, right in zip(table["label"], _right(table), strict=True)}


def _walks(run: RunData, detector: str) -> Table:
    """The walks of the recipe that the paper's rates are about; none of another."""
    first = _first(run)
    return approach_table(first if recipe_of(first) == PAPER_RECIPE else replace(first, cells=()), detector)


def _first(run: RunData) -> RunData:
    """The run, or the first point of its sweep."""
    return next(iter(variants(run).values()), run)


def _cells(run: RunData, keep: Callable[[dict], bool]) -> RunData:
    return run.part([k for k, record in enumerate(run.cells) if keep(record["cell"])])


def _bands(run: RunData) -> dict[str, RunData]:
    """The parts of a run that sweeps the band, by band."""
    parts = [part for part in variants(run).values() if "beep.start_hz" in (part.cells[0]["cell"].get("variant") or {})]
    return {band_name(part.cells[0]["cell"]): part for part in parts}
