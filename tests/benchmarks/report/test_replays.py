"""Walks to watch: chosen, computed again to the same alerts, packed small, and played in a browser."""

from __future__ import annotations

import base64
import json
import re
import subprocess

import numpy as np
import pytest
import trimesh

from benchmarks.cells.compute import compute
from benchmarks.cells.spec import Cell
from benchmarks.plan.suite import load_suite
from benchmarks.report.replays.chosen_walks import ChosenWalk, chosen_walks
from benchmarks.report.replays.outline import PlanFrame, Window, outline
from benchmarks.report.replays.replay import replay
from benchmarks.report.replays.stored_replays import replays_of
from benchmarks.report.report import write_report
from simulator import Material, Obstacle
from tests.benchmarks.synthetic_run import made_up_run, record, walk
from tests.scenes.browser import QUIET, browser, on_a_phone, screenshot

WIDE = Window(-10.0, 10.0, -10.0, 10.0)
HERE = PlanFrame(np.zeros(2), 0.0)


def a_cell(**changed) -> Cell:
    suite = load_suite("paper")
    given = {
        "kind": "approach", "scene": "supermarket", "category": "wall", "index": 2, "phone": "galaxy-s8-plus",
        "seed": 41, "collision": True, "beep": suite.beep, "fidelity": {"max_order": 1},
        "detectors": ("PaperDetector", "TrackingDetector"), "scoring": suite.scoring,
    }  # fmt: skip
    return Cell(**given | changed)


@pytest.fixture(scope="module")
def stored():
    """A real walk as a run stores it, and the same packed for watching."""
    cell = a_cell()
    result = json.loads(json.dumps(compute(cell)))
    return record(cell, result["truth"], result["detectors"]), replay(cell)


def _area(ring) -> float:
    x, y = np.asarray(ring).T
    return 0.5 * abs(float(np.dot(x, np.roll(y, -1)) - np.dot(y, np.roll(x, -1))))


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.2])
def test_the_outline_of_a_box_is_its_plan(turn):
    box = trimesh.creation.box((2.0, 0.5, 1.0))
    box.apply_transform(trimesh.transformations.rotation_matrix(turn, [0, 0, 1]))
    box.apply_translation([1.0, 2.0, 0.5])
    (ring,) = outline(Obstacle(box, Material.rigid(), "box"), HERE, WIDE)
    assert len(ring) == 5
    assert _area(ring) == pytest.approx(1.0, abs=5e-4)  # corners are rounded to 0.1 mm
    corners = np.asarray(box.vertices)[:, :2]
    distance = np.linalg.norm(corners[:, None] - ring[None], axis=2).min(axis=1)
    assert distance.max() < 1e-4


def test_what_is_above_the_walker_or_outside_the_window_has_no_outline():
    box = trimesh.creation.box((1.0, 1.0, 1.0))
    high = Obstacle(box.copy().apply_translation([0.0, 0.0, 3.0]), Material.rigid(), "balcony")
    away = Obstacle(box.copy().apply_translation([30.0, 0.0, 0.5]), Material.rigid(), "far")
    assert outline(high, HERE, WIDE) == outline(away, HERE, WIDE) == []


def test_the_frame_turns_with_the_walk():
    frame = PlanFrame(np.array([1.0, 1.0]), np.pi / 2.0)
    np.testing.assert_allclose(frame.of_world(np.array([[1.0, 3.0], [0.0, 1.0]])), [[2.0, 0.0], [0.0, 1.0]], atol=1e-12)


def test_a_window_without_width_is_refused():
    with pytest.raises(ValueError, match="left < right"):
        Window(1.0, 1.0, 0.0, 1.0)


def test_the_worst_and_one_of_every_category_are_chosen(tmp_path):
    cells = [
        walk(index=0, alert_distance_m=None),
        walk(index=1, alert_distance_m=None),
        walk(index=2, collides=False),
        walk(index=3),
        walk("campus", "car", index=4, collides=False, alert_distance_m=None),
        walk("campus", "car", index=5, alert_distance_m=2.0),
        walk("campus", "sign", index=6, collides=False, alert_distance_m=None),
    ]
    run = made_up_run(tmp_path, cells)
    chosen = [(one.record["label"], one.why.split(":")[0]) for one in chosen_walks(run)]
    assert chosen == [
        ("supermarket/wall/0", "missed collision of PaperDetector"),
        ("supermarket/wall/2", "false alert of PaperDetector"),
        ("campus/car/5", "example of a car"),
        ("campus/sign/6", "example of a sign"),
    ]
    assert len(chosen_walks(run, most=2)) == 2
    with pytest.raises(ValueError, match="at least 0, got -1"):
        chosen_walks(run, most=-1)


