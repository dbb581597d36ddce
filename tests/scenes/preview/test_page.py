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
from scenes.preview.page import KINDS, preview_html, tube
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


def test_the_page_holds_the_scene_and_needs_no_network(page: Path) -> None:
    text, data = page.read_text(), data_of(page)
    assert not re.search(r"https?://|src=|@import|url\(", text)
    assert data["name"] == "yard </script> & co"
    assert "<title>yard &lt;/script&gt; &amp; co</title>" in text
    scene = load_encounter(page.with_suffix(".yaml")).scene
    assert [o["name"] for o in data["obstacles"]] == ["ground", "garage", "bin", "rolling"]
    for shown, obstacle in zip(data["obstacles"], scene.obstacles, strict=True):
        vertices = np.frombuffer(base64.b64decode(shown["mesh"]["vertices"]), "<f4").reshape(-1, 3)
        faces = np.frombuffer(base64.b64decode(shown["mesh"]["faces"]), "<u4").reshape(-1, 3)
        normals = np.frombuffer(base64.b64decode(shown["mesh"]["normals"]), np.int8).reshape(-1, 3, 3)
        np.testing.assert_allclose(vertices, obstacle.mesh.vertices, atol=1e-5)
        np.testing.assert_array_equal(faces, obstacle.mesh.faces)
        assert normals.shape == (len(faces), 3, 3)
        np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 127.0, atol=1.5)
    assert data["obstacles"][3]["velocity"] == [-0.5, 0.0, 0.0]


def test_the_page_shows_where_the_sound_goes(page: Path) -> None:
    instants = data_of(page)["instants"]
    assert [round(one["time_s"], 3) for one in instants] == [0.0, 0.4, 0.8, 1.2, 1.6, 2.0]
    for one in instants:
        assert set(one["paths"]) <= set(KINDS)
        assert "specular" in one["paths"]
        levels = [echo["level_db"] for echo in one["strongest"]]
        assert levels == sorted(levels, reverse=True)
        assert any(echo["obstacle"] == "ground" for echo in one["strongest"])
    # the wall's face comes nearer by 1.3 m/s; the surge of the gait adds up to 2 cm
    ranges = [next(e["range_m"] for e in one["strongest"] if e["obstacle"] == "garage") for one in instants]
    np.testing.assert_allclose(np.diff(ranges), -0.52, atol=0.05)


def test_a_tube_keeps_its_radius_along_any_line() -> None:
    points = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 2.0], [0.0, 0.0, 2.0], [3.0, 1.0, 2.0]])
    found = tube(points, 0.1)
    assert len(found.faces) == 2 * 2 * 6
    first, second = found.vertices[:12], found.vertices[12:]
    np.testing.assert_allclose(np.linalg.norm(first[:, :2], axis=1), 0.1, atol=1e-12)
    along = np.array([3.0, 1.0, 0.0]) / np.sqrt(10.0)
    offset = second - points[2] - np.outer((second - points[2]) @ along, along)
    np.testing.assert_allclose(np.linalg.norm(offset, axis=1), 0.1, atol=1e-12)


@pytest.mark.parametrize("name", ["<!--<script>", "__DATA__", "__TITLE__", "</title><script>alert(1)</script>"])
def test_no_name_leaves_its_place_in_the_page(tmp_path: Path, name: str) -> None:
    """Cause: within a script element "<!--<script>" hides its end, so that the page stayed blank."""
    (tmp_path / "yard.yaml").write_text(json.dumps({"name": name, "obstacles": [{"kind": "bollard", "name": name}]}))
    page = preview_html(load_scene(tmp_path / "yard.yaml"), tmp_path / "yard.html")
    text = page.read_text(encoding="utf-8")
    assert data_of(page)["name"] == name
    assert data_of(page)["obstacles"][-1]["name"] == name
    assert f"<title>{html.escape(name)}</title>" in text
    assert "<" not in text[text.index('type="application/json">') + 24 : text.index("</script>")]


def test_a_scene_alone_can_be_shown(tmp_path: Path, page: Path) -> None:
    scene = load_encounter(page.with_suffix(".yaml")).scene
    data = data_of(preview_html(scene, tmp_path / "scene.html"))
    assert data["instants"] == []
    assert data["walk"] is None


def test_a_browser_draws_it_and_turns_it(tmp_path: Path, page: Path) -> None:
    """The bricks and the bin are there; another azimuth, and another instant, give other pictures."""
    plain = screenshot(page, tmp_path, "ui=0&az=-125")
    assert plain.shape == (400, 600, 3)
    assert np.std(plain) > 0.05
    red, green, blue = (plain[..., k] for k in range(3))
    brick, bin_ = (red > 1.5 * blue) & (red > 1.4 * green), (green > 1.3 * red) & (green > 1.3 * blue)
    assert brick.sum() > 1000
    assert bin_.sum() > 200
    turned = screenshot(page, tmp_path, "ui=0&az=-35")
    assert (np.abs(turned - plain).max(axis=2) > 0.1).mean() > 0.1
    later = screenshot(page, tmp_path, "ui=0&az=-125&t=5")
    assert 150 < (np.abs(later - plain).max(axis=2) > 0.1).sum() < 0.3 * 400 * 600


def test_another_kind_of_picture_is_refused(tmp_path: Path) -> None:
    result = CliRunner().invoke(cli, ["scene", "preview", "campus", "-o", str(tmp_path / "x.svg")])
    assert isinstance(result.exception, ValueError)
    assert "output must end in .html or .png" in str(result.exception)
