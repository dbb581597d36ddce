"""The report: verdict first, numbers that were counted, commands that work, one file that a browser opens offline."""

from __future__ import annotations

import base64
import json
import re
import shlex
from dataclasses import replace

import pytest

import benchmarks.figures
from benchmarks.figures import figures_of, write_figures
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from benchmarks.report.cases import rerun_command, worst_cases
from benchmarks.report.provenance import cost_lines, environment_lines, reproduction_command
from benchmarks.report.report import write_report
from benchmarks.report.verdict import verdict_rows
from benchmarks.runs.manifest import manifest
from tests.benchmarks.synthetic_run import DETECTORS, MANIFEST, default_cells, made_up_run, standing, walk
from tests.scenes.browser import on_a_phone, screenshot


@pytest.fixture(scope="module")
def written(tmp_path_factory):
    """The report of the made-up run, its path and text."""
    path = write_report(made_up_run(tmp_path_factory.mktemp("run")))
    return path, path.read_text(encoding="utf-8")


def test_verdict_comes_first_with_counts_and_intervals(written):
    _, html = written
    assert "PaperDetector: TP 75.0 % (19.4–99.4) before contact".replace(" %", "\u00a0%") in html
    sections = re.findall(r'<section id="(\w+)">', html)
    assert sections == ["verdict", "figures", "strata", "cases", "provenance"]
    assert "Recipe paper: clear-cut walks" in html
    assert html.index("PaperDetector: TP") < html.index('<section id="verdict">')


def test_numbers_are_those_made_up(tmp_path):
    cells = default_cells() + [standing(1.5, index=k) for k in range(2, 6)]
    rows = {f"{row.group}: {row.label}": row for row in verdict_rows(made_up_run(tmp_path, cells))}
    tp = rows["Alerts: TP: collisions with an alert before contact"]
    assert (tp.paper, tp.cells[0].text, tp.cells[0].count) == (">93 %", "75.0 %", "3 of 4")
    assert tp.cells[0].against == "inconclusive"
    assert rows["Alerts: TP, 1 m left"].cells[0].count == "3 of 4"
    assert rows["Thresholds: TP at TN 95 %, 0.5 m left"].cells == (None, None)  # no probability is stated
    near = rows["Standing: Distance1, median at 1.5 m"]
    assert (near.cells[0].text, near.cells[0].count, near.paper) == ("0.40 cm", "18 of 24", "0.25 cm")
    assert near.cells[0].against == "worse"
    assert near.cells[1] is None
    assert rows["Walking: distance, median with its sign"].cells[0].text == "-0.40 cm"
    assert rows["Walking: bearing, median"].cells[0].text == "5.0°"
    assert rows["Walking: radius of targets up to 1 m wide, median"].cells[0].against == "better"


def test_alerts_are_counted_of_all_collisions(tmp_path):
    """Cause: "1.2 m, 6 of 6" of a detector that alerts on 6 of 57 collisions read as if it always alerts."""
    cells = [walk(index=k, alert_distance_m=2.0 if k < 6 else None) for k in range(20)]
    rows = {row.label: row for row in verdict_rows(made_up_run(tmp_path, cells))}
    for what in ("distance", "time"):
        assert rows[f"median {what} to contact at the alert, collisions"].cells[0].count == "6 of 20"
    rows = {row.label: row for row in verdict_rows(made_up_run(tmp_path, [walk(alert_distance_m=None)]))}
    silent = rows["median distance to contact at the alert, collisions"].cells[0]
    assert (silent.text, silent.count) == ("no alert", "0 of 1")


def test_two_places_do_not_decide_against_the_paper(tmp_path):
    """Cause: two standing measurements of equal error were "worse" than the paper, with an interval of no width."""
    rows = {row.label: row for row in verdict_rows(made_up_run(tmp_path))}
    near = rows["Distance1, median at 1.5 m"].cells[0]
    assert (near.text, near.interval, near.against) == ("0.40 cm", "", "")


def test_a_sweep_is_judged_by_its_first_point_and_says_so(tmp_path):
    """Pooled over the points of the suite `budget`, 25 walks read as 300."""
    cells = []
    for name, distance in (("as it is", 2.0), ("deaf", None)):
        for k in range(4):
            stored = walk(index=k, alert_distance_m=distance)
            variant = {"variant": {"name": name}}
            cells.append({**stored, "label": f"{stored['label']}[{name}]", "cell": {**stored["cell"], **variant}})
    run = made_up_run(tmp_path, cells, figures=["fig16"])
    text = write_report(run).read_text(encoding="utf-8").replace("\N{NO-BREAK SPACE}", " ")
    assert "PaperDetector: TP 100.0 % (39.8–100.0) before contact" in text
    assert "Of the sweep, the point &#39;as it is&#39; alone." in text
    assert "[deaf]" not in text[text.index('<section id="cases">') : text.index('<section id="provenance">')]


