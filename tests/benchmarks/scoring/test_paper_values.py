"""The paper's numbers: consistent among themselves, and, where the paper is at hand, found in its text."""

from pathlib import Path

import pytest

from benchmarks.scoring import paper_values as paper

PAPER = Path(__file__).parents[4] / "shared" / "paper" / "obstaclewatch_paper.txt"


def test_overall_true_negatives_contradict_the_scenes():
    """The paper prints "over 92 %"; its scenes and cases give 91.7 %."""
    pair = paper.case_weighted_mean()
    assert pair.true_positive.value == pytest.approx(0.934, abs=5e-4)
    assert pair.true_negative.value == pytest.approx(0.917, abs=5e-4)
    assert pair.true_negative.value < paper.OVERALL.true_negative.value


def test_energy_shares_follow_from_the_charges():
    for row in paper.ENERGY:
        assert row.used_mah / row.battery_mah == pytest.approx(row.share, abs=5e-4)


def test_texts_carry_unit_and_relation():
    assert paper.BY_SCENE["supermarket"].true_positive.text == "94.6 %"
    assert paper.OVERALL.true_positive.text == ">93 %"
    assert paper.DISTANCE1_P90.text == "about 1 cm"
    assert paper.DISTANCE2_P90.short == "≤2"
    assert paper.BEARING_MEDIAN.text == "4°"


def test_what_the_paper_does_not_print_is_absent():
    assert 3.0 not in paper.DISTANCE1_MEDIAN


@pytest.mark.parametrize(
    "sentence",
    [
        "TP and the TN of supermarket is 94.6% and 93.2%",
        "TP of our system is slightly reduced to 91.3% and the TN is 89.1%",
        "the TP of 16-23kHz frequency band is 94.3%",
        "93.7% of 18-23kHz",
        "16-23kHz provides 91.4% while 18-23kHz is 92.5%",
        "as high as 32.1%",
        "at around 3.5%",
        "increased from 0.25cm to 0.3cm",
        "median error of 4 degrees with 80% errors within 8 degrees",
        "median error of 3cm with 80% errors within 7cm",
        "correlation is as high as 0.93",
    ],
)
def test_numbers_stand_in_the_paper(sentence):
    if not PAPER.is_file():
        pytest.skip("the paper's text is not part of the repository")
    assert sentence in PAPER.read_text(encoding="utf-8").replace("\n\n", " ")
