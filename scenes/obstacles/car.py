"""Cars: sedan, SUV and van bodies of flat and gently curved panels, on four wheels.

The body is a rounded box lofted along the car, with the waist line of the car as its upper edge, bowed in plan and in
section by smooth maps that move every vertex onto the curved panel. The cabin is a loft of rounded outlines that
shrink towards the roof.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import trimesh
from numpy.typing import NDArray
from scipy.interpolate import PchipInterpolator

from scenes.solids import loft, merged, raised, rounded_rectangle, shifted, wheel
from simulator.materials import Material
from simulator.scene import Obstacle

Array = NDArray[np.float64]
Style = Literal["sedan", "suv", "van"]

CLEARANCE_M = 0.20
SILL_FILLET_M = 0.10
WHEEL_WIDTH_M = 0.20


@dataclass(frozen=True)
class CarShape:
    """Measures of a car; lengths along x count from its middle, the front points to -x.

    Attributes:
        length_m, width_m, height_m: overall, without mirrors.
        waist_x: (K,) places along the car, as parts of the half length, from -1 to 1.
        waist_m: (K,) height of the upper edge of the body there (bonnet, waist line, boot).
        cabin_foot: (2,) front and rear end of the cabin at the waist, as parts of the half length.
        cabin_roof: (2,) the same at the roof.
        wheel_radius_m: radius of the wheels.
    """

    length_m: float
    width_m: float
    height_m: float
    waist_x: tuple[float, ...]
    waist_m: tuple[float, ...]
    cabin_foot: tuple[float, float]
    cabin_roof: tuple[float, float]
    wheel_radius_m: float


SHAPES: dict[Style, CarShape] = {
    "sedan": CarShape(
        length_m=4.6,
        width_m=1.80,
        height_m=1.45,
        waist_x=(-1.0, -0.8, -0.35, 0.5, 1.0),
        waist_m=(0.70, 0.80, 0.93, 0.98, 0.95),
        cabin_foot=(-0.42, 0.68),
        cabin_roof=(-0.10, 0.38),
        wheel_radius_m=0.32,
    ),
    "suv": CarShape(
        length_m=4.7,
        width_m=1.90,
        height_m=1.72,
        waist_x=(-1.0, -0.85, -0.45, 0.5, 1.0),
        waist_m=(0.88, 0.98, 1.08, 1.10, 1.10),
        cabin_foot=(-0.50, 0.94),
        cabin_roof=(-0.26, 0.82),
        wheel_radius_m=0.37,
    ),
    "van": CarShape(
        length_m=5.0,
        width_m=1.95,
        height_m=2.00,
        waist_x=(-1.0, -0.9, -0.65, 0.5, 1.0),
        waist_m=(0.85, 0.98, 1.08, 1.10, 1.10),
        cabin_foot=(-0.78, 0.95),
        cabin_roof=(-0.52, 0.90),
        wheel_radius_m=0.34,
    ),
}


def car(style: Style = "sedan", scale: float = 1.0) -> trimesh.Trimesh:
    """A car on its wheels, its length along x, the front to -x.

    Args:
        style: "sedan", "suv" or "van".
        scale: factor on all measures.

    Raises:
        ValueError: an unknown style, or a scale that is not positive.
    """
    if style not in SHAPES:
        raise ValueError(f"style must be one of {sorted(SHAPES)}, got {style!r}")
    if not scale > 0.0:
        raise ValueError(f"scale must be positive, got {scale}")
    shape = SHAPES[style]
    whole = merged([_body(shape), _cabin(shape), *_wheels(shape)])
    whole.apply_scale(scale)
    return whole


def random_car(rng: np.random.Generator, name: str = "car") -> Obstacle:
    """A sedan (half of them), an SUV or a van, within 8 % of its usual size."""
    style: Style = ("sedan", "suv", "van")[int(rng.choice(3, p=[0.5, 0.3, 0.2]))]  # type: ignore[assignment]
    return Obstacle(car(style, rng.uniform(0.92, 1.05)), Material.named("metal"), name, category="car")


def _body(shape: CarShape) -> trimesh.Trimesh:
    """The lower body: one ring of the section's outline per station along x, then bowed."""
    station, inset = _stations(shape)
    rings = np.stack([_section(shape, x, d) for x, d in zip(station, inset, strict=True)])
    # A loft progresses along +x with rings that turn counter-clockwise seen from ahead: (y, z) already does.
    mesh = loft(rings)
    mesh.vertices = _bowed(np.asarray(mesh.vertices), shape)
    return mesh


