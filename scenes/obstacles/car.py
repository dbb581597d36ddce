"""Cars: sedan, SUV and van bodies of flat and gently curved panels, on four wheels, with mirrors and number plates.

The body is a loft of superellipses along the car, with the waist line as its upper edge, filleted and bowed at the
ends; every vertex lies on the curved panel. The cabin is a loft of rounded outlines that shrink towards the roof.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator

from obstaclewatch.support.arrays import Floats
from scenes.obstacles.measures import measured
from scenes.obstacles.solids import box, ellipsoid, loft, merged, raised, rounded_rectangle, shifted, wheel
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle

Style = Literal["sedan", "suv", "van"]

CLEARANCE_M = 0.20
END_FILLET_M = 0.16
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


@measured
def car(style: Style = "sedan", scale: float = 1.0) -> trimesh.Trimesh:
    """A car on its wheels, its length along x, the front to -x.

    Args:
        style: "sedan", "suv" or "van".
        scale: factor on all measures.

    Raises:
        ValueError: an unknown style, or a scale outside 0.01-100.
    """
    if style not in list(SHAPES):  # of a dict, a value without a hash would raise a TypeError
        raise ValueError(f"style must be one of {sorted(SHAPES)}, got {style!r}")
    if not 0.01 <= scale <= 100.0:
        raise ValueError(f"scale must lie within 0.01 to 100, got {scale}")
    shape = SHAPES[style]
    mesh = merged([_body(shape), _cabin(shape), *_wheels(shape), *_mirrors(shape), *_plates(shape)])
    mesh.apply_scale(scale)
    return mesh


def random_car(rng: np.random.Generator, name: str = "car") -> Obstacle:
    """A sedan (half of them), an SUV or a van, within 8 % of its usual size."""
    style: Style = ("sedan", "suv", "van")[int(rng.choice(3, p=[0.5, 0.3, 0.2]))]  # type: ignore[assignment]
    return Obstacle(car(style, rng.uniform(0.92, 1.05)), Material.named("metal"), name, category="car")


def _body(shape: CarShape) -> trimesh.Trimesh:
    """The lower body: one superellipse per station along x, then narrowed and bowed towards the ends."""
    station, inset = _stations(shape)
    waist = PchipInterpolator(shape.waist_x, shape.waist_m)(2.0 * station / shape.length_m)
    half = np.stack([np.full_like(waist, shape.width_m / 2), 0.5 * (waist - CLEARANCE_M)], axis=-1)
    section = (half - inset[:, None])[:, None] * _superellipse(32)
    section[..., 1] += CLEARANCE_M + half[:, None, 1]
    along = np.broadcast_to(station[:, None, None], (*section.shape[:2], 1))
    mesh = loft(np.concatenate([along, section], axis=-1), strips=True)
    return trimesh.Trimesh(_bowed(np.asarray(mesh.vertices), shape), mesh.faces, process=False)


def _stations(shape: CarShape) -> tuple[Floats, Floats]:
    """Places of the rings along x, and how far each is drawn in: a quarter circle of fillet at both ends."""
    half, angle = shape.length_m / 2, np.linspace(0.0, np.pi / 2, 7)
    end_x, end_inset = END_FILLET_M * (1.0 - np.cos(angle)) - half, END_FILLET_M * (1.0 - np.sin(angle))
    middle = np.linspace(-half + END_FILLET_M, half - END_FILLET_M, 13)[1:-1]
    x = np.concatenate([end_x, middle, -end_x[::-1]])
    return x, np.concatenate([end_inset, np.zeros(len(middle)), end_inset[::-1]])


def _superellipse(count: int) -> Floats:
    """(count, 2) points of |y|^5 + |z|^5 = 1: nearly flat flanks with rounded corners."""
    angle = 2.0 * np.pi * np.arange(count) / count
    circle = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    circle[np.abs(circle) < 1e-12] = 0.0
    return np.sign(circle) * np.abs(circle) ** 0.4


def _bowed(vertices: Floats, shape: CarShape) -> Floats:
    """Narrow the car by 8 cm towards its ends, and bow the ends in plan to a radius of 2.2 m."""
    x, y, z = vertices.T
    along = 2.0 * x / shape.length_m
    return np.stack([x - along**5 * y**2 / (2.0 * 2.2), y * (1.0 - 0.08 * along**2 / shape.width_m), z], axis=-1)


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


def _mirrors(shape: CarShape) -> list[trimesh.Trimesh]:
    """A door mirror on either side, just behind the foot of the windscreen; they reach out of the overall width."""
    x = (shape.cabin_foot[0] + 0.1) * shape.length_m / 2
    z = float(np.interp(2.0 * x / shape.length_m, shape.waist_x, shape.waist_m)) + 0.06
    one = ellipsoid(np.zeros(3), [0.065, 0.09, 0.075], segments=16, rows=8)
    return [shifted(one, [x, side * (shape.width_m / 2 + 0.02), z]) for side in (-1.0, 1.0)]


def _plates(shape: CarShape) -> list[trimesh.Trimesh]:
    """The number plates at either end, 0.52 m by 0.11 m and upright: the flattest thing on a car."""
    return [box([0.05, 0.52, 0.11], [end * (shape.length_m / 2 - 0.005), 0.0, 0.55]) for end in (-1.0, 1.0)]


def _wheels(shape: CarShape) -> list[trimesh.Trimesh]:
    one, radius = wheel(shape.wheel_radius_m, WHEEL_WIDTH_M), shape.wheel_radius_m
    track = shape.width_m / 2 - WHEEL_WIDTH_M / 2
    return [shifted(one, [x * 0.30 * shape.length_m, y * track, radius]) for x in (-1.0, 1.0) for y in (-1.0, 1.0)]