def test_a_replay_alerts_as_the_cell_did_and_knows_its_truth(stored):
    cell, played = stored
    assert played["truths"][0]["contact_s"] == pytest.approx(cell["result"]["truth"]["contact_time_s"], abs=1e-3)
    for entry in played["detectors"]:
        result = cell["result"]["detectors"][entry["name"]]
        assert (entry["alert_s"] is not None) == result["alert"]
        heard = result["beeps"][0]
        truth = np.array(played["truths"][0]["cm"])[heard["beep"]] / 100.0
        np.testing.assert_allclose(truth, heard["true_range_m"], atol=0.0051)


def test_the_echogram_is_brightest_along_the_truth(stored):
    """Of a wall that faces the walker; the chirp reads what closes in short by 0.205 s of way, 20 to 33 cm."""
    played = stored[1]
    shape = played["echogram"]["beeps"], played["echogram"]["bins"]
    level = np.frombuffer(base64.b64decode(played["echogram"]["bytes"]), dtype=np.uint8).reshape(shape)
    truth = np.array(played["truths"][0]["cm"], dtype=float)[: len(level)] / 100.0
    away = np.arange(shape[1]) * played["echogram"]["bin_m"]
    tested = np.flatnonzero((truth > 2.0) & (truth < 4.0))
    assert len(tested) > 10
    peaks = np.array([away[np.argmax(np.where(np.abs(away - truth[k]) < 1.0, level[k], 0))] for k in tested])
    assert -0.40 < np.median(peaks - truth[tested]) < 0.05


def test_a_walk_is_packed_in_less_than_200_kb_and_twice_the_same(stored):
    text = json.dumps(stored[1], separators=(",", ":"), allow_nan=False)
    assert 20_000 < len(text) < 200_000
    assert json.dumps(replay(a_cell()), separators=(",", ":"), allow_nan=False) == text


def test_a_standing_measurement_cannot_be_watched():
    with pytest.raises(ValueError, match="got 'standing'"):
        replay(a_cell(kind="standing", range_m=3.0))


def test_what_is_kept_is_not_computed_again_unless_damaged(tmp_path, stored, monkeypatch):
    walks = [ChosenWalk(stored[0], "a wall")]
    first = replays_of(tmp_path, walks)
    (kept,) = (tmp_path / "replays").glob("*.json")
    monkeypatch.setattr("benchmarks.report.replays.replay.replay", lambda cell: pytest.fail("it was computed again"))
    assert replays_of(tmp_path, walks) == first
    assert first[0]["faithful"] is True
    kept.write_text(kept.read_text(encoding="utf-8").replace('"window"', '"windou"'), encoding="utf-8")
    with pytest.raises(pytest.fail.Exception):
        replays_of(tmp_path, walks)


def test_another_alert_than_the_stored_one_is_said(tmp_path, stored):
    cell = json.loads(json.dumps(stored[0]))
    entry = cell["result"]["detectors"]["TrackingDetector"]
    entry.update(alert=not entry["alert"], alert_time_s=1.0)
    assert replays_of(tmp_path, [ChosenWalk(cell, "a wall")])[0]["faithful"] is False


def test_a_walk_that_cannot_be_computed_any_more_says_why(tmp_path, stored):
    gone = json.loads(json.dumps(stored[0]))
    gone["cell"]["detectors"] = ["nowhere_to_be_found:MyDetector"]
    shown = replays_of(tmp_path, [ChosenWalk(gone, "a wall")])
    page = write_report(made_up_run(tmp_path, []), shown).read_text(encoding="utf-8")
    assert "cannot be shown: detector module &#39;nowhere_to_be_found&#39; cannot be imported" in page


