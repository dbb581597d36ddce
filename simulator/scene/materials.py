"""Materials: complex pressure reflection in 15-25 kHz, and the table of named ones with sources and uncertainty.

A surface is taken as locally reacting: its specific admittance does not depend on the angle of incidence. Roughness
takes from the coherent echo what it scatters (exp(-2 (k s cos t)^2)); the scattered part is not modelled.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import wofz

from obstaclewatch.support.argument_types import as_complexes, as_floats, check_broadcast, check_types, hold_numbers
from obstaclewatch.support.arrays import Complexes, Floats

BAND_HZ = (15_000.0, 25_000.0)
ROUGHNESS_SOUND_SPEED_M_S = 343.0
AIR_IMPEDANCE_PA_S_M = 413.0  # density times speed of sound at 20 C
_BAND_TABLE_HZ = (15_000.0, 17_500.0, 20_000.0, 22_500.0, 25_000.0)


@dataclass(frozen=True)
class Material:
    """A reflecting surface.

    Attributes:
        name: for messages and reports.
        frequency_hz: (F,) frequencies of the table, increasing, from 15 kHz or less to 25 kHz or more to be traced.
            What reflects is kept at 10 or 12 frequencies of that: a step from 1 to 0.3 within 100 Hz errs by -9 dB.
        normal_reflection: (F,) complex pressure reflection at normal incidence, time convention e^{+jwt};
            magnitude at most 1.
        roughness_m: rms height of the surface about its mesh.
        uncertainty: what is known of |reflection| at normal incidence, plus or minus.
        source: where the numbers come from.

    Raises:
        ValueError: tables that do not fit, a reflection above 1, a negative roughness.

    Example:
        >>> from simulator import Material
        >>> brick = Material.named("brick")
        >>> print(f"{abs(brick.reflection(20e3, cos_incidence=1.0)):.2f}")
        0.87
    """

    name: str
    frequency_hz: tuple[float, ...]
    normal_reflection: tuple[complex, ...]
    roughness_m: float = 0.0
    uncertainty: float = 0.0
    source: str = ""

    def __post_init__(self) -> None:
        check_types(name=(self.name, str))
        if not self.name.strip():
            raise ValueError(f"name of a material must be a word or more, got {self.name!r}")
        frequencies = as_floats(f"frequency_hz of '{self.name}'", self.frequency_hz)
        reflections = as_complexes(f"normal_reflection of '{self.name}'", self.normal_reflection)
        if frequencies.ndim != 1 or len(frequencies) == 0 or frequencies.shape != reflections.shape:
            raise ValueError(
                f"material '{self.name}' must have one reflection per frequency, "
                f"got shape {reflections.shape} for {frequencies.shape}"
            )
        object.__setattr__(self, "frequency_hz", tuple(frequencies.tolist()))
        object.__setattr__(self, "normal_reflection", tuple(reflections.tolist()))
        if not (np.isfinite(frequencies).all() and (np.diff(frequencies) > 0.0).all()):
            raise ValueError(f"frequency_hz of '{self.name}' must increase, got {self.frequency_hz}")
        if not (np.abs(reflections) <= 1.0).all():
            raise ValueError(f"normal_reflection of '{self.name}' must not exceed 1, got {self.normal_reflection}")
        hold_numbers(self, "roughness_m", "uncertainty")
        for name in ("roughness_m", "uncertainty"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise ValueError(f"{name} of '{self.name}' must not be negative, got {getattr(self, name)}")

    @classmethod
    def rigid(cls) -> Material:
        """Reflects everything, at any angle and frequency: exactly 1."""
        return cls("rigid", (0.0, 1e9), (1.0, 1.0), source="definition")

    @classmethod
    def uniform(cls, name: str, normal_reflection: complex, roughness_m: float = 0.0) -> Material:
        """One reflection at normal incidence over the whole of 15-25 kHz."""
        return cls(name, BAND_HZ, (normal_reflection, normal_reflection), roughness_m)

    @classmethod
    def named(cls, name: str) -> Material:
        """A material of the table.

        Raises:
            ValueError: an unknown name; the message lists those there are.
        """
        check_types(material=(name, str))
        if name not in _TABLE:
            raise ValueError(f"material must be one of {', '.join(list_materials())}, got {name!r}")
        return _TABLE[name]

    def reflection(self, frequency_hz: ArrayLike, cos_incidence: ArrayLike, path_rad: ArrayLike = np.inf) -> Complexes:
        """Complex pressure reflection; frequencies (K,) and cosines (P, 1) give (P, K).

        R = (cos t - b) / (cos t + b) with the specific admittance b = (1 - R0) / (1 + R0), times the coherent roughness
        loss exp(-2 (k s cos t)^2), k taken at 343 m/s (Kirchhoff theory of Gaussian heights: Ogilvy 1991, Theory
        of wave scattering from random rough surfaces). At grazing incidence all but a rigid surface turns the sign.

        That is of plane waves. A spherical wave still sees a hard surface there, until it has run along it for some
        time: with the phase kL of its whole path R + (1 - R) F(w), w = sqrt(-jkL / 2) (cos t + b), F(w) = 1 -
        j sqrt(pi) w e^{-w^2} erfc(jw) (Chien and Soroka, J. Sound Vib. 69 (1980) 340-343).

        Args:
            frequency_hz: within the table's frequencies.
            cos_incidence: 0 (grazing) to 1 (normal); both faces of a surface reflect alike, so the sign is ignored.
                NaN, as of a path that was rejected, gives NaN.
            path_rad: kL, (K,) or (P, K); infinite for plane waves. NaN gives NaN.

        Raises:
            ValueError: a frequency outside the table, a cosine beyond 1, a negative path.
        """
        frequency, cosine = as_floats("frequency_hz", frequency_hz), np.abs(as_floats("cos_incidence", cos_incidence))
        path = as_floats("path_rad", path_rad)
        self._check(frequency, cosine, path)
        normal = np.interp(frequency, self.frequency_hz, np.array(self.normal_reflection))
        wavenumber = 2.0 * np.pi * frequency / ROUGHNESS_SOUND_SPEED_M_S
        rough = np.exp(-2.0 * (wavenumber * self.roughness_m * cosine) ** 2)
        return _of_sphere(normal, cosine, path) * rough

    def _check(self, frequency_hz: Floats, cosine: Floats, path_rad: Floats) -> None:
        check_broadcast(frequency_hz=frequency_hz, cos_incidence=cosine, path_rad=path_rad)
        low, high = self.frequency_hz[0], self.frequency_hz[-1]
        outside = ~((frequency_hz >= low) & (frequency_hz <= high))
        if outside.any():
            raise ValueError(
                f"frequency_hz must be within the table of '{self.name}', {low:g} to {high:g}, "
                f"got {frequency_hz[outside].flat[0]:g}"
            )
        if (cosine > 1.0 + 1e-9).any():  # rounding of normalised vectors; NaN of a rejected path passes
            raise ValueError(f"cos_incidence must be -1 to 1, got {np.nanmax(cosine)}")
        if (path_rad < 0.0).any():
            raise ValueError(f"path_rad must not be negative, got {np.nanmin(path_rad)}")


SOFTEST = 1e-12  # 1 + reflection of a surface without any pressure, in place of 0


def list_materials() -> list[str]:
    """Names that `Material.named` knows."""
    return sorted(_TABLE)


def limp_sheet_reflection(surface_density_kg_m2: float, frequency_hz: ArrayLike) -> Complexes:
    """Reflection at normal incidence of a limp sheet with air behind it: jX / (1 + jX), X = w m / (2 rho c).

    The mass law (Fahy and Gardonio 2007, Sound and structural vibration, chapter on transmission).
    """
    ratio = np.pi * np.asarray(frequency_hz, dtype=np.float64) * surface_density_kg_m2 / AIR_IMPEDANCE_PA_S_M
    return 1j * ratio / (1.0 + 1j * ratio)


def _locally_reacting(normal: Complexes, cosine: Floats) -> Complexes:
    """Reflection at an angle from that at normal incidence; 1 where grazing meets rigid."""
    missing = 1.0 - normal
    denominator = (1.0 + normal) * cosine + missing
    denominator = np.where(denominator == 0.0, 1.0, denominator)
    with np.errstate(invalid="ignore"):  # the NaN of a rejected path passes
        return 1.0 - 2.0 * missing / denominator  # exactly 1 where nothing is missing


def _of_sphere(normal: Complexes, cosine: Floats, path_rad: Floats) -> Complexes:
    """The same of a spherical wave with the phase of its path."""
    plane = _locally_reacting(normal, cosine)
    if (normal == 1.0).all():
        return plane
    far = np.isinf(path_rad)
    admittance = (1.0 - normal) / np.where(normal == -1.0, SOFTEST, 1.0 + normal)
    w = np.sqrt(-0.5j * np.where(far, 0.0, path_rad)) * (cosine + admittance)
    still_hard = np.where(far, 0.0, 1.0 - 1j * np.sqrt(np.pi) * w * wofz(-w))
    found: Complexes = plane + (1.0 - plane) * still_hard
    return found


def _sheet(name: str, surface_density_kg_m2: float, uncertainty: float, source: str) -> Material:
    reflection = limp_sheet_reflection(surface_density_kg_m2, _BAND_TABLE_HZ)
    return Material(name, _BAND_TABLE_HZ, tuple(reflection), 0.0, uncertainty, f"mass law, {source}")


def _flat(name: str, magnitude: float, roughness_m: float, uncertainty: float, source: str) -> Material:
    return Material(name, BAND_HZ, (magnitude, magnitude), roughness_m, uncertainty, source)


# Direct measurements of building materials at 20 kHz hardly exist. "Inferred" marks values that follow from impedance,
# porosity or lower frequencies. Left out of the smooth ones: the air's thermal boundary layer (|R| -0.003, -0.02 dB).
_PORES = "inferred from absorption tables up to 8 kHz, growing like sqrt(f)"
_ASPHALT = "sealed asphalt, 0.85 at 85 degrees of incidence; texture 0.5 mm rms assumed"
_ROWS = (
    _sheet("metal", 5.5, 0.002, "0.7 mm steel (car body)"),
    _sheet("sign-sheet", 5.4, 0.002, "2 mm aluminium"),
    _sheet("glass", 10.0, 0.002, "4 mm glass"),
    _sheet("plastic", 2.8, 0.005, "3 mm polyethylene (dustbin)"),
    _sheet("foliage", 0.2, 0.01, "0.2 kg/m2 leaf: for meshes of leaf discs, never for the hull of a bush"),
    _flat("brick", 0.87, 0.0, 0.05, "deep-jointed brickwork, its joints included; inferred"),
    _flat("painted-brick", 0.98, 0.2e-3, 0.015, _PORES),
    _flat("concrete", 0.975, 0.2e-3, 0.015, _PORES),
    _flat("concrete-paving", 0.97, 0.4e-3, 0.02, _PORES),
    _flat("asphalt", 0.986, 0.5e-3, 0.01, _ASPHALT),
    _flat("plaster", 0.98, 0.05e-3, 0.015, _PORES),
    _flat("tile", 0.995, 0.0, 0.005, "inferred: glazed, no pores"),
    _flat("wood", 0.98, 0.05e-3, 0.02, "inferred: varnished, few pores"),
    _flat("bark", 0.90, 1.0e-3, 0.08, "inferred: porous outer bark; ridges about 1 mm rms where it is smooth"),
    _flat("rubber", 0.995, 0.1e-3, 0.005, "inferred: solid rubber, no pores"),
    _flat("skin", 0.999, 0.05e-3, 0.001, "inferred from the impedance of soft tissue, 1.6e6 Pa s/m"),
    _flat(
        "light-clothing", 0.70, 0.0, 0.15, "-3 +- 2 dB: one thin or dense layer over skin, the least of that; inferred"
    ),
    _flat("coat", 0.40, 0.0, 0.15, "-8 +- 3 dB: wool, fleece or quilting several centimetres thick; inferred"),
    _flat("clothed-person", 0.56, 0.0, 0.25, "-5 +- 4 dB, an effective value over clothes and folds; inferred"),
)
_TABLE = {material.name: material for material in (Material.rigid(), *_ROWS)}
