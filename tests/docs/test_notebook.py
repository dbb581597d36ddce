"""The notebook runs from its first cell to its last, quickly, and holds the outputs that it shows."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import nbformat
import pytest
from nbclient import NotebookClient

PAGE = Path(__file__).resolve().parents[2] / "docs" / "tutorial_notebook.ipynb"
MEASURE = "import resource; resource.getrusage(resource.RUSAGE_SELF).ru_utime"
MOST_CPU_S = 60.0
"""Warm it takes 7 s; the first time, what is compiled comes on top."""


def outputs(notebook: Any) -> list[list[str]]:
    """Kinds of data that each cell of code shows, outputs of warnings apart."""
    shown = [cell.outputs for cell in notebook.cells if cell.cell_type == "code"]
    return [sorted({kind for each in cell for kind in each.get("data", ())}) for cell in shown]


def test_every_cell_runs_and_shows_what_is_stored(tmp_path: Path) -> None:
    stored = nbformat.read(PAGE, as_version=4)
    ran = nbformat.read(PAGE, as_version=4)
    ran.cells.append(nbformat.v4.new_code_cell(MEASURE))
    NotebookClient(ran, timeout=600, resources={"metadata": {"path": str(tmp_path)}}).execute()
    *shown, _ = outputs(ran)
    assert shown == outputs(stored)
    assert sum(kinds != [] for kinds in shown) >= 7
    assert float(ran.cells[-1].outputs[0].data["text/plain"]) < MOST_CPU_S


@pytest.mark.parametrize(
    "word", ["<th>off</th>", "Scene(", "Recording(2 x 345600", "alert=True", "range_error_median_m"]
)
def test_objects_show_themselves(word: str) -> None:
    """Short texts and tables, not pages of arrays."""
    cells = [cell for cell in nbformat.read(PAGE, as_version=4).cells if cell.cell_type == "code"]
    texts = [str(data) for cell in cells for each in cell.outputs for data in each.get("data", {}).values()]
    assert any(word in text for text in texts)
    assert (
        max(
            len(text)
            for cell in cells
            for each in cell.outputs
            for text in [each.get("data", {}).get("text/plain", "")]
        )
        < 1500
    )
