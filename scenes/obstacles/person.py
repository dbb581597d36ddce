"""Lofted people: smooth closed bodies of horizontal ellipses, standing or in mid-stride, and the body of the walker.

Their measures can be set one by one; the people of the streets have real shapes (`scenes.obstacles.pedestrian`).

Proportions follow Drillis and Contini's segment lengths (as parts of the stature, in Winter, Biomechanics and Motor
Control of Human Movement, table 4.1): hip 0.530, knee 0.285, ankle 0.039, shoulder 0.818, chin 0.870, shoulder
breadth 0.259, foot 0.152. Girths are those of a clothed adult.
"""

from __future__ import annotations

import numpy as np
import trimesh
from scipy.interpolate import PchipInterpolator

from obstaclewatch.support.arrays import Floats
from scenes.obstacles.measures import measured
from scenes.obstacles.solids import ellipse_rings, ellipsoid, loft, merged, shifted, tilted
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle

# Profiles by height, in parts of the stature. Torso from crotch to neck: half depth and half breadth.
TORSO = PchipInterpolator(
    [0.455, 0.475, 0.520, 0.570, 0.620, 0.680, 0.740, 0.780, 0.805, 0.822, 0.834, 0.848, 0.870, 0.890],
    np.array(
        [
            [0.050, 0.062, 0.070, 0.066, 0.061, 0.066, 0.070, 0.064, 0.056, 0.047, 0.040, 0.034, 0.032, 0.032],
            [0.075, 0.093, 0.101, 0.096, 0.087, 0.094, 0.104, 0.111, 0.108, 0.092, 0.068, 0.044, 0.034, 0.032],
        ]
    ).T,
)
CHEST = 0.070
# Limbs: radius.
LEG = PchipInterpolator([0.035, 0.10, 0.20, 0.285, 0.40, 0.50], [0.026, 0.027, 0.034, 0.034, 0.046, 0.055])
ARM = PchipInterpolator([0.45, 0.52, 0.60, 0.72, 0.79], [0.018, 0.020, 0.025, 0.028, 0.030])


@measured
def person(stature_m: float = 1.75, stride_rad: float = 0.28, girth: float = 1.0, arms: bool = True) -> trimesh.Trimesh:
    """A clothed adult facing -x, on the ground: torso, head, arms, legs and feet as overlapping smooth closed parts.

    Args:
        stature_m: height of the crown, 1.0 to 2.3 m.
        stride_rad: angle of the legs (and, opposed, of the arms) from the vertical; 0 stands.
        girth: factor on all thicknesses.
        arms: whether there are any.

    Raises:
        ValueError: a stature outside 1.0-2.3 m, a stride outside 0-0.6 rad, a girth outside 0.5-2.
    """
    _require_within("stature_m", stature_m, 1.0, 2.3)
    _require_within("stride_rad", stride_rad, 0.0, 0.6)
    _require_within("girth", girth, 0.5, 2.0)
    parts = [_torso(girth), _head()]
    for side in (-1.0, 1.0):
        parts += _leg(side, side * stride_rad, girth)
        if arms:
            parts.append(_arm(side, -side * 0.8 * stride_rad, girth))
    body = merged(parts)
    body.apply_scale(stature_m)
    return shifted(body, [0.0, 0.0, -body.bounds[0, 2]])


