"""All of the paper's pictures by one command: each from its suite, with the paper's values beside."""

import re

import pytest
from click.testing import CliRunner

import benchmarks.paper_figures
from benchmarks.cli import cli
from benchmarks.figures.paper.paper_claims import claim_rows
from benchmarks.paper_figures import PAPER_FIGURES, SUITE_OF, claims_of
from benchmarks.plan.suite import load_suite
from tests.benchmarks.synthetic_run import made_up_run


def test_every_picture_comes_from_a_suite_that_reproduces_it():
    assert [f"fig{number}" for number in range(1, 28)] + ["table1"] == PAPER_FIGURES
    for name, suite in SUITE_OF.items():
        told = re.sub(r"(\d+) to (\d+)", lambda found: ", ".join(map(str, range(int(found[1]), int(found[2]) + 1))),
                      load_suite(suite).reproduces)  # fmt: skip
        assert re.search(rf"\b{re.sub(r'[a-z]+', '', name)}\b", told), (name, told)


@pytest.mark.parametrize(
    ("name", "claim"),
    [
        ("fig22", "Distance1 at 3 m, P90"),
        ("fig17", "TP, campus"),
        ("table1", "charge of 30 minutes"),
        ("fig27", "charge of 30 minutes"),
    ],
)
def test_the_paper_s_values_stand_beside_their_figure(tmp_path, name, claim):
    rows = claim_rows([made_up_run(tmp_path, suite="energy")])
    assert any(row.claim.startswith(claim) for row in rows)
    found = [row.claim for row in claims_of(name, rows)]
    assert any(text.startswith(claim) for text in found) == (claim != "TP, campus")  # campus failed: not measured
    assert not any(text.startswith(("radius", "Distance1 at 5 m")) for text in found)


def test_one_command_writes_every_picture_and_a_page(tmp_path, monkeypatch):
    """The suites are replaced by one made-up run: what is drawn of them is tested elsewhere."""
    monkeypatch.setattr(
        benchmarks.paper_figures,
        "paper_runs",
        lambda tier, jobs, out: {suite: made_up_run(tmp_path / suite, tier=tier) for suite in set(SUITE_OF.values())},
    )
    done = CliRunner().invoke(cli, ["figures", "--paper", str(tmp_path / "page"), "--tier", "smoke"])
    assert done.exit_code == 0, done.output
    text = (tmp_path / "page" / "index.html").read_text(encoding="utf-8")
    assert re.findall(r'<figure id="(\w+)"', text) == PAPER_FIGURES
    for link in re.findall(r'(?:src|href)="(figures/[^"]+)"', text):
        assert (tmp_path / "page" / link).is_file()
    assert ">93 %" in text.replace("&gt;", ">")
    for words in (["figures"], ["figures", "x", "fig16", "--paper"]):
        assert isinstance(CliRunner().invoke(cli, words).exception, ValueError)
