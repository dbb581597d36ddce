"""What the approaches are like as a whole."""

from pathlib import Path

import matplotlib.image
import numpy as np
import pytest

from docs.studies.approach_statistics import ApproachStatistics, approach_statistics, plot_statistics, statistics_table
from scenes.streets.approaches import DATA_COLLECTION


@pytest.fixture(scope="module")
def found() -> ApproachStatistics:
    return approach_statistics(share=0.03, seed=4)


def test_every_stratum_of_the_paper_is_there(found: ApproachStatistics) -> None:
    for scene, collected in DATA_COLLECTION.items():
        for category, cases in collected.cases.items():
            count = int(((found.scene == scene) & (found.category == category)).sum())
            assert count == max(2, round(0.03 * cases))


def test_they_begin_before_the_paper_would_alert_and_are_what_they_claim(found: ApproachStatistics) -> None:
    """The paper alerts within 3 m: every walk into a target begins farther off. A wall alongside may begin nearer."""
    assert found.start_range_m[found.collision].min() > 3.0
    assert 0.4 < found.collision.mean() < 0.6
    np.testing.assert_array_equal(found.clearance_m[found.collision], 0.0)
    assert found.clearance_m[~found.collision].min() > 0.05
    assert 0.8 <= found.speed_m_s.min() <= found.speed_m_s.max() <= 1.6
    assert (found.radius_m > 0.05).all()
    assert found.obstacles.min() >= 3


def test_the_table_and_the_picture(found: ApproachStatistics, tmp_path: Path) -> None:
    rows = statistics_table(found)
    assert next(row["quantity"] for row in rows) == "distance at the start (m)"
    assert all(row["p5"] <= row["median"] <= row["p95"] for row in rows)
    picture = matplotlib.image.imread(plot_statistics(found, tmp_path / "s.png"))
    assert picture.std() > 0.1


def test_no_share_is_refused() -> None:
    with pytest.raises(ValueError, match="share must lie above 0 and at most at 1, got 0"):
        approach_statistics(0.0)
