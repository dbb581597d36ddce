"""What one cell measures: a value that can be hashed, stored and run again alone."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, Field, ValidationError

from obstaclewatch.beep import HIGHEST_RATE_HZ, LEAST_TAPER, LONGEST_S, LOWEST_HZ, BeepDesign
from scenes.files.field_types import NotNegative, Number, Positive, Real, Whole

WalkingSpeed = Annotated[Real, Field(gt=0.0, le=15.0, allow_inf_nan=False)]  # m/s; a sprinter's 12.4, not cm/s
Angle = Annotated[Real, Field(ge=-np.pi, le=np.pi)]  # rad; degrees are refused
LevelError = Annotated[Real, Field(ge=-np.pi / 4, le=np.pi / 4)]  # rad; drawn phones stay below 90 degrees with it
Level = Annotated[Number, Field(ge=-500.0, le=500.0)]  # dB; far beyond, powers overflow


class BeepSetting(BaseModel, extra="forbid", frozen=True):
    """Arguments of `obstaclewatch.BeepDesign`."""

    start_hz: Annotated[Real, Field(ge=LOWEST_HZ, allow_inf_nan=False)] = 18_000.0
    stop_hz: Annotated[Real, Field(ge=LOWEST_HZ, allow_inf_nan=False)] = 23_000.0
    duration_s: Annotated[Real, Field(gt=0.0, le=LONGEST_S)] = 0.050
    gap_s: Annotated[Real, Field(ge=0.0, le=LONGEST_S)] = 0.040
    sample_rate_hz: Annotated[Real, Field(gt=0.0, le=HIGHEST_RATE_HZ)] = 192_000.0
    taper: Annotated[Real, Field(ge=LEAST_TAPER, le=1.0)] = 1.0

    @property
    def period_s(self) -> float:
        """From the start of one beep to the start of the next, s."""
        return self.duration_s + self.gap_s

    def design(self) -> BeepDesign:
        """The beep itself.

        Raises:
            ValueError: as `BeepDesign`, of values that do not fit each other.
        """
        return BeepDesign(**self.model_dump())


class Knowledge(BaseModel, extra="forbid", frozen=True):
    """What the detector is given of its phone and walker, beside the phone's geometry.

    Attributes:
        pitch: the mean pitch of the phone's top edge, as its accelerometer gives it.
        direct_delay: the delay of the direct sound, measured once in free space: sound through the case is earlier
            than sound through the air.
        air: temperature and humidity of the air, as a weather service gives them, and so the speed of sound; False
            leaves what the detector assumes by itself.
        walk_ratio: the walker's walk ratio, measured on another day; detectors that take none stay as they are.
        pitch_error_rad: what the accelerometer adds to the pitch, up to 45 degrees.
        temperature_error_c: what the weather service adds to the temperature.
    """

    pitch: bool = True
    direct_delay: bool = True
    air: bool = True
    walk_ratio: bool = False
    pitch_error_rad: LevelError = 0.0
    temperature_error_c: Number = 0.0


class Scoring(BaseModel, extra="forbid", frozen=True):
    """The rules by which alerts and estimates are judged.

    Attributes:
        half_width_m: half the width of the walker's swept body.
        gate_m: a candidate belongs to the target if its range is within this of the true one; wide enough to keep
            the range-Doppler reading of a walking phone (-20 to -33 cm at 1.0-1.6 m/s).
        max_range_m: beeps with the target farther than this are left out of the error statistics.
    """

    half_width_m: NotNegative = 0.25
    gate_m: Positive = 0.5
    max_range_m: Positive = 7.0


class SceneChange(BaseModel, extra="forbid", frozen=True):
    """What is different about a scene that was drawn.

    Attributes:
        target_material, ground_material: names of `simulator.Material.named`; None leaves what was drawn.
        person_level_db: added to what people reflect, at most all of it.
        surroundings: whether things, walls and people besides the target and the ground stay.
        ground_echo: whether the ground's own echo is rendered; an oracle leaves it out, and what the ground
            adds to the echoes of other things stays.
    """

    target_material: str | None = None
    ground_material: str | None = None
    person_level_db: Level = 0.0
    surroundings: bool = True
    ground_echo: bool = True


class WalkChange(BaseModel, extra="forbid", frozen=True):
    """What is different about a walk that was drawn.

    Attributes:
        speed_m_s: mean speed instead of the drawn one; the path stays, so the walk lasts as much longer or shorter.
        pitch_rad, roll_rad: how the phone is held, instead of the drawn pitch and of no roll.
        gait_scale: factor on all amplitudes of the gait; 0 glides.
        holding: "vertical" with the top edge forwards, or "horizontal" with the top edge to the left,
            instead of how the walk holds it.
    """

    speed_m_s: WalkingSpeed | None = None
    pitch_rad: Angle | None = None
    roll_rad: Angle | None = None
    gait_scale: Annotated[Real, Field(ge=0.0, allow_inf_nan=False)] = 1.0
    holding: Literal["vertical", "horizontal"] | None = None


class PhoneChange(BaseModel, extra="forbid", frozen=True):
    """What is different about a phone; see the fields of the same names of `simulator.Phone`.

    Attributes:
        mic_level_db: added to what each microphone receives, not to its noise: a better or a worse microphone.
        body: whether the walker's body stands behind the phone.
    """

    level_spl_db: Level | None = None
    noise_spl_db: Annotated[Level, Field(lt=200.0)] | None = None
    full_scale_spl_db: Level | None = None
    mic_level_db: tuple[Level, Level] = (0.0, 0.0)
    body: bool = True


class RecordingChange(BaseModel, extra="forbid", frozen=True):
    """What happens to the samples between the microphones and the detector, in this order.

    Attributes:
        mic_gain_db: of each microphone; -200 mutes it.
        mic_delay_samples: whole samples by which each channel lags.
        clock_ppm: how much faster than the loudspeaker's clock the recorder's runs.
        clip_level: greatest amplitude, relative to digital full scale; None does not clip.
        identical: whether both channels hold microphone 0.
    """

    mic_gain_db: tuple[Level, Level] = (0.0, 0.0)
    mic_delay_samples: tuple[Annotated[Whole, Field(ge=0)], Annotated[Whole, Field(ge=0)]] = (0, 0)
    clock_ppm: Annotated[Real, Field(gt=-1e4, lt=1e4)] = 0.0
    clip_level: Positive | None = None
    identical: bool = False


class Interferer(BaseModel, extra="forbid", frozen=True):
    """A second phone nearby that sends beeps of its own; only its direct sound is rendered.

    Attributes:
        distance_m, bearing_rad: where it stands, seen from the start of the walk; positive bearings are to the left.
        level_spl_db: of its beep at 1 m, dB re 20 uPa.
        start_hz, stop_hz, duration_s, gap_s: its beep; None takes ours.
        delay_s: when its first beep leaves, after ours.
    """

    distance_m: Positive = 3.0
    bearing_rad: Angle = 0.5
    level_spl_db: Level = 55.0
    start_hz: Positive | None = None
    stop_hz: Positive | None = None
    duration_s: Positive | None = None
    gap_s: NotNegative | None = None
    delay_s: NotNegative = 0.0123


class Conditions(BaseModel, extra="forbid", frozen=True):
    """What a suite asks of all its cells, and what each cell keeps of it.

    Attributes:
        air: arguments of `simulator.Air`.
        fidelity: arguments of `simulator.Fidelity`.
        settings: constants of the detector, arguments of `obstaclewatch.PaperSettings`.
    """

    scene_change: SceneChange = SceneChange()
    walk: WalkChange = WalkChange()
    phone_change: PhoneChange = PhoneChange()
    air: dict[str, Any] = {}
    beep: BeepSetting = BeepSetting()
    fidelity: dict[str, Any] = {}
    recording: RecordingChange = RecordingChange()
    interferer: Interferer | None = None
    knowledge: Knowledge = Knowledge()
    settings: dict[str, Any] = {}
    scoring: Scoring = Scoring()


class Cell(Conditions, frozen=True):
    """One walk, one standing measurement or one probe, with everything that decides its numbers.

    Attributes:
        kind: "approach" walks towards (or past) an obstacle; "standing" measures at a fixed distance; "signal" stores
            what the paper's Figures 3 to 12 show; "numerics" compares the simulator with formulas at an extreme;
            "fidelity", "tessellation" and "motion" measure what levels, meshes and motion cost and buy;
            "speed" measures processor time; "scene" walks through a scene file, which `approach` names with its digest
            and the preset to use, if any.
        index: number of the walk within its scene and category.
        phone: name of a preset, or of the phone in a scene file.
        seed: of the walk's own random stream.
        range_m, bearing_rad: place of the target of a standing measurement; range_m is None for all else.
        probe: parameters of a cell that is neither a walk nor a standing measurement.
        variant: the point of the suite's sweep that this cell is; for labels and figures.
        detector_sources: SHA-256 of the file of each detector that is not obstaclewatch's own.
    """

    kind: Literal["approach", "standing", "signal", "numerics", "fidelity", "tessellation", "motion", "speed", "scene"]
    scene: str
    category: str
    index: Annotated[Whole, Field(ge=0)]
    phone: str
    seed: Annotated[Whole, Field(ge=0)]
    collision: bool
    range_m: Positive | None = None
    bearing_rad: Angle = 0.0
    approach: dict[str, Any] = {}
    detectors: tuple[str, ...]
    probe: dict[str, Any] = {}
    variant: dict[str, Any] = {}
    detector_sources: dict[str, str] = {}

    @property
    def label(self) -> str:
        """Short name for people: "supermarket/dustbin/17", and what of a sweep it is: "[beep.start_hz=16000]"."""
        distance = "" if self.range_m is None else f"/{self.range_m:g}m"
        aside = "" if self.bearing_rad == 0.0 else f"/{np.rad2deg(self.bearing_rad):.3g}deg"
        return f"{self.scene}/{self.category}{distance}{aside}/{self.index}{variant_text(self.variant)}"

    def digest(self, fingerprint: str) -> str:
        """SHA-256 of the cell and of the source that computes it, hexadecimal."""
        return hashlib.sha256(f"{fingerprint}\n{self.model_dump_json()}".encode()).hexdigest()


def did_you_mean(name: str, known: Iterable[str]) -> str:
    """ ", did you mean 'ranging'?" for the known name that is nearest; empty where none is near."""
    near = get_close_matches(name, known, n=1)
    return f", did you mean '{near[0]}'?" if near else ""


def first_error(
    error: ValidationError, model: type[BaseModel], members: Mapping[str, type[BaseModel]] | None = None
) -> str:
    """The first thing that pydantic found wrong with data for a model, in one line: where, the rule, and the value.

    Args:
        members: of unions within the model, by the names that pydantic puts into a place; people did not write these.
    """
    from scenes.files.yaml_file import dotted, said  # slow to import, and needed by errors alone

    first = error.errors()[0]
    place, known = first["loc"], members or {}
    for k, step in enumerate(place):
        if step in known:
            return dotted(place[:k] + place[k + 1 :]) + said(first | {"loc": place[k + 1 :]}, known[str(step)])
    return dotted(place) + said(first, model)


def check_known(what: str, names: Iterable[str], known: Iterable[str]) -> None:
    """Refuse a name that is not known.

    Raises:
        ValueError: the message gives the names there are, and the nearest.

    >>> check_known("air", ["temperatur_c"], ["pressure_pa", "temperature_c"])
    Traceback (most recent call last):
    ValueError: air must be among ['pressure_pa', 'temperature_c'], got 'temperatur_c', did you mean 'temperature_c'?
    """
    known = sorted(known)
    for name in names:
        if name not in known:
            raise ValueError(f"{what} must be among {known}, got {name!r}{did_you_mean(str(name), known)}")


def counts_as(cell: Mapping[str, Any], kind: str) -> bool:
    """Whether a stored cell is scored as one of that kind: walks through scene files are approaches."""
    return cell["kind"] == kind or (cell["kind"], kind) == ("scene", "approach")


def variant_text(variant: dict[str, Any]) -> str:
    """A point of a sweep in brackets, empty for none: its name, or "[air.temperature_c=40]"."""
    if "name" in variant:
        return f"[{variant['name']}]"
    parts = [f"{name}={value:g}" if isinstance(value, float) else f"{name}={value}" for name, value in variant.items()]
    return f"[{', '.join(parts)}]" if parts else ""


def label_of_walk(label: str, variant: Mapping[str, Any]) -> str:
    """A cell's label without its point of a sweep: what the cells of one walk share.

    >>> label_of_walk("wall 3[air.temperature_c=40]", {"air.temperature_c": 40})
    'wall 3'
    """
    return label.removesuffix(variant_text(dict(variant)))
