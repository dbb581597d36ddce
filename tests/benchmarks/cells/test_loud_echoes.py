"""Where a standing phone hears its target: against points worked out without the tracer, and what is made of them."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.optimize import minimize

from benchmarks.cells.loud_echoes import loud_echo_ranges, mean_pose, one_way_m
from benchmarks.cells.situations.situation import Situation
from benchmarks.cells.situations.standing import standing_situation
from benchmarks.cells.spec import Cell
from benchmarks.figures import FIGURES
from benchmarks.report.verdict import verdict_rows
from benchmarks.report.verdict_lines import verdict_lines
from benchmarks.scoring.scores import beep_table, nearest_echo, summary
from scenes import ground_truth
from scenes.obstacles import ground
from scenes.truth.nearest import nearest_points
from simulator import Fidelity, Material, Obstacle, Phone, Scene, StraightWalk
from tests.benchmarks.synthetic_run import RANGE_ERROR_M, made_up_run, standing

PHONE = Phone.ideal([0.0, 0.04, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
STILL = StraightWalk(np.array([0.0, 0.0, 1.3]), heading_rad=0.0, speed_m_s=0.0, duration_s=0.9, pitch_rad=0.5)
RAYS = Fidelity(max_order=2)


def before(*obstacles: Obstacle) -> Situation:
    return Situation(Scene(list(obstacles)), STILL, PHONE, ("target",))


def block(extents_m: list[float], center_m: list[float], name: str = "target") -> Obstacle:
    mesh = trimesh.creation.box(extents_m)
    mesh.apply_translation(center_m)
    return Obstacle(mesh, Material.rigid(), name)


def floor() -> Obstacle:
    return Obstacle(ground(), Material.named("asphalt"), "ground", category="ground")


def speaker_and_mics() -> tuple[np.ndarray, np.ndarray]:
    pose = mean_pose(STILL)
    return pose.to_world(PHONE.geometry.speaker_m)[0], pose.to_world(PHONE.geometry.mics_m)[0]


def drawn(category: str, range_m: float, index: int) -> Situation:
    cell = Cell(
        kind="standing", scene="standing", category=category, index=index, phone="galaxy-s5", seed=7, collision=False,
        range_m=range_m, detectors=(),
    )  # fmt: skip
    return standing_situation(cell)


def true_of(setting: Situation):
    return ground_truth(setting.scene, setting.walk, setting.phone, [0.45], target="target")


def test_a_sphere_echoes_where_the_way_over_it_is_shortest():
    """Its one echo, off the exact sphere by minimisation: that is its nearest point, to the bulge of the meshed one."""
    center, radius = np.array([2.0, 0.3, 1.2]), 0.3
    ball = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    ball.apply_translation(center)
    setting = before(Obstacle(ball, Material.rigid(), "target", surface="smooth"))
    speaker, mics = speaker_and_mics()

    def point(angles: np.ndarray) -> np.ndarray:
        up, around = angles
        return center - radius * np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])

    found = loud_echo_ranges(setting, RAYS)
    for mic, echoes in zip(mics, found, strict=True):
        way = minimize(
            lambda a, mic=mic: np.linalg.norm(point(a) - speaker) + np.linalg.norm(point(a) - mic),
            [0.0, 0.0],
            tol=1e-12,
        )
        assert echoes == pytest.approx([np.linalg.norm(point(way.x) - mic)], abs=2e-4)
    np.testing.assert_allclose(np.ravel(found), true_of(setting).mic_range_m[0], atol=1e-3)


def test_a_wall_echoes_as_a_mirror():
    """Half the way to the speaker's image; the truth's point is nearest to the phone, a millimetre off for mic 1."""
    setting = before(block([0.2, 4.0, 4.0], [2.1, 0.0, 1.3]))
    speaker, mics = speaker_and_mics()
    for mic, echoes in zip(mics, loud_echo_ranges(setting, RAYS), strict=True):
        before_it = 2.0 - np.array([speaker[0], mic[0]])
        share = before_it[1] / before_it.sum()  # of the way back
        assert echoes[0] == pytest.approx(
            share * np.linalg.norm((speaker - mic) * [0.0, 1.0, 1.0] + [before_it.sum(), 0, 0])
        )
    np.testing.assert_allclose(
        [e[0] for e in loud_echo_ranges(setting, RAYS)], true_of(setting).mic_range_m[0], atol=2e-3
    )


@pytest.mark.parametrize("index", [0, 1, 4], ids=["leaning", "round", "another leaning"])
def test_a_bin_echoes_by_way_of_the_ground(index):
    """Its loudest echoes come from the corner that it makes with the ground; the truth finds that on the mesh."""
    setting = drawn("dustbin", 5.0, index)
    truth = true_of(setting)
    echoes = loud_echo_ranges(setting, RAYS)
    for mic in range(2):
        assert len(echoes[mic]) in (1, 2)  # ground first, target first
        np.testing.assert_allclose(echoes[mic], truth.mic_ground_range_m[0, mic], atol=1e-3)


@pytest.mark.parametrize(("range_m", "index"), [(1.5, 1), (3.0, 0), (5.0, 2)])
def test_nothing_of_a_person_echoes_from_nearer_than_its_nearest_point(range_m, index):
    setting = drawn("pedestrian", range_m, index)
    mics = mean_pose(setting.walk).to_world(setting.phone.geometry.mics_m)[0]
    _, nearest = nearest_points(setting.scene.obstacle("target").mesh, mics)
    found = loud_echo_ranges(setting, RAYS)
    assert all(found)
    for echoes, least in zip(found, nearest, strict=True):
        assert echoes == sorted(echoes)
        assert echoes[0] > least - 2e-3  # a smooth surface bulges over its facets


def test_ways_are_closed_at_the_microphone():
    mic = np.array([0.0, 0.0, 1.0])
    low, high = np.array([3.0, 0.0, 0.0]), np.array([3.0, 0.0, 2.0])
    floor_point = np.array([1.0, 0.0, 0.0])
    slant = np.sqrt(10.0)
    assert one_way_m(high[None], ["target"], "target", mic) == pytest.approx(slant)
    mean = 0.5 * (slant + np.sqrt(9.0 + 9.0))
    assert one_way_m(np.array([floor_point, high]), ["ground", "target"], "target", mic) == pytest.approx(mean)
    assert one_way_m(np.array([high, floor_point]), ["target", "ground"], "target", mic) == pytest.approx(mean)
    assert one_way_m(np.array([low, high]), ["target", "target"], "target", mic) == pytest.approx(slant + 1.0)
    both = np.array([floor_point, high, floor_point])
    assert one_way_m(both, ["ground", "target", "ground"], "target", mic) == pytest.approx(np.sqrt(18.0))


def test_what_comes_by_way_of_other_things_is_none_of_the_target_s():
    """A wall aside adds ways over both, as loud as the target's own; only its own and those by the ground count."""
    target, aside = block([0.2, 2.0, 2.0], [2.1, 0.0, 1.0]), block([6.0, 0.2, 3.0], [2.0, 1.2, 1.5], "aside")
    alone = loud_echo_ranges(before(floor(), target), RAYS)
    assert all(alone)
    assert loud_echo_ranges(before(floor(), target, aside), RAYS) == alone


