"""What a cell changes: the walk, the phone, the samples, a second phone. Each against what it must amount to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.cells.channel import through_channel
from benchmarks.cells.interference import with_interferer
from benchmarks.cells.situations.approaching import approach_situation
from benchmarks.cells.situations.situation import Situation
from benchmarks.cells.situations.standing import standing_situation
from benchmarks.cells.situations.variation import changed_phone, changed_walk, varied
from benchmarks.cells.spec import Cell, Interferer, PhoneChange, RecordingChange, SceneChange, WalkChange
from obstaclewatch import BeepDesign, MatchedFilter, Recording
from scenes import Gait, GaitWalk, Pace, Route, RouteWalk, ground_truth
from scenes.obstacles import ground, wall
from scenes.streets.approaches import AFTER_CONTACT_S
from scenes.streets.placing import placed
from simulator import Fidelity, Material, Obstacle, Phone, Scene, StraightWalk, render_walk
from simulator.render import trace_walk, ungated

BEEP = BeepDesign()
PERIOD_S = BEEP.period_s
BEFORE_CONTACT = 8  # seed of a walk that ends sooner after contact than its surge takes


def sine(frequency_hz: float, seconds: float = 0.5) -> Recording:
    wave = np.sin(2 * np.pi * frequency_hz * np.arange(int(192_000 * seconds)) / 192_000)
    return Recording(np.stack([wave, 0.5 * wave]), 192_000.0)


def test_no_change_changes_nothing():
    recording = sine(20_000.0)
    assert through_channel(recording, RecordingChange()) is recording
    walk, phone = GaitWalk(np.zeros(3)), Phone.named("galaxy-s5")
    assert changed_walk(walk, WalkChange(), PERIOD_S) is walk
    assert changed_phone(phone, PhoneChange()).level_spl_db == phone.level_spl_db


def test_gains_lags_clipping_and_equal_channels():
    recording = sine(20_000.0)
    changed = through_channel(recording, RecordingChange(mic_gain_db=(-20.0, 0.0), mic_delay_samples=(0, 2)))
    np.testing.assert_allclose(changed.samples[0], 0.1 * recording.samples[0], rtol=1e-6)
    np.testing.assert_array_equal(changed.samples[1, 2:], recording.samples[1, :-2])
    assert np.abs(through_channel(recording, RecordingChange(clip_level=0.3)).samples).max() == np.float32(0.3)
    equal = through_channel(recording, RecordingChange(identical=True)).samples
    np.testing.assert_array_equal(equal[0], equal[1])


def test_a_lag_beyond_the_recording_is_refused():
    """Cause: the rest of a channel was cut with a negative length: channels of two lengths, numpy's error."""
    with pytest.raises(ValueError, match=r"mic_delay_samples must be within the recording's 96000 samples, got \(0, "):
        through_channel(sine(20_000.0), RecordingChange(mic_delay_samples=(0, 96_001)))


@pytest.mark.parametrize("ppm", [-200.0, 50.0, 200.0])
def test_another_clock_hears_another_frequency(ppm):
    """A recorder that is fast by p takes more samples a cycle: f / (1 + p), exactly."""
    heard = through_channel(sine(20_000.0), RecordingChange(clock_ppm=ppm)).samples[0]
    expected = np.sin(2 * np.pi * 20_000.0 / (1 + 1e-6 * ppm) * np.arange(len(heard)) / 192_000)
    inner = slice(200, -200)
    assert np.abs(heard[inner] - expected[inner]).max() < 5e-3


