"""No extreme is silently wrong, and a simulator or detector that is a little wrong is found by the name of an axis."""

from __future__ import annotations

import math
import resource
from collections.abc import Callable
from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from click.testing import CliRunner

import simulator.trace
from benchmarks.cells.probes.extremes import CHECKS, curved, snr, sound, verdict
from benchmarks.cells.probes.extremes.verdict import Error, judged
from benchmarks.cli import cli
from benchmarks.gates.physics import extremes, judge_physics, truth
from benchmarks.gates.verdict import State
from benchmarks.plan.cells import plan_cells
from benchmarks.plan.suite import load_suite
from obstaclewatch import PaperSettings, Recording
from simulator import Air
from simulator.paths import Paths


def test_the_extremes_are_those_promised() -> None:
    swept: dict[str, list[dict]] = {}
    for cell in plan_cells(load_suite("extremes"), "full"):
        swept.setdefault(cell.category, []).append(cell.probe)
    assert set(swept) == set(CHECKS)
    assert sum(map(len, swept.values())) >= 250
    promised = {
        ("wall-distance", "distance_m"): (1e-3, 1e3), ("wall-offset", "offset_m"): (0.1, 1e6),
        ("wall-size", "size_m"): (0.01, 1e3), ("triangles", "count"): (2, 1_000_000),
        ("weather", "temperature_c"): (-40.0, 60.0), ("sample-rate", "sample_rate_hz"): (44_100.0, 384_000.0),
        ("detector-snr", "snr_db"): (-20.0, 120.0), ("order", "max_order"): (0, 8),
        ("ball-incidence", "angle_rad"): (0.1, 1.57), ("walking", "speed_m_s"): (0.0, 100.0),
        ("beep-length", "duration_s"): (1e-3, 10.0),
    }  # fmt: skip
    for (axis, parameter), ends in promised.items():
        values = [probe[parameter] for probe in swept[axis]]
        assert (min(values), max(values)) == ends


@pytest.mark.parametrize("group", extremes.GROUPS)
def test_the_ends_of_every_axis_are_correct_or_refused(group: str) -> None:
    assert judge_physics({f"extremes_{group}": 1.0})[0].state is State.PASSED


@pytest.mark.parametrize("layout", ["on the diagonal", "a hair off", "at equal height"])
@pytest.mark.parametrize("distance_m", [3.0, 3.3])
def test_no_echo_of_a_large_corner_is_lost(distance_m: float, layout: str) -> None:
    """Cause: the next reflection in a corner lies in the plane of another face, which was taken to hide it; and a
    segment of micrometres between two reflections was asked about in float32, which cannot tell it from the faces.
    """
    errors = CHECKS["corner"](distance_m=distance_m, layout=layout)
    assert errors["echoes"].value == 0.0


@pytest.mark.slow
@pytest.mark.parametrize("axis", sorted(CHECKS))
def test_no_case_of_the_suite_is_silently_wrong(axis: str) -> None:
    cells = [cell for cell in plan_cells(load_suite("extremes"), "full") if cell.category == axis]
    found = {cell.label: judged(CHECKS[axis], cell.probe) for cell in cells}
    assert {label: case for label, case in found.items() if case["verdict"] == "wrong"} == {}
    refused = [case["refused"] for case in found.values() if case["verdict"] == "refused"]
    assert all(len(message) < 300 for message in refused)


@pytest.mark.slow
def test_an_hour_is_rendered_in_the_memory_of_half_a_minute() -> None:
    judged(CHECKS["last-beep"], {"duration_s": 30.0})
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    found = judged(CHECKS["last-beep"], {"duration_s": 3600.0})
    assert found["verdict"] == "correct"
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 100_000  # kB; the hour itself has 5.5 GB
    print(found["errors"], before, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss)


