"""What the paper's Figures 3 to 6, 8 to 10 and 12 show: responses, envelopes, crests. Small arrays, not scores.

All scenes are plain: asphalt ground, the named things ahead of the walker, and the walker's body behind the phone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from benchmarks.cells.equipment import detector_for, direct_delay_s
from benchmarks.cells.situations.situation import Situation, rendered
from benchmarks.cells.situations.variation import varied
from benchmarks.cells.spec import Cell
from obstaclewatch import BeepDesign, EchoProfile, MatchedFilter
from obstaclewatch.paper.size import printed_rim_excess
from obstaclewatch.recording import Recording
from obstaclewatch.signal.echoes import echoes_at, mean_threshold, os_cfar_threshold
from obstaclewatch.support.arrays import Floats, Singles
from scenes import GaitWalk, ground_truth, walker_body
from scenes.obstacles import ground, random_obstacle
from scenes.streets.placing import placed
from simulator import Material, Obstacle, Phone, Scene

Signal = dict[str, Any]

HEIGHT_M, PITCH_RAD = 1.3, float(np.deg2rad(30.0))
FAR_M, NEAR_M = 7.0, 0.3
SPEED_M_S = 343.0  # that the detector assumes
RESPONSE_HZ = np.arange(15_000.0, 25_001.0, 100.0)


def signal_result(cell: Cell) -> dict[str, Any]:
    """The arrays of the signal that the cell names, as `result["signal"]`.

    Raises:
        ValueError: an unknown signal or parameter.
    """
    if cell.category not in SIGNALS:
        raise ValueError(f"a signal probe must be one of {sorted(SIGNALS)}, got '{cell.category}'")
    begin = perf_counter()
    try:
        signal = SIGNALS[cell.category](cell, **cell.probe)
    except TypeError as error:
        raise ValueError(f"signal probe '{cell.category}': {error}") from error
    cost = {"simulate_s": 0.0, "detect_s": {}, "recording_s": 0.0, "total_s": perf_counter() - begin}
    return {"truth": {}, "detectors": {}, "signal": signal, "cost": cost}


def response(cell: Cell) -> Signal:
    """Figure 3: level from the speaker to each microphone over frequency, 0 dB mean power over 18-22 kHz."""
    phone = Phone.named(cell.phone)
    levels = []
    for mic in phone.mics:
        power = (phone.speaker.response(RESPONSE_HZ) * mic.response(RESPONSE_HZ)) ** 2
        inside = (RESPONSE_HZ >= 18_000.0) & (RESPONSE_HZ <= 22_000.0)
        levels.append(10.0 * np.log10(np.maximum(power / power[inside].mean(), 1e-12)))
    return {"frequency_hz": RESPONSE_HZ.tolist(), "mic1_db": _short(levels[0]), "mic2_db": _short(levels[1])}


def envelope(cell: Cell, things: Sequence[Sequence[Any]]) -> Signal:
    """Figures 4 and 6: microphone 0's envelope before (category, range, bearing) things, and the echoes it gives."""
    setting = _setting(cell, [(str(kind), float(r), float(b)) for kind, r, b in things], 0.0, 0.45)
    recording = rendered(setting, cell)
    profile, start_s = _profile(cell, recording, beep=2)
    magnitude, range_m = _searched(profile, start_s)
    # no beep before it says what moves, so that every peak is a candidate: the picture is of one standing beep
    detection = detector_for(cell, "PaperStandingDetector", setting, cell.beep.design()).process(
        _block(cell, recording, 2)
    )
    top = float(magnitude[0].max())
    truths = [_truth(setting, name) for name in setting.targets]
    half = round(4e-3 * profile.rate_hz)
    return {
        "range_m": _short(range_m),
        "level_db": _db(magnitude[0], top),
        "average_db": float(_db(np.array([mean_threshold(magnitude[0], 3.0)]), top)[0]),
        "threshold_db": _db(os_cfar_threshold(magnitude[0], 3.0, half), top),
        "candidate_m": _short(detection.range_m),
        "things": [str(kind) for kind, _, _ in things],
        "true_m": _short([truth.mic_range_m[0, 0] for truth in truths]),
    }


