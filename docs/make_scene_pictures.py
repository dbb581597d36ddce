"""Draws docs/supermarket.png, docs/campus.png and docs/approach_statistics.png; the first two need Chromium.

python -m docs.make_scene_pictures
"""

from __future__ import annotations

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

from docs.studies.approach_statistics import approach_statistics, plot_statistics, statistics_table
from scenes import GaitWalk, load_scene, walker_body
from scenes.preview.page import preview_figure, write_page
from simulator import Phone

DOCS = Path(__file__).parent
INSTANT_S = 0.9
QUIET = "--headless --no-sandbox --hide-scrollbars --use-angle=swiftshader --enable-unsafe-swiftshader"


def street_picture(name: str) -> None:
    """One street with the walker in it and the strongest echoes, 1200 x 640 pixels."""
    browser = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
    if browser is None:
        raise SystemExit("Chromium must be installed to draw the streets")
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), duration_s=4.5)
    phone = Phone.named("galaxy-s5").held_by(walker_body(phone_height_m=1.3))
    with tempfile.TemporaryDirectory() as folder:
        figure = preview_figure(load_scene(name), walk, phone, [INSTANT_S])
        figure["layout"] |= {
            "title": {"text": ""},
            "sliders": [],
            "annotations": [],
            "margin": dict.fromkeys("lrtb", 0),
            "modebar": dict.fromkeys(("color", "activecolor"), "rgba(0, 0, 0, 0)"),  # buttons, of no use in a picture
        }
        # nor are names, which lie on top of each other far away; colours say what is what
        figure["data"] = [trace for trace in figure["data"] if trace.get("name") != "names"]
        page = write_page(figure, Path(folder) / "page.html")
        subprocess.run(
            [browser, *QUIET.split(), "--window-size=1200,640", "--timeout=100000",
             f"--user-data-dir={folder}/profile", f"--screenshot={DOCS / name}.png", page.as_uri()],
            check=True, capture_output=True, timeout=200,
        )  # fmt: skip


if __name__ == "__main__":
    for street in ("supermarket", "campus"):
        street_picture(street)
    found = approach_statistics()
    plot_statistics(found, DOCS / "approach_statistics.png")
    for row in statistics_table(found):
        print(f"{row['quantity']:45} {row['p5']:8.2f} {row['median']:8.2f} {row['p95']:8.2f}")
