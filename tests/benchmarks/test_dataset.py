"""Which walks a data set has, and what happens to a folder that has some."""

from __future__ import annotations

import re
from collections import Counter
from importlib.metadata import PackageNotFoundError
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.dataset import split_walks, write_data_set
from benchmarks.plan.suite import Suite, load_suite
from benchmarks.runs.executors import serial

ONE_WALL = ["groups=[]", "standing={phones: [ideal], counts: {wall: 1}, range_m: [1.5], detectors: [PaperDetector]}"]


@pytest.fixture(scope="module")
def paper() -> Suite:
    return load_suite("paper", ["standing=null"])


def test_a_larger_set_holds_the_smaller_one(paper):
    few, many = ({(split, cell.model_dump_json()) for split, cell in split_walks(paper, n)} for n in (40, 90))
    assert len(few) == 40
    assert few < many
    assert len(many) == 90


def test_every_stratum_has_its_share_and_every_split_both_outcomes(paper):
    chosen = split_walks(paper, 300)
    shares = Counter((cell.scene, cell.category) for _, cell in chosen)
    planned = {(group.scene, name): n for group in paper.groups for name, n in group.counts.items()}
    for stratum, count in planned.items():
        assert shares[stratum] == pytest.approx(300 * count / sum(planned.values()), abs=1.5), stratum
    collisions = pd.DataFrame([(split, cell.collision) for split, cell in chosen], columns=["split", "hit"])
    assert collisions.groupby("split").hit.mean().between(0.3, 0.7).all()
    assert Counter(collisions.split)["test"] == 60
    assert 20 <= Counter(collisions.split)["validation"] <= 40


def test_a_set_may_be_larger_than_its_suite():
    walls = load_suite("paper", ["groups=[{scene: campus, phones: [galaxy-s5], counts: {wall: 2}}]", "standing=null"])
    chosen = split_walks(walls, 25)
    assert len({cell.seed for _, cell in chosen}) == 25


def test_points_of_one_walk_are_in_one_split():
    """Else a detector is validated on walks that it was trained on."""
    swept = load_suite("robustness", ["groups=[{scene: campus, phones: [galaxy-s5], counts: {wall: 9}}]"])
    splits: dict[int, set[str]] = {}
    for split, cell in split_walks(swept, 400):
        splits.setdefault(cell.seed, set()).add(split)
    assert set(map(len, splits.values())) == {1}
    assert {"train", "validation", "test"} == set.union(*splits.values())


def test_goes_on_where_it_stopped_and_refuses_another_suite(tmp_path: Path):
    suite = load_suite("ranging", ONE_WALL)
    write_data_set(tmp_path, suite, split_walks(suite, 1), serial, ["export"])
    (sound,) = tmp_path.glob("recordings/*.flac")
    written = sound.stat().st_mtime_ns
    write_data_set(tmp_path, suite, split_walks(suite, 2), serial, ["export"])
    assert sound.stat().st_mtime_ns == written
    table = pd.read_parquet(tmp_path / "walks.parquet")
    assert len(list(tmp_path.glob("recordings/*.flac"))) == len(table) == 2
    with pytest.raises(ValueError, match="same suite and source"):
        write_data_set(tmp_path, load_suite("ranging", ONE_WALL, seed=5), split_walks(suite, 1), serial, ["export"])
    sound.unlink()
    with pytest.raises(ValueError, match="must be there as it was written, but is missing"):
        write_data_set(tmp_path, suite, split_walks(suite, 2), serial, ["export"])


def test_a_recording_cut_short_is_found_and_made_again_alone(tmp_path: Path):
    """Cause: only whether a file is there was looked at, so a copy cut short stayed in the set."""
    suite = load_suite("ranging", ONE_WALL)
    walks = split_walks(suite, 2)
    write_data_set(tmp_path, suite, walks, serial, ["export"])
    sound, other = sorted(tmp_path.glob("recordings/*.flac"))
    whole, kept = sound.read_bytes(), other.stat().st_mtime_ns
    sound.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(ValueError, match=rf"'{sound}' must be there as it was written, but has changed; wit") as error:
        write_data_set(tmp_path, suite, walks, serial, ["export"])
    Path(re.findall("'(.*?)'", str(error.value))[1]).unlink()
    assert write_data_set(tmp_path, suite, walks, serial, ["export"]).complete
    assert (sound.read_bytes(), other.stat().st_mtime_ns) == (whole, kept)