def _stations(shape: CarShape) -> tuple[Array, Array]:
    """Places along x of the rings, and how far each is drawn in: flat ends, quarter-circle fillets, long sides."""
    half, fillet = shape.length_m / 2, 0.16
    angle = np.linspace(0.0, np.pi / 2, 6)
    end_x = np.concatenate([np.full(2, -half), -half + fillet * (1.0 - np.cos(angle))])
    end_inset = np.concatenate([[0.30, 0.23], fillet * (1.0 - np.sin(angle))])
    middle = np.linspace(-half + fillet, half - fillet, 11)[1:-1]
    x = np.concatenate([end_x, middle, -end_x[::-1]])
    return x, np.concatenate([end_inset, np.zeros(len(middle)), end_inset[::-1]])


def _section(shape: CarShape, x_m: float, inset_m: float) -> Array:
    """(N, 3) outline of the body across the car, drawn in by the inset on all sides."""
    waist = PchipInterpolator(shape.waist_x, shape.waist_m)(2.0 * x_m / shape.length_m)
    height, width = waist - CLEARANCE_M, shape.width_m
    outline = rounded_rectangle([width, height], SILL_FILLET_M, corner_segments=4, side_segments=4)
    shrink = 1.0 - 2.0 * inset_m / np.array([width, height])
    outline = outline * shrink + [0.0, CLEARANCE_M + height / 2]
    return np.insert(outline, 0, x_m, axis=1)


def _bowed(vertices: Array, shape: CarShape) -> Array:
    """Bow the ends in plan (radius 2.2 m), the flanks in section and along the car (6 cm and 4 cm of crown)."""
    x, y, z = vertices.T
    along = 2.0 * x / shape.length_m
    middle = 0.5 * (CLEARANCE_M + max(shape.waist_m))
    up = (z - middle) / (max(shape.waist_m) - CLEARANCE_M)
    narrow = 1.0 - (0.12 * up**2 + 0.05 * along**2) / shape.width_m * 2.0
    forward = x - along**5 * y**2 / (2.0 * 2.2)
    return np.stack([forward, y * narrow, z], axis=-1)


def _cabin(shape: CarShape) -> trimesh.Trimesh:
    """The glass house: rounded outlines from the waist to the roof, then a filleted roof edge and a flat roof."""
    half, top = shape.length_m / 2, shape.height_m
    foot_z = min(shape.waist_m[2:]) - 0.12
    fillet = 0.12
    angle = np.linspace(0.0, np.pi / 2, 6)[1:]
    rise = np.concatenate([np.linspace(foot_z, top - fillet, 5), top - fillet * (1.0 - np.sin(angle))])
    inset = np.concatenate([np.zeros(5), fillet * (1.0 - np.cos(angle))])
    step = (rise - foot_z) / (top - foot_z)
    ends = half * (np.array(shape.cabin_foot) + step[:, None] * (np.array(shape.cabin_roof) - shape.cabin_foot))
    ends = ends + inset[:, None] * np.array([1.0, -1.0])
    width = shape.width_m * (0.93 - 0.17 * step) - 2.0 * inset
    outlines = [
        rounded_rectangle([b - a, w], 0.18, corner_segments=5) + [0.5 * (a + b), 0.0]
        for (a, b), w in zip(ends, width, strict=True)
    ]
    return loft(raised(np.stack(outlines), rise))


def _wheels(shape: CarShape) -> list[trimesh.Trimesh]:
    one, radius = wheel(shape.wheel_radius_m, WHEEL_WIDTH_M), shape.wheel_radius_m
    track = shape.width_m / 2 - WHEEL_WIDTH_M / 2
    return [
        shifted(one, [x * 0.30 * shape.length_m, y * track, radius]) for x in (-1.0, 1.0) for y in (-1.0, 1.0)
    ]
