"""The table of what each erratum costs, from cells written by hand."""

from __future__ import annotations

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from benchmarks.plan.suite import load_suite
from benchmarks.runs.results import RunData
from docs.studies.crest_calibration import calibration_line, crest_m
from docs.studies.errata_table import HEADER, errata_rows, markdown
from obstaclewatch import Errata


def cell(kind, outcome, error_m, candidates):
    beeps = {
        "range_m": [3.0 + error_m, None],
        "true_range_m": [3.0, 3.0],
        "bearing_rad": [np.radians(10.0 + 100.0 * error_m), None],
        "true_bearing_rad": [np.radians(10.0)] * 2,
        "radius_m": [0.2, None],
        "candidates": [candidates, 0],
    }
    return {"beeps": [beeps], "outcome": outcome}


def record(kind, good, bad):
    entries = {"PaperDetector(walker_width=False)": bad, "PaperDetector": good}
    return {"cell": {"kind": kind}, "status": "ok", "result": {"detectors": entries}}


def test_rows_are_medians_and_counts_the_corrected_detector_first():
    records = (
        record("standing", cell("standing", "TN", 0.01, 1), cell("standing", "TN", -0.03, 1)),
        record("approach", cell("approach", "TP", 0.5, 2), cell("approach", "FN", 0.5, 4)),
        record("approach", cell("approach", "TN", 0.5, 2), cell("approach", "FP", 0.5, 4)),
    )
    rows = errata_rows(RunData(Path(), {}, records))
    assert rows == [
        ["nothing", "1.0", "1.0", "0.20", "50%", "1.0", "1 of 1", "1 of 1"],
        ["`walker_width`", "3.0", "3.0", "0.20", "50%", "2.0", "0 of 1", "0 of 1"],
    ]
    assert len(markdown(rows).splitlines()) == 4
    assert markdown(rows).splitlines()[0].count("|") == len(HEADER) + 1


@pytest.mark.parametrize("part", ["walks", "standing"])
def test_the_suite_flips_every_switch_once(part):
    suite = load_suite("errata")
    assert suite.standing is not None
    named = suite.detectors if part == "walks" else suite.standing.detectors
    switches = [f"PaperDetector({f.name}=False)" for f in fields(Errata)]
    assert sorted(named) == sorted(["PaperDetector", "PaperDetector(reading='calibrated')", *switches])


def test_a_calibration_finds_the_line_that_the_crests_were_made_of():
    """Eq. 3 read backwards, and a line of 5 cm + 2 x crest."""
    crest, range_m = np.array([0.02, 0.05, 0.10, 0.04]), np.array([1.0, 2.0, 3.0, 1.5])
    read = np.sqrt((range_m + crest) ** 2 - range_m**2)
    assert crest_m(range_m, read) == pytest.approx(crest, abs=1e-12)
    assert calibration_line(crest, 0.05 + 2.0 * crest) == pytest.approx((0.05, 2.0, 1.0), abs=1e-9)
