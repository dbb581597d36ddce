"""The page that shows a scene in three dimensions: what is in it, and what a browser makes of it."""

import base64
import html
import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from benchmarks.cli import cli
from scenes import load_encounter, load_scene
from scenes.preview.page import KINDS, preview_html
from scenes.preview.silhouette import outer_rings, silhouette
from tests.scenes.browser import screenshot

YARD = """
name: yard </script> & co
obstacles:
  - {kind: wall, name: garage, at_m: [4, 0]}
  - {kind: litter_bin, name: bin, at_m: [2, 0.9]}
  - {kind: bollard, name: rolling, at_m: [3, -1], velocity_m_s: [-0.5, 0, 0]}
walk: {start_m: [0, 0], duration_s: 2}
"""


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("page")
    (folder / "yard.yaml").write_text(YARD)
    result = CliRunner().invoke(cli, ["scene", "preview", str(folder / "yard.yaml"), "-o", str(folder / "yard.html")])
    assert result.exit_code == 0, result.output
    return folder / "yard.html"


def data_of(page: Path) -> dict:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page.read_text(), re.DOTALL)
    assert found is not None
    return json.loads(found.group(1))


def corners(trace: dict, names: str = "xyz") -> np.ndarray:
    columns = [np.frombuffer(base64.b64decode(trace[name]["bdata"]), f"<{trace[name]['dtype']}") for name in names]
    return np.stack(columns, axis=1)


def test_the_page_holds_the_scene_and_needs_no_network(page: Path) -> None:
    text, data = page.read_text(), data_of(page)
    own = re.sub(r"<script>.*?</script>", "", text, flags=re.DOTALL)  # the packed library names pages of its own
    assert not re.search(r"https?://|src=|@import|url\(", own)
    assert "<title>yard &lt;/script&gt; &amp; co</title>" in text
    obstacles = load_encounter(page.with_suffix(".yaml")).scene.obstacles
    for shown, obstacle in zip(data["data"], obstacles, strict=False):
        assert (shown["name"], shown["hovertext"]) == (obstacle.category, obstacle.name)
        np.testing.assert_allclose(corners(shown), obstacle.mesh.vertices, atol=1e-5)
        np.testing.assert_array_equal(corners(shown, "ijk"), obstacle.mesh.faces)


def test_the_slider_moves_what_moves_and_shows_where_the_sound_goes(page: Path) -> None:
    data = data_of(page)
    frames = data["frames"]
    assert [frame["name"] for frame in frames] == [f"{t:.2f} s" for t in (0.0, 0.4, 0.8, 1.2, 1.6, 2.0)]
    assert [step["args"][0] for step in data["layout"]["sliders"][0]["steps"]] == [[f["name"]] for f in frames]
    rolled = [corners(frame["data"][0])[:, 0].mean() for frame in frames]
    np.testing.assert_allclose(np.diff(rolled), -0.2, atol=1e-5)
    for frame in frames:
        drawn = [data["data"][k].get("legendgroup") for k in frame["traces"][1:]]
        assert drawn == [trace.get("legendgroup") for trace in frame["data"][1:]]
        assert "specular" in drawn
        assert set(drawn) - {"phone", "walker"} <= set(KINDS)
    # the wall's face comes nearer by 1.3 m/s; the surge of the gait adds up to 2 cm
    listed = [frame["layout"]["annotations"][0]["text"].split("<br>")[1:] for frame in frames]
    levels = [[float(line.split()[0]) for line in lines] for lines in listed]
    assert all(each == sorted(each, reverse=True) for each in levels)
    ranges = [next(float(line.split()[2]) for line in lines if line.endswith("m  garage")) for lines in listed]
    np.testing.assert_allclose(np.diff(ranges), -0.52, atol=0.05)


@pytest.mark.parametrize("name", ["<!--<script>", "{title}", "<b>%{x}</b>", "</title><script>alert(1)</script>"])
def test_no_name_leaves_its_place_in_the_page(tmp_path: Path, name: str) -> None:
    """Cause: within a script element "<!--<script>" hides its end, so that the page stayed blank."""
    (tmp_path / "yard.yaml").write_text(json.dumps({"name": name, "obstacles": [{"kind": "bollard", "name": name}]}))
    page = preview_html(load_scene(tmp_path / "yard.yaml"), tmp_path / "yard.html")
    text = page.read_text(encoding="utf-8")
    assert data_of(page)["layout"]["title"]["text"] == html.escape(name, quote=False)
    assert data_of(page)["data"][-2]["text"] == [html.escape(name, quote=False)]
    assert f"<title>{html.escape(name, quote=False)}</title>" in text
    data = text[text.index('type="application/json">') + 24 :]
    assert "<" not in data[: data.index("</script>")]


def test_a_scene_alone_can_be_shown(tmp_path: Path, page: Path) -> None:
    data = data_of(preview_html(load_encounter(page.with_suffix(".yaml")).scene, tmp_path / "scene.html"))
    assert data["frames"] == data["layout"]["sliders"] == []
    assert "path of the phone" not in {trace["name"] for trace in data["data"]}


def test_a_browser_draws_it(tmp_path: Path, page: Path) -> None:
    """The bricks and the bin are there, on a busy machine after a while, and one before the other."""
    for wait_ms in (4_000, 16_000, 64_000):
        red, green, blue = np.moveaxis(screenshot(page, tmp_path, wait_ms=wait_ms), 2, 0)
        bricks, bin_ = (
            ((red > 1.5 * blue) & (red > 1.4 * green)).sum(),
            ((green > 1.3 * red) & (green > 1.3 * blue)).sum(),
        )
        if bricks > 1000 and bin_ > 200:
            break
    assert bricks > 1000
    assert bin_ > 200


def test_a_silhouette_has_holes_and_a_sheet_seen_edge_on_a_width() -> None:
    square = np.array([[[0, 0], [4, 0], [4, 1]], [[0, 0], [4, 1], [0, 1]]], dtype=float)
    frame = np.concatenate([square, square + [0, 3], square[:, :, ::-1], square[:, :, ::-1] + [3, 0]])
    assert silhouette(frame).area == pytest.approx(12.0)
    (ring,) = outer_rings(silhouette(frame))
    np.testing.assert_allclose([ring.min(axis=0), ring.max(axis=0)], [[0, 0], [4, 4]])
    assert 0.04 < silhouette(square * [1.0, 0.0]).area < 0.1


def test_another_kind_of_picture_is_refused(tmp_path: Path) -> None:
    result = CliRunner().invoke(cli, ["scene", "preview", "campus", "-o", str(tmp_path / "x.svg")])
    assert isinstance(result.exception, ValueError)
    assert "output must end in .html or .png" in str(result.exception)