@pytest.mark.parametrize("angle_rad", [0.0, 0.4, 1.2, 1.5])
def test_the_reference_of_the_sphere_is_stationary_and_shortest(angle_rad: float) -> None:
    """The bisection against a dense search over the sphere; the level at normal incidence against a / (2 d (a + d))."""
    centre, mic = np.array([2.0, 0.1, 0.0]), 1.5 * np.array([1.0 - math.cos(angle_rad), math.sin(angle_rad), 0.01])
    length, _ = curved.stationary(0.5, centre, mic)
    turn = np.linspace(0.0, 2.0 * np.pi, 200_001)
    axis = np.cross(centre, centre - mic)
    first = -centre / np.linalg.norm(centre)
    second = np.cross(axis, first) / np.linalg.norm(np.cross(axis, first))
    points = centre + 0.5 * (np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second)
    path = np.linalg.norm(points, axis=1) + np.linalg.norm(mic - points, axis=1)
    assert float(length) == pytest.approx(path.min(), abs=1e-9)  # (step of 1.6e-5 m)^2 / 1 m
    if angle_rad == 0.0:
        straight = curved.stationary(0.5, np.array([2.0, 0.0, 0.0]), np.zeros(3))
        assert float(straight[1]) == pytest.approx(0.5 / (2.0 * 1.5 * (0.5 + 1.5)), rel=1e-12)


def test_what_is_not_a_number_is_wrong() -> None:
    found = judged(lambda: {"echoes": Error(0.0, 1.0), "level_db": Error(math.nan, 1.0)}, {})
    assert (found["verdict"], found["worst"]) == ("wrong", math.inf)


