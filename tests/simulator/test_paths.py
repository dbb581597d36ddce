"""Paths in a terminal and in a notebook."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from simulator import Air, Fidelity, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
from simulator.paths import REPR_ROWS
from simulator.world.rejection_log import Choice


@pytest.fixture(scope="module")
def paths():
    wall = Obstacle(trimesh.creation.box(bounds=[[2, -2, 0], [2.1, 2, 3]]), Material.rigid(), "<wall>")
    poses = Pose([[0.0, 0.0, 1.3], [0.5, 0.0, 1.3]], held_rotation(heading_rad=[0.0, 0.0]))
    return trace_paths(Scene([wall], Air.lossless(343.0)), Phone.named("ideal"), poses)


def test_paths_print_as_a_short_table_of_the_strongest(paths):
    """Twelve paths printed 10,000 characters of arrays."""
    lines = repr(paths).splitlines()
    assert len(paths) > REPR_ROWS
    assert lines[0] == f"Paths({len(paths)} at 2 poses)"
    assert len(lines) == REPR_ROWS + 3
    assert lines[-1] == f"  and {len(paths) - REPR_ROWS} weaker ones"
    levels = [float(line.split()[3]) for line in lines[2:-1]]
    assert levels == sorted(levels, reverse=True)


def test_no_paths_print_too(paths):
    assert repr(paths[:0]).splitlines()[0] == "Paths(0 at 2 poses)"


def test_obstacles_met_are_those_in_turn(paths):
    assert paths[:0].obstacles_met() == []
    assert [" > ".join(met) for met in paths.obstacles_met()] == paths.obstacle.tolist()
    assert {len(met) for met in paths[paths.order == 0].obstacles_met()} == {0}


def test_a_notebook_shows_a_table_with_names_escaped(paths):
    page = paths._repr_html_()
    assert page.count("<tr>") == len(paths) + 1
    assert "&lt;wall&gt;" in page
    assert "<wall>" not in page


def test_reasons_without_a_rejection_are_not_listed(paths):
    assert ": 0" not in paths.explain()


def test_rays_that_are_not_judged_have_no_error():
    """`explain` said "estimated error of rays inf dB" of people, whose rays say nothing of them."""
    man, bin_ = str(Choice("man", 8, 8, float("inf"), 0.0)), str(Choice("bin", 8, 2, 3.0, 0.25))
    assert man.endswith("rays alone say nothing of its echo, an error of 0.00 dB is left")
    assert bin_.endswith("rays alone would err by 3.00 dB, an error of 0.25 dB is left")


@pytest.mark.parametrize("one", [0, np.int64(1), True, 1.5, None, "wall", [0.5, 1.5], [[0, 1]]])
def test_paths_are_selected_by_rows(paths, one):
    """`paths[0]` was an object whose columns are numbers, and failed wherever it was used."""
    with pytest.raises(ValueError, match="paths must be selected by a mask, an index array or a slice, got "):
        paths[one]


def test_no_rows_are_no_paths(paths):
    """An empty list is an array of floats, with which numpy selects nothing."""
    assert len(paths[[]]) == len(paths[np.zeros(len(paths), dtype=bool)]) == 0
    np.testing.assert_array_equal(paths[[2, 0]].delay_s, paths.delay_s[[2, 0]])


def test_paths_that_do_not_belong_together_are_not_added(paths):
    """The sum had the phone and the poses of the first; tables of another width were numpy's error."""
    assert len(paths + paths[paths.order == 0]) == len(paths) + 4
    with pytest.raises(ValueError, match=r"must be of one phone object, got Phone\('ideal'.* and Phone\('galaxy-s5'"):
        paths + replace(paths, phone=Phone.named("galaxy-s5"))
    pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))
    other = trace_paths(Scene([]), paths.phone, pose, Fidelity(max_order=1))
    with pytest.raises(ValueError, match=r"as many poses, .*, got \(2, 10, 3\) and \(1, 10, 1\)"):
        paths + other


@pytest.mark.filterwarnings("error")
def test_paths_without_sound_are_explained(paths):
    """`explain` took the logarithm of 0."""
    assert "strongest -6000.0 dB" in replace(paths, band_gain=np.zeros_like(paths.band_gain)).explain()


def test_the_phone_s_own_case_is_named():
    """The docstring said that the direct sound meets nothing."""
    found = trace_paths(Scene([]), Phone.named("galaxy-s5"), Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0)))
    assert set(found.kind) == {"direct"}
    assert sorted(found.obstacles_met()) == [(), (), ("case",), ("case",)]


def test_a_stranger_reads_what_numbers_are(paths):
    """Cause: neither order nor levels were said what they are, and pairs of images needed the page on physics."""
    head, *_ = paths.explain().splitlines()
    assert head.endswith("order counts reflections, levels are re 1 m")
    assert head.startswith(f"{len(paths)} paths at ")
    assert "in place of rays for 2 of 8 pairs of speaker and microphone" in str(Choice("bin", 8, 2, 3.0, 0.25))