def test_a_target_without_an_echo_has_none():
    far = block([0.2, 4.0, 4.0], [20.1, 0.0, 1.3])
    assert loud_echo_ranges(before(far), RAYS) == [[], []]


def test_cells_of_kirchhoff_s_integral_are_no_echoes():
    """They cancel but for a remainder, and each of them alone is as loud as any other."""
    setting = drawn("dustbin", 3.0, 0)
    integral = Fidelity(level="reference", max_order=2, edge_order=1)
    np.testing.assert_allclose(
        [echoes[0] for echoes in loud_echo_ranges(setting, integral)],
        [echoes[0] for echoes in loud_echo_ranges(setting, RAYS)],
        atol=1e-6,
    )


def test_the_nearest_echo_is_asked_for_every_estimate():
    found = nearest_echo([1.0, np.nan, 2.6], [1.1, 2.0, 2.9])
    np.testing.assert_array_equal(found, [1.1, np.nan, 2.9])
    assert np.isnan(nearest_echo([1.0, 2.0], [])).all()


def with_echoes(range_m: float, echoes_m: list[list[float]], index: int = 0):
    cell = standing(range_m, index)
    return cell | {"result": cell["result"] | {"loud_echoes_m": echoes_m}}


def test_errors_against_echoes_stand_beside_those_against_the_truth(tmp_path):
    """Every estimate of range is 4 mm short; the nearest loud echo lies another millimetre short of the truth."""
    cells = [with_echoes(3.0, [[2.999, 3.3], []], k) for k in range(2)]
    run = made_up_run(tmp_path, cells)
    table = beep_table(run, "PaperDetector", "standing")
    np.testing.assert_allclose(table["echo_range_m"], [np.nan, 2.999, 2.999, 2.999] * 2)
    assert np.isnan(table["echo_range2_m"]).all()
    told = summary(run, {})["detectors"]["PaperDetector"]
    assert told["standing"]["range_m"]["median"] == pytest.approx(RANGE_ERROR_M)
    assert told["standing_against_echoes"]["range_m"]["median"] == pytest.approx(RANGE_ERROR_M - 0.001)
    assert told["standing_against_echoes"]["range2_m"]["n"] == 0
    lines = [line.strip() for line in verdict_lines(summary(run, {})) if "diagnostic" in line]
    assert [line.split("diagnostic")[0] for line in lines] == ["range against echoes, "] * 2  # of two detectors
    curves = {curve.label: curve for curve in FIGURES["fig22"](run).curves}
    np.testing.assert_allclose(curves["PaperDetector, Distance1"].value, 0.4, atol=1e-9)
    np.testing.assert_allclose(curves["PaperDetector, Distance1 against the nearest loud echo"].value, 0.3, atol=1e-9)
    assert "PaperDetector, Distance2 against the nearest loud echo" not in curves
    rows = {row.label: row.cells[0].text for row in verdict_rows(run) if "diagnostic" in row.label}
    assert rows["Distance1 against the nearest loud echo, median (diagnostic)"] == "0.30 cm"
    assert rows["Distance2 against the nearest loud echo, P90 (diagnostic)"] == "no estimate"


def test_runs_from_before_echoes_were_told_are_read_as_they_were(tmp_path):
    run = made_up_run(tmp_path, [standing(3.0, k) for k in range(2)])
    assert np.isnan(beep_table(run, "PaperDetector", "standing")["echo_range_m"]).all()
    assert not any(curve.diagnostic for curve in FIGURES["fig22"](run).curves)
    assert "diagnostic" not in FIGURES["fig22"](run).note
    assert not any("diagnostic" in line for line in verdict_lines(summary(run, {})))
    assert not any("diagnostic" in row.label for row in verdict_rows(run))
