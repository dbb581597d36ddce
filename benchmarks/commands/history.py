"""`obstaclewatch history`: accuracy and cost over stored runs."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

if TYPE_CHECKING:
    import pandas as pd


@click.command()
@click.argument("results", type=click.Path(path_type=Path, file_okay=False), default=Path("results"))
@click.option("-o", "--out", type=click.Path(path_type=Path, file_okay=False), help="of table and pictures  [RESULTS]")
@click.option("--suite", help="of this suite alone")
def history(results: Path, out: Path | None, suite: str | None) -> None:
    """Table and pictures of all runs below the folder RESULTS: accuracy and cost by commit.

    Leaves history.csv, and a figure of all runs of one suite, tier, split, seed and number of cells where these are two
    or more. Sweeps and unfinished runs are left out.
    """
    from benchmarks.figures import DrawnFigure, write_figures
    from benchmarks.history import history as collected
    from benchmarks.history import history_figures
    from benchmarks.runs.store import write_atomically

    frame, silent = collected(results)
    if suite is not None and not frame.empty:
        frame = frame[frame.suite == suite]
    if frame.empty:
        raise ValueError(f"no finished run{f' of suite {suite!r}' if suite else ''} in '{results}'")
    target = results if out is None else out
    write_atomically(target / "history.csv", frame.to_csv(index=False))
    click.echo(_table(frame))
    for folder in silent:
        click.echo(f"left out, as it has no summary of walks that can be read: {folder}")
    click.echo(target / "history.csv")
    figures = [DrawnFigure(figure) for figure in history_figures(frame)]
    if not figures:
        click.echo("no picture: no two runs are of one suite, tier, split, seed and number of cells")
    for path in write_figures(target, figures) if figures else ():
        click.echo(path)


def _table(frame: pd.DataFrame) -> str:
    """The rows for people: percent, cm and ms."""
    shown = type(frame)(
        {
            "begun": frame.started.str[:16], "revision": frame.revision,
            "suite": frame.suite + " " + frame.tier + " " + frame.split + " " + frame.seed.astype(str),
            "cells": frame.cells,
            "detector": frame.detector, "TP (%)": 100 * frame.tp_before_contact, "TN (%)": 100 * frame.tn,
            "range (cm)": 100 * frame.range_error_median_m, "ms a beep": 1e3 * frame.detect_cpu_s_per_beep,
        }
    )  # fmt: skip
    return shown.to_string(index=False, float_format="%.1f", na_rep="-")
