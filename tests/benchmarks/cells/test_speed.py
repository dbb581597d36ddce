"""What things cost: answers are checked before they are timed, and peers that are not there are named."""

from __future__ import annotations

import pytest

from benchmarks.cells.compute import compute
from benchmarks.cells.probes.speed.room import PATHS
from benchmarks.cells.spec import Cell


def speed(name: str, **parameters) -> dict:
    cell = Cell(
        kind="speed", scene="speed", category=name, index=0, phone="ideal", seed=7, collision=False,
        probe=parameters, detectors=(),
    )  # fmt: skip
    return compute(cell)["speed"]


def test_peers_are_timed_on_the_same_paths_and_named_where_missing(monkeypatch):
    found = speed("peers", order=1, places=2)
    assert found["missing"] == []
    ratio = found["numbers"]["pyroomacoustics_ms"] / found["numbers"]["walk_ms"]
    assert found["numbers"]["pyroomacoustics_ratio"] == ratio
    monkeypatch.setattr("benchmarks.cells.probes.speed.peers.find_spec", lambda name: None)
    alone = speed("peers", order=1, places=1)
    assert alone["missing"] == ["acoustic_spaces", "pyroomacoustics"]
    assert set(alone["numbers"]) == {"walk_ms", "one_by_one_ms", "one_by_one_ratio"}


def test_a_post_outdoors_is_timed_on_paths_that_a_peer_confirms(monkeypatch):
    found = speed("post", order=1, places=2)
    assert found["missing"] == []
    assert found["numbers"]["acoustic_spaces_ratio"] > 1.0
    monkeypatch.setattr("benchmarks.cells.probes.speed.post.SIDES", 6)
    with pytest.raises(RuntimeError, match="not timed, because"):
        speed("post", order=1, places=20)


def test_without_the_peer_a_post_is_timed_alone(monkeypatch):
    monkeypatch.setattr("benchmarks.cells.probes.speed.post.find_spec", lambda name: None)
    alone = speed("post", order=1, places=1)
    assert alone["missing"] == ["acoustic_spaces"]
    assert set(alone["numbers"]) == {"walk_ms"}


def test_growth_is_by_the_triangles_that_a_ball_has():
    assert set(speed("scaling", axis="triangles", values=[320])["numbers"]) == {"triangles_320_ms"}
    with pytest.raises(ValueError, match=r"triangles must be 20 times a power of 4, 320 or more, .* got 1000"):
        speed("scaling", axis="triangles", values=[1000])


def test_wrong_answers_are_not_timed(monkeypatch):
    monkeypatch.setitem(PATHS, 1, 8)
    with pytest.raises(RuntimeError, match="not timed, because a pair has not 8 paths"):
        speed("scaling", axis="order", values=[1])


@pytest.mark.parametrize(
    ("name", "parameters", "message"), [("nothing", {}, "must be one of .*peers"), ("scaling", {"axis": "x"}, "axis")]
)
def test_an_unknown_probe_or_axis_is_one_clear_error(name, parameters, message):
    with pytest.raises(ValueError, match=message):
        speed(name, **({"values": []} if parameters else {}), **parameters)
