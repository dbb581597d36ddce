"""Phone presets: the paper's geometry, the measured response, and the front-to-rear difference of the microphones."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from obstaclewatch.beep import BeepDesign
from simulator.phone.phone import Phone
from simulator.phone.presets import N6P_BOTTOM_DB, N6P_TOP_DB, S5_BOTTOM_DB, S5_TOP_DB, TABLE_HZ, list_phones, preset
from simulator.phone.transducers import Transducer
from simulator.scene.air import Air

REAL_PHONES = ["galaxy-s5", "galaxy-note5", "galaxy-s8-plus"]
MEASURED = Path(__file__).parents[4] / "shared" / "realdata" / "freq" / "phone_response_model_250Hz.csv"


def db(value):
    return 20.0 * np.log10(value)


def two_way_db(phone, mic, frequency_hz):
    return db(phone.speaker.response(frequency_hz) * phone.mics[mic].response(frequency_hz))


def test_the_papers_phones_are_there():
    assert list_phones() == ["ideal", *REAL_PHONES, "nexus-6p"]


@pytest.mark.parametrize(("name", "separation_m"), [("s5", 0.141), ("note5", 0.153), ("s8+", 0.160), ("ideal", 0.150)])
def test_geometry(name, separation_m):
    geometry = preset(name).geometry
    assert geometry.mic_separation_m == pytest.approx(separation_m, abs=1e-12)
    assert geometry.mics_m[0, 1] > geometry.mics_m[1, 1]  # microphone 0 is the top one
    np.testing.assert_allclose(geometry.mics_m[:, [0, 2]], 0.0)
    assert 0.02 <= geometry.speaker_to_mic_m[0] <= 0.04


@pytest.mark.parametrize(
    ("alias", "name"),
    [("s5", "galaxy-s5"), ("note5", "galaxy-note5"), ("s8+", "galaxy-s8-plus"), ("s8-plus", "galaxy-s8-plus")],
)
def test_aliases(alias, name):
    assert Phone.named(alias.upper()).geometry.name == name


def test_unknown_phone_lists_the_known():
    with pytest.raises(ValueError, match="ideal, galaxy-s5, galaxy-note5, galaxy-s8-plus, nexus-6p, got 'iphone'"):
        Phone.named("iphone")


def test_ideal_phone_adds_nothing():
    phone = Phone.named("ideal")
    frequency = np.linspace(15e3, 25e3, 11)
    directions = np.vstack([np.eye(3), -np.eye(3)])
    assert phone.structure_borne is None
    assert phone.body is None
    assert phone.noise_spl_db == -np.inf
    for transducer in (phone.speaker, *phone.mics):
        np.testing.assert_array_equal(transducer.response(frequency), 1.0)
        np.testing.assert_array_equal(transducer.directivity(directions), 1.0)


@pytest.mark.parametrize("name", REAL_PHONES)
@pytest.mark.parametrize("pitch_deg", [0.0, 20.0, 35.0])
def test_the_microphone_that_faces_away_is_11_to_14_db_weaker_to_the_front(name, pitch_deg):
    """It had 8 to 10 dB, and received objects some 4 dB louder than microphones do in recordings."""
    pitch = np.radians(pitch_deg)
    front = np.array([0.0, np.cos(pitch), -np.sin(pitch)])  # the horizon ahead, seen from a phone pitched up
    top, bottom = (mic.directivity(front) for mic in Phone.named(name).mics)
    assert 11.0 <= db(top / bottom) <= 14.0 + 1e-9


def test_directivity_is_a_half_cosine_in_level():
    mic = Transducer(axis=np.array([0.0, 0.0, 1.0]), rear_loss_db=12.0)
    directions = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 0.0, -1.0]])
    np.testing.assert_allclose(db(mic.directivity(directions)), [0.0, -6.0, -12.0], atol=1e-12)


@pytest.mark.parametrize("name", REAL_PHONES)
def test_sound_in_the_case_comes_first_and_strongest(name):
    phone = Phone.named(name)
    distance = phone.geometry.speaker_to_mic_m
    assert phone.structure_borne is not None
    assert (phone.structure_borne.delay_s > 0.0).all()
    assert (phone.structure_borne.delay_s < distance / 400.0).all()  # faster than any air
    assert (phone.structure_borne.gain > 1.0 / distance).all()
    assert (phone.structure_borne.gain * phone.full_scale_gain < 0.5).all()  # far from clipping


@pytest.mark.parametrize("name", REAL_PHONES)
@pytest.mark.parametrize(("mic", "low_us", "high_us"), [(0, 12.0, 15.0), (1, 38.0, 188.0)])
def test_direct_sound_peaks_before_the_air_brings_it(name, mic, low_us, high_us):
    """The matched filter's envelope over a fine grid of delays, summed frequency by frequency."""
    phone, beep = Phone.named(name), BeepDesign()
    frequency = np.arange(15e3, 26e3, 20.0)
    sample = np.arange(9600) / beep.sample_rate_hz
    spectrum = np.exp(-2j * np.pi * frequency[:, None] * sample) @ beep.samples()
    air_delay_s = phone.geometry.speaker_to_mic_m[mic] / Air().sound_speed_m_s
    case = phone.structure_borne
    assert case is not None
    arrivals = case.gain[mic] * np.exp(-2j * np.pi * frequency * case.delay_s[mic])
    arrivals += np.exp(-2j * np.pi * frequency * air_delay_s) / phone.geometry.speaker_to_mic_m[mic]
    responses = phone.speaker.response(frequency) * phone.mics[mic].response(frequency)
    received = np.abs(spectrum) ** 2 * arrivals * responses
    delay_s = np.arange(-200e-6, 800e-6, 1e-6)
    envelope = np.abs(np.exp(2j * np.pi * delay_s[:, None] * frequency) @ received)
    peak_us = 1e6 * delay_s[np.argmax(envelope)]
    assert low_us <= peak_us <= high_us < 1e6 * air_delay_s