def test_gait_can_be_taken_away_and_speed_changed():
    walk = GaitWalk(np.array([0.0, 0.0, 1.3]), speed_m_s=1.2, duration_s=3.6)
    still = changed_walk(walk, WalkChange(gait_scale=0.0), PERIOD_S)
    time = np.linspace(0.0, 3.6, 50)
    np.testing.assert_allclose(still.pose(time).position_m[:, 1:], [[0.0, 1.3]] * 50, atol=1e-12)
    slow = changed_walk(walk, WalkChange(speed_m_s=0.8), PERIOD_S)
    assert 3.6 * 1.2 / 0.8 <= slow.duration_s <= 3.6 * 1.2 / 0.8 + 2 * PERIOD_S
    short_steps = Gait.at_speed(1.2, walk_ratio_m_min=0.0055)
    own = changed_walk(replace(walk, gait=short_steps), WalkChange(speed_m_s=0.8), PERIOD_S)
    assert own.motion.step_hz == pytest.approx(Gait.at_speed(0.8, walk_ratio_m_min=0.0055).step_hz)
    gliding = changed_walk(replace(walk, gait=Gait()), WalkChange(speed_m_s=0.8), PERIOD_S)
    assert gliding.motion == Gait()  # had amplitudes of 0.8 m/s, at a standstill
    with pytest.raises(ValueError, match="walk with gait"):
        changed_walk(StraightWalk(np.zeros(3), 0.0, 1.0, 1.0), WalkChange(pitch_rad=0.1), PERIOD_S)


def test_a_collision_without_gait_is_still_a_collision():
    """Walks end just after contact: without the surge, up to 1 cm, 4 of 31 ended before it and counted as misses."""
    cell = Cell(
        kind="approach", scene="campus", category="dustbin", index=1, phone="galaxy-s5", seed=BEFORE_CONTACT,
        collision=True, detectors=("PaperDetector",), walk=WalkChange(gait_scale=0.0),
    )  # fmt: skip
    plain, gliding = approach_situation(cell), varied(approach_situation(cell), cell)
    assert gliding.walk.motion.fore_aft_m == 0.0
    first, then = (ground_truth(s.scene, s.walk, s.phone, [0.0], target=s.targets[0]) for s in (plain, gliding))
    assert first.collides
    assert then.collides
    assert then.contact_time_s > plain.walk.duration_s  # the case that ended too early
    still = changed_walk(GaitWalk(np.zeros(3), speed_m_s=0.0, duration_s=1.0), WalkChange(gait_scale=0.0), PERIOD_S)
    assert still.duration_s == 1.0


@pytest.mark.parametrize("change", [{"gait_scale": 0.0}, {"gait_scale": 2.0}, {"speed_m_s": 1.6}])
def test_a_changed_walk_ends_just_after_contact_too(change):
    """It went on for up to two beeps, in which the phone was carried into the wall: 13 walks of the ci tiers."""
    cell = Cell(
        kind="approach", scene="supermarket", category="wall", index=1, phone="galaxy-s5", seed=3, collision=True,
        detectors=("PaperDetector",), walk=WalkChange(**change),
    )  # fmt: skip
    changed = varied(approach_situation(cell), cell)
    truth = ground_truth(changed.scene, changed.walk, changed.phone, [0.0], target=changed.targets[0])
    assert changed.walk.duration_s == pytest.approx(
        truth.contact_time_s + AFTER_CONTACT_S, abs=1.4e-3
    )  # instants of the truth


def test_horizontal_holding_puts_the_top_edge_to_the_left():
    walk = changed_walk(GaitWalk(np.zeros(3), heading_rad=0.4, pitch_rad=0.0), WalkChange(holding="horizontal"), 0.09)
    pose = walk.pose([0.0])
    edge = pose.to_world([0.0, 1.0, 0.0])[0] - pose.position_m[0]
    np.testing.assert_allclose(edge[:2], [-np.sin(0.4), np.cos(0.4)], atol=0.03)  # the hand's wobble is 1.5 degrees
    assert pose.body_heading_rad()[0] == 0.4


def test_a_route_takes_another_holding_and_nothing_else():
    route = RouteWalk(Route(np.array([[0.0, 0.0], [3.0, 0.0], [3.0, 3.0]])), Pace(1.0), 2.0)
    assert changed_walk(route, WalkChange(), PERIOD_S) is route
    assert changed_walk(route, WalkChange(holding="horizontal"), PERIOD_S).holding == "horizontal"
    with pytest.raises(ValueError, match="straight walk with gait, got RouteWalk"):
        changed_walk(route, WalkChange(holding="horizontal", gait_scale=0.0), PERIOD_S)