@measured
def walker_body(
    phone_distance_m: float = 0.35, phone_height_m: float = 1.3, stature_m: float = 1.75, girth: float = 1.0
) -> Obstacle:
    """The user behind the phone, in the walker's frame: origin at the phone, x forwards, y to the left, z up.

    Torso, head and legs. The rounded legs end 3 to 4 cm above the ground, so that the bob of the gait never sinks them
    into it.

    Args:
        phone_distance_m: from the phone's origin to the front of the chest.
        phone_height_m: of the phone's origin above the ground.
        stature_m, girth: of the user.

    Raises:
        ValueError: a distance or height that is not positive, or a stature or girth that `person` refuses.

    Example:
        >>> from scenes import walker_body
        >>> from simulator import Phone
        >>> phone = Phone.named("galaxy-s5").held_by(walker_body(stature_m=1.8))
        >>> phone.body.mesh.bounds[:, 2].round(2)  # from the legs to the crown, the phone at 0
        array([-1.27,  0.5 ])
    """
    _require_within("stature_m", stature_m, 1.0, 2.3)
    _require_within("girth", girth, 0.5, 2.0)
    legs = [_limb(LEG, 0.055 * side, 0.0, 0.50, girth, first_z=0.08 / stature_m) for side in (-1.0, 1.0)]
    body = merged([_torso(girth), _head(), *legs])
    body.apply_scale(stature_m)
    chest = CHEST * girth * stature_m
    return Obstacle(
        shifted(body, [-phone_distance_m - chest, 0.0, -phone_height_m]),
        Material.named("clothed-person"),
        "walker",
        category="walker",
    )


def _torso(girth: float) -> trimesh.Trimesh:
    """Torso and neck, rounded off at both ends."""
    low, high = TORSO.x[[0, -1]]
    z = np.concatenate([np.linspace(low, 0.76, 9), np.linspace(0.76, 0.86, 9)[1:], [0.875, high]])
    radii = TORSO(z) * girth
    return loft(*_rounded(z, radii, np.zeros((len(z), 2)), 28))


def _head() -> trimesh.Trimesh:
    return ellipsoid([-0.012, 0.0, 0.931], [0.056, 0.044, 0.069], segments=22, rows=10)


def _leg(side: float, swing_rad: float, girth: float) -> list[trimesh.Trimesh]:
    hip = 0.50
    limb = _limb(LEG, 0.055 * side, swing_rad, hip, girth)
    ankle = -np.tan(swing_rad) * (hip - LEG.x[0])
    along_z = ellipsoid(np.zeros(3), [0.022, 0.028, 0.078], segments=14, rows=10)
    foot = shifted(tilted(along_z, -np.pi / 2), [ankle - 0.025, 0.055 * side, 0.022])
    return [limb, foot]


def _arm(side: float, swing_rad: float, girth: float) -> trimesh.Trimesh:
    return _limb(ARM, 0.128 * girth * side, swing_rad, 0.79, girth)


def _limb(
    profile: PchipInterpolator, y: float, swing_rad: float, pivot: float, girth: float, first_z: float | None = None
) -> trimesh.Trimesh:
    """A limb of horizontal ellipses hung from a pivot height, its foot forward (-x) for a positive angle."""
    low = profile.x[0] if first_z is None else first_z
    z = np.linspace(low, profile.x[-1], 7)
    radius = profile(z) * girth
    center = np.stack([-np.tan(swing_rad) * (pivot - z), np.full_like(z, y)], axis=-1)
    return loft(*_rounded(z, np.stack([radius / np.cos(swing_rad), radius], axis=-1), center, 16))


def _rounded(z: Floats, radii: Floats, center: Floats, segments: int) -> tuple[Floats, Floats, Floats]:
    """Rings, first and last point of a limb that ends in ellipsoidal caps as high as its mean radius."""
    latitude = np.linspace(0.0, np.pi / 2, 5)[1:-1]
    height = radii[[0, -1]].mean(axis=1)
    below, above = z[0] - height[0] * np.sin(latitude[::-1]), z[-1] + height[1] * np.sin(latitude)
    shrink = np.cos(latitude)[:, None]
    rings = ellipse_rings(
        np.concatenate([below, z, above]),
        np.concatenate([shrink[::-1] * radii[0], radii, shrink * radii[-1]]),
        np.concatenate([np.repeat(center[:1], 3, axis=0), center, np.repeat(center[-1:], 3, axis=0)]),
        segments,
    )
    return rings, np.append(center[0], z[0] - height[0]), np.append(center[-1], z[-1] + height[1])


def _require_within(name: str, value: float, low: float, high: float) -> None:
    if not low <= value <= high:
        raise ValueError(f"{name} must lie between {low} and {high}, got {value}")