def approach(cell: Cell, category: str, start_m: float = 5.0, speed_m_s: float = 1.2) -> Signal:
    """Figures 5 and 12: envelopes while walking up to a thing, its true range, the candidates, and its crest widths.

    The crest is measured as section 3.6 says: samples at 192 kHz above the average envelope of the target range.
    """
    seconds = (start_m - 0.7) / speed_m_s
    setting = _setting(cell, [(category, start_m, 0.0)], speed_m_s, seconds)
    recording, beep = rendered(setting, cell), cell.beep.design()
    detector = detector_for(cell, "PaperDetector", setting, beep)
    rows: list[list[float]] = []
    found: list[list[float]] = []
    crest: list[float] = []
    time_s = beep.period_s * np.arange(beep.beeps_in(recording.duration_s))
    truth = ground_truth(setting.scene, setting.walk, setting.phone, time_s + 0.5 * beep.duration_s, target="thing-1")
    range_m = np.zeros(0)
    for k in range(len(time_s)):
        profile, start_s = _profile(cell, recording, beep=k)
        magnitude, range_m = _searched(profile, start_s)
        rows.append(_db(magnitude[0], float(profile.magnitude[0].max())))
        detection = detector.process(_block(cell, recording, k), float(time_s[k]))
        found.append(_short(detection.range_m))
        crest.append(_crest_samples(profile, start_s, float(truth.mic_range_m[k, 0]), beep))
    return {
        "category": category,
        "time_s": _short(time_s),
        "range_m": _short(range_m),
        "level_db": rows,
        "candidate_m": found,
        "true_m": _short(truth.mic_range_m[:, 0]),
        "true_radius_m": float(truth.radius_m[0]),
        "crest_samples": crest,
        "read_ahead_m": float(beep.range_doppler_s * speed_m_s),
    }


def body(cell: Cell, range_m: float = 1.5) -> Signal:
    """Figures 8 and 9: microphone 1's envelope with and without the walker's body behind the phone."""
    setting = _setting(cell, [("wall", range_m, 0.0)], 0.0, 0.45)
    curves = {}
    axis = np.zeros(0)
    for name, phone in (("with", setting.phone), ("without", setting.phone.held_by(None))):
        recording = rendered(replace(setting, phone=phone), cell)
        profile, start_s = _profile(cell, recording, beep=2)
        axis = SPEED_M_S * (profile.delay_s - start_s)
        kept = (axis >= -0.1) & (axis <= 2.0 * range_m + 1.6)
        curves[name] = profile.magnitude[1][kept]
        axis = axis[kept]
    top = float(curves["with"].max())
    truth = _truth(setting, setting.targets[0])
    geometry = setting.phone.geometry
    speaker_leg = float(truth.mic_range_m[0, 0] + geometry.speaker_to_mic_m[0])  # the obstacle is straight ahead
    behind = walker_distance_m()
    return {
        "path_m": _short(axis),
        "with_db": _db(curves["with"], top),
        "without_db": _db(curves["without"], top),
        "direct_m": float(geometry.speaker_to_mic_m[1]),
        **_case_m(setting.phone),
        "body_m": float(geometry.speaker_to_mic_m[1] + 2.0 * behind),
        "obstacle_m": speaker_leg + float(truth.mic_range_m[0, 1]),
        "detour_m": 2.0 * behind,
    }


def crests(cell: Cell, range_m: float = 2.0) -> Signal:
    """Figure 10: the crests of objects of different width at one distance, on a common scale."""
    beep = cell.beep.design()
    shown: Signal = {name: [] for name in ("things", "range_m", "level_db", "crest_samples", "true_radius_m", "true_m")}
    for category in ("sign", "pedestrian", "dustbin", "wall"):
        setting = _setting(cell, [(category, range_m, 0.0)], 0.0, 0.45)
        profile, start_s = _profile(cell, rendered(setting, cell), beep=2)
        axis, truth = 0.5 * SPEED_M_S * (profile.delay_s - start_s), _truth(setting, setting.targets[0])
        near = np.abs(axis - range_m) < 0.5
        shown["things"].append(category)
        shown["range_m"].append(_short(axis[near]))
        shown["level_db"].append(_db(profile.magnitude[0][near], float(profile.magnitude[0].max())))
        shown["crest_samples"].append(_crest_samples(profile, start_s, float(truth.mic_range_m[0, 0]), beep))
        shown["true_radius_m"].append(float(truth.radius_m[0]))
        shown["true_m"].append(float(truth.mic_range_m[0, 0]))
    return shown


SIGNALS: dict[str, Callable[..., Signal]] = {
    "response": response, "envelope": envelope, "approach": approach, "body": body, "crests": crests,
}  # fmt: skip
"""Name of a signal probe to what computes it."""