def test_a_walk_at_another_speed_still_knows_its_truth():
    cell = Cell(
        kind="approach", scene="supermarket", category="wall", index=2, phone="galaxy-s5", seed=3, collision=True,
        detectors=("PaperDetector",), walk=WalkChange(speed_m_s=0.9), air={"temperature_c": 35.0},
    )  # fmt: skip
    plain, changed = approach_situation(cell), varied(approach_situation(cell), cell)
    assert changed.scene.air.temperature_c == 35.0
    first, then = (ground_truth(s.scene, s.walk, s.phone, [0.0], target=s.targets[0]) for s in (plain, changed))
    assert first.range_m[0] == pytest.approx(then.range_m[0], abs=0.03)  # the surge of the other gait
    assert then.contact_time_s * 0.9 == pytest.approx(first.contact_time_s * plain.walk.speed_m_s, abs=0.05)


def test_materials_can_be_changed_and_surroundings_taken_away():
    cell = Cell(
        kind="approach", scene="campus", category="dustbin", index=1, phone="galaxy-s5", seed=3, collision=True,
        detectors=("PaperDetector",),
        scene_change=SceneChange(target_material="glass", ground_material="rubber", surroundings=False),
    )  # fmt: skip
    plain = approach_situation(cell)
    changed = varied(plain, cell).scene
    assert len(plain.scene.obstacles) > 2
    assert {o.name: o.material.name for o in changed.obstacles} == {"ground": "rubber", plain.targets[0]: "glass"}


@pytest.mark.parametrize("bearing_rad", [0.0, 0.35, -0.6])
def test_a_standing_target_stands_at_its_bearing(bearing_rad):
    cell = Cell(
        kind="standing", scene="standing", category="pedestrian", index=0, phone="galaxy-s5", seed=3, collision=False,
        range_m=3.0, bearing_rad=bearing_rad, detectors=("PaperDetector",),
    )  # fmt: skip
    setting = standing_situation(cell)
    truth = ground_truth(setting.scene, setting.walk, setting.phone, [0.0], target="target")
    assert truth.signed_bearing_rad[0] == pytest.approx(bearing_rad, abs=0.08)
    assert truth.range_m[0] == pytest.approx(3.0, abs=0.1)


def test_the_second_phone_is_as_loud_and_as_late_as_its_distance_says():
    phone = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.07, 0.0], [0.0, -0.07, 0.0]])
    walk = StraightWalk(np.zeros(3), 0.0, 0.0, 2 * PERIOD_S)
    setting = Situation(Scene(()), walk, phone, ())
    silent = Recording(np.zeros((2, 2 * BEEP.period_samples)), BEEP.sample_rate_hz)
    other = Interferer(distance_m=2.0, bearing_rad=0.0, level_spl_db=phone.full_scale_spl_db, delay_s=0.0)
    heard = with_interferer(silent, setting, BEEP, other)
    profile = MatchedFilter(BEEP, 0.03).compress(heard.samples[:, : BEEP.period_samples])
    peak = profile.magnitude.argmax(axis=1)
    distance = np.array([1.93, 2.07])
    speed = setting.scene.air.sound_speed_m_s
    np.testing.assert_allclose(profile.delay_s[peak] * speed, distance, atol=0.5 * speed / profile.rate_hz)
    np.testing.assert_allclose(profile.magnitude.max(axis=1), 1.0 / distance, rtol=0.01)


def test_a_second_phone_in_another_band_leaves_ours_alone():
    phone = Phone.named("ideal")
    ours = BeepDesign(18_000.0, 20_000.0)
    setting = Situation(Scene(()), StraightWalk(np.zeros(3), 0.0, 0.0, 2 * PERIOD_S), phone, ())
    silent = Recording(np.zeros((2, 2 * ours.period_samples)), ours.sample_rate_hz)
    peaks = []
    for band in ((18_000.0, 20_000.0), (21_000.0, 23_000.0)):
        other = Interferer(start_hz=band[0], stop_hz=band[1])
        heard = with_interferer(silent, setting, ours, other).samples[:, : ours.period_samples]
        peaks.append(MatchedFilter(ours, 0.03).compress(heard).magnitude.max())
    assert peaks[0] > 0.0
    assert 20 * np.log10(peaks[1] / peaks[0]) < -50.0


