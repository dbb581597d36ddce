"""A suite from plan to results: what `obstaclewatch run` does, for scripts and notebooks."""

from __future__ import annotations

import json
import reprlib
import sys
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.cells.spec import Cell
from benchmarks.plan.cells import plan_cells, plan_digest, thinned
from benchmarks.plan.label_filter import label_filter
from benchmarks.plan.suite import Suite, load_suite
from benchmarks.plan.trust import check_trust
from benchmarks.runs.executors import choose_executor
from benchmarks.runs.manifest import manifest
from benchmarks.runs.results import RunData, load_run, read_manifest
from benchmarks.runs.runner import run_cells, shortfall
from benchmarks.runs.store import point_to, to_json, write_atomically
from benchmarks.runs.variants import variants
from benchmarks.scoring.scores import summary
from obstaclewatch.support.argument_types import check_counts, check_types
from obstaclewatch.support.words import counted

if TYPE_CHECKING:
    import pandas as pd


def run(
    suite: str | Path,
    tier: str = "ci",
    *,
    jobs: int = 1,
    seed: int | None = None,
    split: str | None = None,
    settings: Mapping[str, Any] | None = None,
    labels: str | None = None,
    limit: int | None = None,
    out: str | Path = "results",
    allow_code: bool = False,
) -> pd.DataFrame:
    """Compute what is missing of a suite, store it as `obstaclewatch run` does, and return its results.

    Figures and a report of the same folder are drawn by `obstaclewatch figures` and `obstaclewatch report`.

    Args:
        suite: a name of `obstaclewatch ls suites`, or a YAML file.
        tier: "smoke", "ci" or "full".
        jobs: worker processes.
        seed, split: replace the suite's.
        settings: values by dotted key that replace the suite's, such as {"beep.start_hz": 16_000.0}.
        labels: cells whose label fits, such as "dustbin and not campus".
        limit: so many of the cells at most, spread over the suite.
        out: folder of all runs.
        allow_code: let a suite of somebody else import the modules that it names as detectors.

    Returns:
        A row a cell and detector; units end the columns' names, NaN is no estimate. See
        `benchmarks.scoring.frames.results_frame`. `attrs["folder"]` says where the run lies, with `beeps.parquet`,
        a row a beep.

    Raises:
        ValueError: what `obstaclewatch run` refuses with exit code 2; another process works on the same run.
        OSError: results cannot be stored; what is done is kept.
        RuntimeError: every cell failed; the message gives the first reason.

    Warns:
        RuntimeWarning: some cells failed, or are missing as their worker died; the message says how many, and the first
            reason. A cell that failed has one row without a detector, its `status` is "failed".

    >>> import tempfile
    >>> from benchmarks import run
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     found = run("ranging", "smoke", limit=1, settings={"standing.detectors": ["PaperDetector"]}, out=folder)
    >>> print(found.label[0], found.detector[0], f"{100 * found.range_error_median_m[0]:.1f} cm")
    standing/wall/1.5m/0 PaperDetector 0.5 cm
    """
    from benchmarks.scoring.frames import results_frame

    suite = str(suite) if isinstance(suite, Path) else suite
    check_types(suite=(suite, str), tier=(tier, str), labels=(labels, str | None), out=(out, str | Path))
    check_counts(1, jobs=jobs, **({} if limit is None else {"limit": limit}))
    texts = setting_texts({} if settings is None else settings)
    chosen = planned(suite, [*texts, *([f"split={split}"] if split else [])], seed, allow_code)
    cells = chosen_cells(chosen, tier, labels=labels, limit=limit)
    options = {"--tier": tier, "--seed": seed, "--split": split, "-k": labels, "--limit": limit}
    asked = [word for name, value in options.items() if value is not None for word in (name, str(value))]
    asked += [word for text in texts for word in ("--set", text)] + ["--allow-code"] * allow_code
    folder = prepared(Path(out), chosen, tier, cells, ["run", suite, *asked])
    tally = run_cells(folder, cells, choose_executor(None, jobs))
    frame = results_frame(tabulated(folder)[0])
    if not tally.complete:
        wrong = f"of {counted(len(cells), 'cell')}: {'; '.join(shortfall(folder, tally, most=1))}"
        if not tally.ok:
            raise RuntimeError(f"nothing was measured {wrong}")
        warnings.warn(f"results are not complete, {wrong}", RuntimeWarning, stacklevel=2)
    frame.attrs["folder"] = str(folder)
    return frame