def test_a_run_of_standing_phones_is_judged_by_its_standing_errors_alone(tmp_path):
    run = made_up_run(tmp_path, [standing(1.5), standing(3.0, 1)])
    path = write_report(run)
    html, text = path.read_text(encoding="utf-8"), (run.folder / "report.md").read_text(encoding="utf-8")
    assert {row.group for row in verdict_rows(run)} == {"Standing"}
    assert "PaperDetector, standing, has nine of ten errors of Distance1 within 0.40 cm" in text
    assert ": TP" not in html + text


def test_a_title_is_text_in_the_markdown_report_too(tmp_path):
    """Cause: report.md carried titles as they were: links, HTML and new headings of whoever wrote the suite."""
    title = "<img src=x onerror=alert(1)> [a](http://b) `c`\n# d"
    write_report(made_up_run(tmp_path, title=title, argv=["run", "a`b\n# e"], figures=["fig16"]))
    text = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert text.startswith("# \\<img src=x onerror=alert(1)\\> \\[a\\](http://b) \\`c\\` # d\n\n")
    assert text.rstrip().endswith("Repeat: `` obstaclewatch run 'a`b # e' ``")


def test_a_run_without_walks_and_standing_phones_has_figures_and_no_verdict(tmp_path):
    run = replace(made_up_run(tmp_path, plan=["a signal"]), cells=[])
    html = write_report(run).read_text(encoding="utf-8")
    assert verdict_rows(run) == []
    assert "see the figures" in html
    assert 'id="verdict"' not in html
    assert "#verdict" not in html
    assert "quantity" not in (run.folder / "report.md").read_text(encoding="utf-8")


def test_one_file_without_a_network(written):
    _, html = written
    links = re.findall(r'(?:src|href)="([^"]*)"', html)
    assert links
    assert all(link.startswith(("data:", "#", "figures/")) for link in links)
    own = re.sub(r"<script.*?</script>", "", html, flags=re.DOTALL)  # the packed library names pages of its own
    assert not re.search(r"https?://|@import|url\(", own)
    assert "src=" not in "".join(re.findall(r"<script[^>]*>", html))


def test_every_figure_has_its_numbers_and_its_chart(written):
    """The links lead to files, and every figure but tables and drawings can be explored."""
    path, html = written
    for name in re.findall(r'href="(figures/[^"]*)"', html):
        assert (path.parent / name).read_text(encoding="utf-8").count("\n") > 1
    charts = json.loads(re.findall(r'<script id="charts"[^>]*>(.*?)</script>', html, re.DOTALL)[0])
    shown = set(re.findall(r'<figure id="(\w+)"', html))
    assert {"fig16", "fig19", "fig21"} <= set(charts) < shown
    assert {"strata", "claims"} <= shown - set(charts)
    bars = {trace["name"]: trace for trace in charts["fig16"]["data"]}
    assert bars["TP: collisions with an alert before contact"]["text"][0] == "3/4"
    assert bars["the paper"]["type"] == "bar"


def test_failures_and_gaps_are_said_and_escaped(tmp_path):
    html = write_report(made_up_run(tmp_path, plan=["x"] * 20, figures=["fig16"])).read_text(encoding="utf-8")
    assert "of 20 cells, 2 failed and 6 missing" in html
    assert "ValueError: no &lt;mesh&gt;" in html
    assert "Made up &amp; counted" in html
    campus = re.search(r"<tr><td>campus</td>.*?</tr>", html, re.DOTALL)
    assert campus is not None
    assert campus.group().count("no data") == 2 * len(DETECTORS)


def test_worst_cases_are_ordered_and_counted(tmp_path):
    cells = [
        walk(index=0, alert_distance_m=0.4),
        walk(index=1, alert_distance_m=None),
        walk(index=2, alert_distance_m=-0.3),
        walk("campus", "car", index=3, alert_distance_m=None),
        walk(index=4),
        walk(index=5, collides=False),
        walk(index=6, collides=False),
        walk(index=7, collides=False, alert_distance_m=None),
    ]
    missed, false = worst_cases(made_up_run(tmp_path, cells), most=3)
    assert (missed.total, false.total) == (3, 2)
    assert [case.what for case in missed.cases] == ["no alert", "no alert", "alert 0.30 m after contact"]
    assert [case.label for case in false.cases] == ["supermarket/wall/6", "supermarket/wall/5"]
    assert "passes at 1.00 m" in false.cases[0].what


def test_the_command_repeats_the_same_walk(tmp_path):
    """The command line accepts it, and its plan holds exactly that cell, with the run's settings."""
    from benchmarks.commands.run import run as command

    label = "supermarket/wall/2"
    words = shlex.split(rerun_command(made_up_run(tmp_path), label))
    assert words[:2] == ["obstaclewatch", "run"]
    given = command.make_context("run", words[2:]).params
    assert (given["only"], given["tier"], given["seed"]) == (label, "smoke", 2018)
    suite = load_suite(given["suite"], given["settings"], given["seed"])
    assert suite.scoring.gate_m == 0.4
    assert [cell.label for cell in plan_cells(suite, given["tier"])].count(label) == 1


def test_a_suite_file_is_named_in_the_command(tmp_path):
    run = made_up_run(tmp_path, argv=["run", "my suite.yaml", "--split=dev", "-j", "2"])
    assert rerun_command(run, "a/b/1") == (
        "obstaclewatch run 'my suite.yaml' --tier smoke --only a/b/1 --seed 2018 --split dev"
    )