@pytest.mark.parametrize(
    ("name", "mic", "measured_db"),
    [("s5", 0, S5_TOP_DB), ("s5", 1, S5_BOTTOM_DB), ("6p", 0, N6P_TOP_DB), ("6p", 1, N6P_BOTTOM_DB)],
)
def test_the_measured_two_way_response_is_kept(name, mic, measured_db):
    # speaker plus microphone differ from the measurement by one constant: the level of the channel
    offset = two_way_db(Phone.named(name), mic, TABLE_HZ) - measured_db
    assert np.ptp(offset) < 1e-9


@pytest.mark.parametrize("mic", [0, 1])
def test_s5_mean_power_is_0_db_over_18_to_22_khz(mic):
    power = 10.0 ** (two_way_db(Phone.named("s5"), mic, np.arange(18e3, 22_001.0, 250.0)) / 10.0)
    assert power.mean() == pytest.approx(1.0, abs=1e-9)


def test_tables_are_the_published_ones():
    if not MEASURED.is_file():
        pytest.skip("the measured responses are not beside the repository")
    with MEASURED.open() as stream:
        rows = list(csv.DictReader(stream))
    assert len(rows) == len(TABLE_HZ)
    np.testing.assert_array_equal([float(row["f_Hz"]) for row in rows], TABLE_HZ)
    np.testing.assert_array_equal([float(row["s5_ch1_mic_dB_re_18k"]) for row in rows], S5_TOP_DB)
    np.testing.assert_array_equal([float(row["s5_ch2_mic_dB_re_18k"]) for row in rows], S5_BOTTOM_DB)
    np.testing.assert_array_equal([float(row["6p_ch2_mic_dB_re_18k"]) for row in rows], N6P_TOP_DB)
    np.testing.assert_array_equal([float(row["6p_ch1_mic_dB_re_18k"]) for row in rows], N6P_BOTTOM_DB)


def test_s8_plus_carries_the_top_of_the_band_best():
    """Paper, section 4.5: its response in the beep's band is slightly better than that of the other two."""
    top_of_band = np.linspace(21.5e3, 23e3, 7)
    phones = [Phone.named(name) for name in REAL_PHONES]
    s5, note5, s8_plus = (np.mean([two_way_db(phone, mic, top_of_band) for mic in (0, 1)]) for phone in phones)
    assert s8_plus > note5 > s5


@pytest.mark.parametrize("name", REAL_PHONES)
def test_real_levels_are_the_assumed_ones(name):
    phone = Phone.named(name)
    assert (phone.level_spl_db, phone.noise_spl_db) == (55.0, 30.0)


@pytest.mark.parametrize(
    ("part", "value", "rule"),
    [
        ("level_spl_db", "loud", "level_spl_db must be a number, got 'loud'"),
        ("noise_spl_db", None, "noise_spl_db must be a number, got None"),
        ("mics", (Transducer(),), "mics must be two transducers, got 1"),
        ("mics", (Transducer(), 1), "mic must be of type Transducer, got 1"),
        ("mics", Transducer(), "mics must be of type Iterable, got Transducer"),
        ("speaker", None, "speaker must be of type Transducer, got None"),
        ("geometry", None, "geometry must be of type PhoneGeometry, got None"),
        ("structure_borne", (0.0, 1.0), r"structure_borne must be of type StructureBorne, got \(0.0, 1.0\)"),
        ("body", "walker", "body must be of type Obstacle, got 'walker'"),
    ],
)
def test_a_phone_of_other_parts_is_refused(part, value, rule):
    """Levels that are no numbers were a TypeError, and a wrong part failed only when it was used."""
    with pytest.raises(ValueError, match=rule):
        replace(Phone.named("ideal"), **{part: value})