def test_a_run_of_another_version_is_said_without_a_player(tmp_path, stored):
    old = json.loads(json.dumps(stored[0]))
    old["cell"]["no_longer_a_field"] = 1
    shown = replays_of(tmp_path, [ChosenWalk(old, "a wall")])
    page = write_report(made_up_run(tmp_path, []), shown).read_text(encoding="utf-8")
    assert "its settings are of another version of the source: Extra inputs are not permitted" in page
    assert "<script" not in page


SCRIPT = """
<script>
const section = document.getElementById("walks"), find = name => section.querySelector("." + name);
const seen = () => [find("plan").toDataURL(), find("echogram").toDataURL(), find("clock").textContent];
const states = [seen()], note = () => states.push(seen());
function press(key) {
  find("player").dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
  note();
}
function slide(value) {
  find("instant").value = value;
  find("instant").dispatchEvent(new Event("input"));
  note();
}
slide(4); slide(20); press("ArrowRight"); press("Home");
find("detectors").lastElementChild.click(); note();
const differ = states.slice(1).map((state, k) => state.map((part, i) => Number(part !== states[k][i])).join(""));
press(" ");
const clocks = states.map(state => state[2]).join(",");
document.title = `clocks ${clocks} differ ${differ.join(",")} ${find("play").textContent}`;
press(" ");
setTimeout(() => document.title += ` ${location.hash}`, 600);
</script>
"""


def test_slider_keys_and_buttons_move_the_picture(tmp_path, stored):
    """In headless Chromium: the title afterwards holds the clocks, and which of plan, echogram and clock changed."""
    page = write_report(made_up_run(tmp_path, []), replays_of(tmp_path, [ChosenWalk(stored[0], "a <wall>")]))
    html = page.read_text(encoding="utf-8")
    assert "a \\u003cwall>" in html
    assert not re.search(r"https?://|@import|url\(|<script[^>]*src", html)
    page.write_text(html.replace("</body>", SCRIPT + "</body>"), encoding="utf-8")
    done = subprocess.run(
        [browser(), *QUIET.split(), "--host-resolver-rules=MAP * ~NOTFOUND", f"--user-data-dir={tmp_path / 'profile'}",
         "--window-size=1200,1000", "--dump-dom", f"{page.as_uri()}#walk=0&t=1.8&detector=PaperDetector"],
        check=True, capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    title = re.search(r"<title>clocks (.*) differ (.*) (\w+) (\S+)</title>", done.stdout)
    assert title is not None, done.stdout[:500]
    assert title[1].split(",")[:5] == ["1.80 s", "0.18 s", "0.90 s", "0.94 s", "0.00 s"]
    changes = title[2].split(",")
    assert changes[:4] == ["111"] * 4
    assert changes[4][1:] == "10"  # another detector's candidates at the same instant
    assert title[3] == "Pause"
    assert title[4].startswith("#walk=0&amp;t=0.0")  # what is seen can be linked to
    assert title[4].endswith("&amp;detector=TrackingDetector")


def test_the_player_is_drawn(tmp_path, stored):
    """The target in its colour, the swept body, and the echogram's ink, at both widths."""
    page = write_report(made_up_run(tmp_path, []), replays_of(tmp_path, [ChosenWalk(stored[0], "a wall")]))
    alone = "<style>section:not(#walks), header { display: none }</style></head>"
    page.write_text(page.read_text(encoding="utf-8").replace("</head>", alone), encoding="utf-8")
    for width in (1200, 700):
        pixels = screenshot(page, tmp_path, size=(width, 1100))
        wall = np.abs(pixels - np.array([172, 105, 73]) / 255.0).max(axis=2) < 0.06
        swept = np.abs(pixels - np.array([246, 231, 176]) / 255.0).max(axis=2) < 0.02
        ink = np.abs(pixels - np.array([24, 38, 62]) / 255.0).max(axis=2) < 0.05
        assert min(wall.sum(), swept.sum(), ink.sum()) > 500, (width, wall.sum(), swept.sum(), ink.sum())


def test_the_player_fits_a_phone(tmp_path, stored):
    """The key of its colours was one word too long to be broken."""
    page = write_report(made_up_run(tmp_path, []), replays_of(tmp_path, [ChosenWalk(stored[0], "a wall")]))
    assert on_a_phone(page, tmp_path, 400)[0] <= 400


def test_without_walks_the_page_has_no_script(tmp_path):
    assert "<script" not in write_report(made_up_run(tmp_path, [])).read_text(encoding="utf-8")