def test_a_run_with_a_wrong_case_ends_with_1_and_names_it(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(CHECKS, "slivers", lambda aspect: {"delay_samples": Error(aspect, 1.0)})
    call = ["run", "extremes", "-k", "slivers", "--limit", "1", "--walks", "0", "-o", str(tmp_path)]
    done = CliRunner().invoke(cli, call, catch_exceptions=False)
    assert done.exit_code == 1
    assert "silently wrong: numerics/slivers/0 {'aspect': 10.0}: {'delay_samples': 10.0}" in done.output


def test_a_good_input_that_is_refused_turns_run_and_gate_red(tmp_path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cause: any ValueError counted as a proper refusal, so a simulator that refuses everything was green."""

    def refuse(*_given, **_named) -> None:
        raise ValueError("aspect must be small, got 10.0")

    monkeypatch.setattr("benchmarks.cells.probes.extremes.triangulations.echoes", refuse)
    call = ["run", "extremes", "-k", "slivers", "--limit", "1", "--walks", "0", "-o", str(tmp_path)]
    done = CliRunner().invoke(cli, call, catch_exceptions=False)
    assert done.exit_code == 1
    assert "refused though it can be: numerics/slivers/0 {'aspect': 10.0}: aspect must be small" in done.output
    assert judge_physics({"extremes_triangulations": 1.0})[0].state is State.FAILED


@pytest.mark.parametrize(
    ("axis", "probe"),
    [
        ("impossible", {"case": "air of -100 degrees"}),
        ("band-edge", {"stop_over_nyquist": 1.1}),
        ("walking", {"speed_m_s": 60.0}),
        ("walk-length", {"duration_s": 0.0}),
        ("flaws", {"kind": "a vertex of NaN", "seam_m": 0.0}),
    ],
)
def test_only_an_error_that_names_the_value_counts_as_a_refusal(axis, probe, monkeypatch: pytest.MonkeyPatch) -> None:
    assert judged(CHECKS[axis], probe)["verdict"] == "refused"
    asked = verdict.must_refuse

    def unnamed(build: Callable[[], object], *named: str):
        def fail() -> None:
            try:
                build()
            except ValueError as error:
                raise ValueError("something is wrong") from error

        return asked(fail, *named)

    module = CHECKS[axis].__module__
    monkeypatch.setattr(f"{module}.must_refuse", unnamed)
    assert judged(CHECKS[axis], probe)["errors"] == {"unnamed": math.inf}
    monkeypatch.setattr(f"{module}.must_refuse", lambda build, *named: asked(lambda: None, *named))
    assert judged(CHECKS[axis], probe)["errors"] == {"accepted": math.inf}


def _of_paths(change: Callable[[Paths], Paths]) -> Callable[[pytest.MonkeyPatch], None]:
    def apply(patch: pytest.MonkeyPatch) -> None:
        made = simulator.trace._paths
        patch.setattr(simulator.trace, "_paths", lambda *arguments: change(made(*arguments)))

    return apply


def _faster(factor: float) -> Callable[[pytest.MonkeyPatch], None]:
    def apply(patch: pytest.MonkeyPatch) -> None:
        speed = Air.sound_speed_m_s.fget
        assert speed is not None
        patch.setattr(Air, "sound_speed_m_s", property(lambda air: factor * speed(air)))

    return apply


def _shifted_truth(patch: pytest.MonkeyPatch) -> None:
    asked = truth.ground_truth
    shift = lambda found: replace(found, range_m=found.range_m + 0.1)  # noqa: E731
    patch.setattr(truth, "ground_truth", lambda *given, **named: shift(asked(*given, **named)))


def _resampled(patch: pytest.MonkeyPatch) -> None:
    rendered = sound.render_walk

    def stretched(*given, **named) -> Recording:
        recording = rendered(*given, **named)
        place = np.arange(recording.samples.shape[1])
        rows = [np.interp(1.0001 * place, place, row) for row in recording.samples]
        return Recording(np.stack(rows), recording.sample_rate_hz)

    patch.setattr(sound, "render_walk", stretched)


def _threshold(change_db: float) -> Callable[[pytest.MonkeyPatch], None]:
    def apply(patch: pytest.MonkeyPatch) -> None:
        other = PaperSettings(cfar_factor=PaperSettings().cfar_factor * 10.0 ** (change_db / 20.0))
        patch.setattr(snr, "PaperStandingDetector", partial(snr.PaperStandingDetector, settings=other))

    return apply


SABOTAGE: dict[str, tuple[Callable[[pytest.MonkeyPatch], None], str]] = {
    "lengths 1e-3 too long": (_of_paths(lambda p: replace(p, delay_s=1.001 * p.delay_s)), "extremes_walls"),
    "delays in float32": (
        _of_paths(lambda p: replace(p, delay_s=p.delay_s.astype(np.float32).astype(np.float64))), "extremes_walls",
    ),
    "levels 0.1 dB too high": (
        _of_paths(lambda p: replace(p, band_gain=1.0116 * p.band_gain)), "extremes_triangulations",
    ),
    "microphones swapped": (_of_paths(lambda p: replace(p, mic=1 - p.mic)), "extremes_rooms"),
    "an echo lost": (_of_paths(lambda p: p[p.order < 2]), "extremes_rooms"),
    "speed of sound 1 % off": (_faster(1.01), "extremes_air"),
    "2e-3 samples at a kilometre, rendered": (_faster(1.0 + 2e-9), "extremes_sound"),
    "truth 10 cm off": (_shifted_truth, "truth"),
    "beep resampled by 1e-4": (_resampled, "extremes_sound"),
    "threshold 3 dB higher": (_threshold(3.0), "extremes_snr"),
    "threshold 3 dB lower": (_threshold(-3.0), "extremes_snr"),
}  # fmt: skip
"""What is done to the simulator or the detector, and the gate that must turn red by it."""
SLOW = ("beep-length", "last-beep")


@pytest.mark.parametrize("mistake", SABOTAGE)
def test_sabotage_turns_the_gate_red_by_name(mistake: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """Cause: with delays 1e-3 off or in float32, truth shifted or microphones swapped, no check could fail."""
    spoil, gate = SABOTAGE[mistake]
    spoil(monkeypatch)
    cases = extremes._few_cells  # a gate is red by any of them, so without those that take seconds, too
    monkeypatch.setattr(extremes, "_few_cells", lambda group: [c for c in cases(group) if c.category not in SLOW])
    found = judge_physics({gate: 1e-4 if gate == "truth" else 1.0})[0]
    assert found.state is State.FAILED
    assert found.name == gate
