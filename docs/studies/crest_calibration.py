"""The paper's Fig. 11 on walks of one's own: radius by the width of crests, a line fitted to narrow targets.

obstaclewatch run paper --split dev --set "detectors=[PaperDetector(pulse_width_removed=False, local_threshold=False)]"
python -m docs.studies.crest_calibration results/paper/latest
"""

from __future__ import annotations

import sys

import numpy as np

from benchmarks.figures.measured import detectors_of
from benchmarks.runs.results import RunData, load_run
from benchmarks.scoring.scores import beep_table, judged
from obstaclewatch.support.arrays import Floats


def crest_m(range_m: Floats, radius_m: Floats) -> Floats:
    """(n,) half a crest's width, m: Eq. 3 undone, radius^2 = (range + crest)^2 - range^2."""
    return np.hypot(range_m, radius_m) - range_m


def calibration_line(crest: Floats, radius_m: Floats) -> tuple[float, float, float]:
    """Radius of a crest without width, m, its growth per metre of crest, and the correlation of both."""
    slope, least_m = np.polyfit(crest, radius_m, 1)
    return float(least_m), float(slope), float(np.corrcoef(crest, radius_m)[0, 1])


def calibration_lines(run: RunData) -> list[str]:
    """One line for each detector whose radii are those of crests as printed."""
    lines = []
    for name in detectors_of(run):
        table = judged(beep_table(run, name, "approach"), "radius_m")
        known = np.isfinite(table["radius_m"])
        if "pulse_width_removed=False" not in name or known.sum() < 3:
            continue
        crest, true = crest_m(table["range_m"][known], table["radius_m"][known]), table["true_radius_m"][known]
        least_m, slope, correlation = calibration_line(crest, true)
        walks = len(np.unique(table["label"][known]))
        lines.append(
            f"{name}: radius = {least_m:.3f} m {slope:+.3f} x crest, correlation {correlation:+.2f}, "
            f"{known.sum()} beeps of {walks} walks"
        )
    return lines


if __name__ == "__main__":
    print("\n".join(calibration_lines(load_run(sys.argv[1]))))