def wall_on_ground() -> Scene:
    ahead = placed(Obstacle(wall(3.0, 2.5), Material.named("brick"), "wall", category="wall"), (2.0, 0.0))
    return Scene([Obstacle(ground(), Material.named("asphalt"), "ground", category="ground"), ahead])


def test_the_ground_s_own_echo_is_gated_out_and_its_corner_with_the_wall_stays():
    """Straight down 2 x 1.3 m, by the image; nothing else of the street moves."""
    phone, scene, speed = Phone.ideal([0.0, 0.0, 0.0], [[0.0, 0.01, 0.0], [0.0, -0.01, 0.0]]), wall_on_ground(), 0.0
    walk = StraightWalk(np.array([0.0, 0.0, 1.3]), 0.0, speed, 2 * PERIOD_S)
    paths = trace_walk(scene, phone, walk, BEEP, Fidelity(max_order=2))[0]
    kept = ungated(paths, ["ground"])
    assert set(paths.obstacle[~kept]) == {"ground"}
    np.testing.assert_allclose(paths.delay_s[~kept] * scene.air.sound_speed_m_s, 2.6, atol=1e-3)
    assert {"", "wall", "wall > ground", "ground > wall"} <= set(paths.obstacle[kept])
    full = render_walk(scene, phone, walk, BEEP).samples
    without = render_walk(scene, phone, walk, BEEP, gated=("ground",)).samples
    alone = render_walk(Scene(scene.obstacles[:1]), phone, walk, BEEP).samples
    direct = render_walk(Scene(()), phone, walk, BEEP).samples
    # four sums in single precision, each of them rounded by 6e-8 as an envelope, between its samples, and as samples
    np.testing.assert_allclose(full - without, alone - direct, atol=7.2e-7 * np.abs(full).max())
    with pytest.raises(ValueError, match=r"names of the scene's obstacles, .* got \['sky'\]"):
        render_walk(scene, phone, walk, BEEP, gated=("sky",))


def test_a_cell_without_the_ground_s_echo_names_its_ground():
    cell = Cell(
        kind="approach", scene="campus", category="dustbin", index=1, phone="galaxy-s5", seed=3, collision=True,
        detectors=("PaperDetector",), scene_change=SceneChange(ground_echo=False),
    )  # fmt: skip
    plain = approach_situation(cell)
    assert plain.gated == ()
    changed = varied(plain, cell)
    assert changed.gated == ("ground",)
    assert changed.scene.obstacles == plain.scene.obstacles


def test_a_better_microphone_hears_more_and_its_noise_stays():
    """10 dB more of every sound at microphone 1, and the same noise under the direct sound."""
    phone, walk = Phone.named("galaxy-s5"), StraightWalk(np.array([0.0, 0.0, 1.3]), 0.0, 0.0, 2 * PERIOD_S)
    better = changed_phone(phone, PhoneChange(mic_level_db=(0.0, 10.0)))
    silent = [changed_phone(each, PhoneChange(noise_spl_db=-200.0)) for each in (phone, better)]
    plain, louder = (render_walk(wall_on_ground(), each, walk, BEEP).samples for each in silent)
    np.testing.assert_array_equal(plain[0], louder[0])
    np.testing.assert_allclose(louder[1], 10.0**0.5 * plain[1], atol=1e-6 * np.abs(plain[1]).max())
    quiet, noisy = (
        [render_walk(Scene(()), each, walk, BEEP).samples for each in pair] for pair in (silent, (phone, better))
    )
    noise = [loud - still for loud, still in zip(noisy, quiet, strict=True)]
    rounding = np.finfo(np.float32).eps * np.abs(louder).max()
    assert noise[0].std() > 100.0 * rounding
    np.testing.assert_allclose(noise[0], noise[1], rtol=0.0, atol=2.0 * rounding)


def test_silence_that_json_cannot_hold_is_refused():
    """-inf became null in a cell's JSON, and null the preset's own noise: a walk without noise had all of it."""
    with pytest.raises(ValueError, match="finite number"):
        PhoneChange(noise_spl_db=-np.inf)