def test_a_set_does_not_shrink(tmp_path: Path):
    """Cause: fewer walks left files that no row of the table names."""
    suite = load_suite("ranging", ONE_WALL)
    write_data_set(tmp_path, suite, split_walks(suite, 2), serial, ["export"])
    before = (tmp_path / "walks.parquet").read_bytes()
    with pytest.raises(ValueError, match=r"got 1 without 1 of them, such as '[0-9a-f]{16}'; ask for as many"):
        write_data_set(tmp_path, suite, split_walks(suite, 1), serial, ["export"])
    assert (tmp_path / "walks.parquet").read_bytes() == before


def test_a_folder_with_something_else_stays_as_it_is(tmp_path: Path):
    """Cause: README.md, LICENSE and load.py of one's own project were replaced by those of the data set."""
    suite = load_suite("ranging", ONE_WALL)
    (tmp_path / "README.md").write_text("mine")
    with pytest.raises(ValueError, match=r"must be new, empty or hold a data set, but it has no suite\.yaml and 'READ"):
        write_data_set(tmp_path, suite, split_walks(suite, 1), serial, ["export"])
    assert {path.name: path.read_text() for path in tmp_path.iterdir()} == {"README.md": "mine"}


def test_a_set_that_was_stopped_before_its_first_walk_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """The folder is known to be a data set's as soon as there is anything in it."""

    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    suite = load_suite("ranging", ONE_WALL)
    for name in ("manifest", "run_cells"):
        with monkeypatch.context() as patch:
            patch.setattr(f"benchmarks.dataset.{name}", interrupted)
            with pytest.raises(KeyboardInterrupt):
                write_data_set(tmp_path, suite, split_walks(suite, 1), serial, ["export"])
    assert write_data_set(tmp_path, suite, split_walks(suite, 1), serial, ["export"]).complete


def test_the_card_says_where_the_licence_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Cause: sources that are not installed have no licence, and the card named a file that was not there."""

    def absent(name: str) -> None:
        raise PackageNotFoundError(name)

    suite = load_suite("ranging", ONE_WALL)
    cards = {}
    for folder in (tmp_path / "with", tmp_path / "without"):
        write_data_set(folder, suite, split_walks(suite, 1), serial, ["export"])
        cards[folder.name] = (folder / "README.md").read_text(encoding="utf-8")
        assert ("see `LICENSE`" in cards[folder.name]) is (folder / "LICENSE").is_file() is (folder.name == "with")
        monkeypatch.setattr("benchmarks.dataset.distribution", absent)
    assert "text is missing here" in cards["without"]


def test_truth_and_paths_agree(tmp_path: Path):
    """The earliest echo of the wall that a standing phone faces travels to its nearest point and back."""
    suite = load_suite("ranging", ONE_WALL)
    write_data_set(tmp_path, suite, split_walks(suite, 1), serial, ["export"])
    (walk,) = pd.read_parquet(tmp_path / "walks.parquet").itertuples()
    truth = pd.read_parquet(tmp_path / "truth" / f"{walk.walk}.parquet")
    paths = pd.read_parquet(tmp_path / "paths" / f"{walk.walk}.parquet")
    echo = paths[(paths.obstacle == walk.targets[0]) & (paths.mic == 0)].groupby("beep").delay_s.min()
    assert len(truth) == walk.beeps == len(echo)
    assert (echo * walk.sound_speed_m_s / 2).to_numpy() == pytest.approx(truth.range_m.to_numpy(), abs=0.05)
    speaker_to_mic_m = sum((a - b) ** 2 for a, b in zip(walk.speaker_m, walk.mic0_m, strict=True)) ** 0.5
    first = truth.iloc[0]
    apart_m = sum((first[f"speaker_{axis}_m"] - first[f"mic0_{axis}_m"]) ** 2 for axis in "xyz") ** 0.5
    assert apart_m == pytest.approx(speaker_to_mic_m)