def walker_distance_m() -> float:
    """From the phone's bottom microphone straight back to the walker's chest, m."""
    chest = -np.asarray(walker_body(phone_height_m=HEIGHT_M).mesh.vertices)[:, 0].max()
    return float(chest - 0.075)


def _case_m(phone: Phone) -> dict[str, float]:
    """How far sound in the air would get while that in the case reaches microphone 1."""
    case = phone.structure_borne
    return {} if case is None else {"case_m": float(SPEED_M_S * case.delay_s[1])}


def _setting(cell: Cell, things: Sequence[tuple[str, float, float]], speed_m_s: float, seconds: float) -> Situation:
    """Things of (category, range, bearing) on asphalt, and a walker towards +x."""
    rng = np.random.default_rng(cell.seed)
    obstacles = [Obstacle(ground(), Material.named("asphalt"), "ground", surface="flat", category="ground")]
    names = []
    for number, (category, range_m, bearing_rad) in enumerate(things, start=1):
        drawn = placed(random_obstacle(category, rng, f"thing-{number}"), (0.0, 0.0), 0.0, (0.0, 0.0, 0.0))
        front = float(np.asarray(drawn.mesh.vertices)[:, 0].min())
        obstacles.append(placed(placed(drawn, (range_m - front, 0.0)), (0.0, 0.0), bearing_rad))
        names.append(f"thing-{number}")
    start = np.array([0.0, 0.0, HEIGHT_M])
    walk = GaitWalk(start, speed_m_s=speed_m_s, duration_s=seconds, pitch_rad=PITCH_RAD)
    phone = Phone.named(cell.phone).held_by(walker_body(phone_height_m=HEIGHT_M))
    return varied(Situation(Scene(obstacles, name="signal"), walk, phone, tuple(names)), cell)


def _block(cell: Cell, recording: Recording, beep: int) -> Singles:
    period = cell.beep.design().period_samples
    return recording.samples[:, beep * period : (beep + 1) * period]


def _profile(cell: Cell, recording: Recording, beep: int) -> tuple[EchoProfile, float]:
    """One beep compressed, and its emission: the direct sound less its calibrated delay."""
    design = cell.beep.design()
    profile = MatchedFilter(design, 2.0 * FAR_M / SPEED_M_S + 2e-3).compress(_block(cell, recording, beep))
    peak = float(profile.delay_s[np.argmax(profile.magnitude[0])])
    return profile, peak - direct_delay_s(cell.phone, cell.beep)


def _searched(profile: EchoProfile, start_s: float) -> tuple[Floats, Floats]:
    """(2, n) envelope over the search range, and (n,) its one-way range."""
    range_m = 0.5 * SPEED_M_S * (profile.delay_s - start_s)
    first = int(np.searchsorted(range_m, NEAR_M))
    count = round(2.0 * (FAR_M - NEAR_M) / SPEED_M_S * profile.rate_hz)
    return profile.magnitude[:, first : first + count], range_m[first : first + count]


def _crest_samples(profile: EchoProfile, start_s: float, range_m: float, beep: BeepDesign) -> float:
    """W_p of the highest peak within 25 cm of a range, at the beep's rate; NaN if it stays below the average."""
    magnitude, axis = _searched(profile, start_s)
    near = np.flatnonzero(np.abs(axis - range_m) < 0.25)
    if len(near) == 0:
        return float("nan")
    first = profile.position(start_s + 2.0 * NEAR_M / SPEED_M_S)
    peak = near[np.argmax(magnitude[0, near])] + int(np.searchsorted(profile.delay_s, start_s + 2 * NEAR_M / SPEED_M_S))
    average = mean_threshold(profile.magnitude[0, first:], 1.0)
    half_m = printed_rim_excess(profile, echoes_at(profile, 0, np.array([peak])), average, SPEED_M_S)[0]
    return float(2.0 * half_m / SPEED_M_S * beep.sample_rate_hz)


def _truth(setting: Situation, name: str) -> Any:
    return ground_truth(setting.scene, setting.walk, setting.phone, [0.1], target=name)


def _db(magnitude: Floats, top: float) -> list[float]:
    return _short(20.0 * np.log10(np.maximum(magnitude / top, 1e-6)))


def _short(values: Any) -> list[float]:
    """Numbers to four decimals: a tenth of a millimetre, a ten-thousandth of a decibel."""
    return [round(float(value), 4) for value in values]