def test_code_that_was_allowed_is_allowed_again(tmp_path):
    """Cause: the option was dropped, and the command refused the walk's own detector."""
    run = made_up_run(tmp_path, argv=["run", "mine.yaml", "--allow-code"])
    assert rerun_command(run, "a/b/1").endswith("--only a/b/1 --seed 2018 --allow-code")


def test_what_the_manifest_lacks_is_unknown(tmp_path):
    manifest = made_up_run(tmp_path, **dict.fromkeys(MANIFEST)).manifest
    lines = dict(environment_lines(manifest))
    assert reproduction_command(manifest) == "unknown"
    assert lines["git revision"] == "unknown, changes unknown"
    assert lines["packages"] == "unknown"
    assert dict(environment_lines({})) == lines


def test_a_real_manifest_leaves_nothing_unknown():
    """The report asked for names of an older manifest (source, cpus, python), and its command was that of no program:
    the made-up manifest of the tests had a word that `obstaclewatch run` does not store.
    """
    suite = load_suite("paper")
    found = manifest(suite, "smoke", plan_cells(suite, "smoke")[:1], ["run", "paper", "--tier", "smoke"])
    known = {name: "1.0" for name in found["versions"]}  # what is not installed is rightly unknown
    lines = dict(environment_lines(found | {"git_revision": "0123abc", "git_dirty": False, "versions": known}))
    assert not [name for name, text in lines.items() if "unknown" in text]
    assert lines["source fingerprint"] == found["source_sha256"]
    assert reproduction_command(found) == "obstaclewatch run paper --tier smoke"


def test_cost_is_summed_over_what_is_known(tmp_path):
    """12 of 14 cells cost 0.3 s each for 0.9 s of sound, ten beeps; two detectors take 10 ms of it each."""
    lines = dict(cost_lines(made_up_run(tmp_path)))
    assert lines["cells with a known cost"] == "12 of 14"
    assert lines["sound simulated"] == "11 s, 120 beeps"
    assert lines["computing time"] == "4 s over all processes, 3.00 times real time"
    assert lines["processor time of detection, PaperDetector"] == "1.0 ms a beep, median over walks"
    assert cost_lines(made_up_run(tmp_path, [])) == [("cost", "unknown")]


@pytest.mark.parametrize("cells", [[], [standing(3.0)]], ids=["nothing", "standing only"])
def test_a_run_without_walks_has_a_report(tmp_path, cells):
    html = write_report(made_up_run(tmp_path, cells)).read_text(encoding="utf-8")
    assert "This run has no walks." in html
    assert re.search(r"No data in this run for: .*Fig\. 16", html)


def test_markdown_summary_has_a_whole_table(written):
    path, _ = written
    text = (path.parent / "report.md").read_text(encoding="utf-8")
    table = [line for line in text.splitlines() if line.startswith("|")]
    assert len(table) > 10
    assert {line.count("|") for line in table} == {len(DETECTORS) + 3}
    assert "3 of 4" in text


def test_the_same_run_gives_the_same_bytes(tmp_path, written):
    again = write_report(made_up_run(tmp_path))
    assert again.read_bytes() == written[0].read_bytes()


def test_a_browser_opens_it_without_a_network(tmp_path, written):
    """Headless Chromium with every host unreachable draws the page: dark text, blue bars, the paper's red."""
    pixels = screenshot(written[0], tmp_path, (1200, 3000))
    assert pixels.shape[:2] == (3000, 1200)
    dark = (pixels.max(axis=2) < 0.3).mean()
    assert 0.005 < dark < 0.3
    red, green, blue = (pixels[..., k] for k in range(3))
    bars = (abs(red - 0.17) < 0.04) & (abs(green - 0.37) < 0.04) & (abs(blue - 0.54) < 0.04)
    assert bars.sum() > 2000


@pytest.mark.parametrize("width", [360, 400])
def test_nothing_overflows_on_a_phone(tmp_path, written, width):
    """Tables and pictures made the page wider than the screen, and commands stood in columns of one letter."""
    wide, tallest_cell = on_a_phone(written[0], tmp_path, width)
    assert 300 < wide <= width
    assert 10 < tallest_cell < 150


def test_figures_are_drawn_once_for_files_and_report(tmp_path, monkeypatch):
    """A run computed, drew and encoded each figure twice: half of the time after its last cell."""
    drawn, draw = [], benchmarks.figures.picture
    monkeypatch.setattr(benchmarks.figures, "picture", lambda figure: drawn.append(figure.name) or draw(figure))
    run = made_up_run(tmp_path)
    figures = [shown for shown in figures_of(run) if shown.figure.name in ("fig16", "fig24")]
    write_figures(run.folder, figures)
    html = write_report(run, (), figures).read_text(encoding="utf-8")
    assert drawn == ["fig16", "fig24"]
    for name in drawn:
        assert base64.b64encode((run.folder / "figures" / f"{name}.svg").read_bytes()).decode() in html