def setting_texts(settings: Mapping[str, Any]) -> list[str]:
    """Settings as `--set` takes them, "beep.start_hz=16000.0".

    Raises:
        ValueError: no mapping, or a value that no suite file can hold.
    """
    check_types(settings=(settings, Mapping))
    return [f"{key}={json.dumps(value, default=_plain)}" for key, value in settings.items()]


def _plain(value: Any) -> Any:
    """Numbers and arrays of numpy as Python's own."""
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise ValueError(f"settings must hold numbers, texts, lists and mappings, got {reprlib.repr(value)}")


def planned(suite: str, settings: Sequence[str], seed: int | None, allow_code: bool) -> Suite:
    """The suite of that name or file with these settings, if it may run.

    Raises:
        ValueError: as `load_suite` and `check_trust`.
    """
    chosen = load_suite(suite, settings, seed)
    check_trust(chosen, suite, allow_code)
    return chosen


def chosen_cells(
    suite: Suite, tier: str, only: str | None = None, labels: str | None = None, limit: int | None = None
) -> list[Cell]:
    """The cells of a tier: the one that is named, those whose labels fit, at most so many.

    Raises:
        ValueError: none is left, or as `plan_cells`.
    """
    cells = plan_cells(suite, tier)
    kept = [cell for cell in cells if only in (None, cell.label)]
    if not kept:
        raise ValueError(f"--only must name a cell of the plan such as '{cells[0].label}', got '{only}'")
    if labels is not None:
        fits = label_filter(labels)
        kept = [cell for cell in kept if fits(cell.label)]
    if not kept:
        raise ValueError(f"-k must fit a cell of the plan such as '{cells[0].label}', got '{labels}'")
    return thinned(kept, limit)


def prepared(out: Path, suite: Suite, tier: str, cells: Sequence[Cell], argv: Sequence[str] | None = None) -> Path:
    """The run's folder with manifest and resolved suite.

    An existing manifest of the same plan is kept, unless title or figures, which the plan does not hold, are others.

    Raises:
        ValueError: a file stands where the folder would; or the existing manifest is damaged, and what to do.
    """
    _check_folder(out)
    digest = plan_digest(cells, source_fingerprint())
    folder = out / suite.name / f"{tier}-{suite.split}-{suite.seed}-{digest[:8]}"
    shown = suite.title, list(suite.figures)
    if not (folder / "manifest.json").exists() or _shown_in(folder) != shown:
        resolved = yaml.safe_dump(suite.model_dump(mode="json"), sort_keys=False)
        write_atomically(folder / "config.resolved.yaml", resolved)
        asked = sys.argv[1:] if argv is None else argv
        write_atomically(folder / "manifest.json", to_json(manifest(suite, tier, cells, asked)))
    point_to(folder, folder.with_name("latest"))
    return folder


def _check_folder(out: Path) -> None:
    """Refuse results below a file, whose error would name a hidden part of them."""
    there = next((path for path in (out, *out.parents) if path.exists()), out)
    if there.is_file():
        raise ValueError(f"the folder of results must be a folder, got the file '{there}'")


def _shown_in(folder: Path) -> tuple[str, list[str]]:
    """Title and figures by an existing manifest."""
    try:
        found = read_manifest(folder / "manifest.json")
    except ValueError as error:
        raise ValueError(
            f"{error}; without that file the same command writes it anew and keeps the cells, or choose another --out"
        ) from error
    return found.get("title", ""), found.get("figures", [])


def tabulated(folder: Path) -> tuple[RunData, dict[str, Any]]:
    """What is stored of a run, and its summary; its tables and summary.json are written anew."""
    from benchmarks.scoring.frames import write_frames

    data = load_run(folder)
    write_frames(data)
    found = summary(data, variants(data))
    write_atomically(folder / "summary.json", to_json(found))
    return data, found
