"""Dustbins: round litter bins, wheeled bins, and the dumpsters and donation boxes the paper counts among them."""

from __future__ import annotations

import numpy as np
import trimesh

from scenes.obstacles.measures import measured, require_least
from scenes.obstacles.solids import (
    box,
    ellipse_rings,
    loft,
    merged,
    prism,
    raised,
    rounded_rectangle,
    shifted,
    wheel,
)
from simulator.scene.materials import Material
from simulator.scene.scene import Obstacle


@measured
def litter_bin(
    radius_m: float = 0.25, height_m: float = 0.9, taper: float = 0.0, dome_m: float = 0.0
) -> trimesh.Trimesh:
    """A round bin: capped cylinder or cone, with a flat or domed lid.

    Args:
        radius_m: radius of the rim, the widest place.
        height_m: height of the rim.
        taper: how much narrower the bottom is, as a part of the radius, below 1.
        dome_m: height of an ellipsoidal lid above the rim; 0 is flat.

    Raises:
        ValueError: a measure that is not positive, a taper outside [0, 1), a negative dome.
    """
    if not 0.0 <= taper < 1.0:
        raise ValueError(f"taper must be at least 0 and below 1, got {taper}")
    step = np.linspace(0.0, 1.0, 7)
    z, radius = step * height_m, radius_m * (1.0 - taper * (1.0 - step))
    if dome_m == 0.0:
        return loft(ellipse_rings(z, radius, segments=48))
    latitude = np.linspace(0.0, np.pi / 2, 9)[1:-1]
    z = np.concatenate([z, height_m + dome_m * np.sin(latitude)])
    radius = np.concatenate([radius, radius_m * np.cos(latitude)])
    return loft(ellipse_rings(z, radius, segments=48), top_m=[0.0, 0.0, height_m + dome_m])


@measured
def wheeled_bin(width_m: float = 0.58, depth_m: float = 0.70, height_m: float = 1.05) -> trimesh.Trimesh:
    """A two-wheeled household bin: tapered body with rounded corners, a sloping lid and two wheels; front to -x.

    Raises:
        ValueError: a measure that is not positive, or a bin too small for its corners or wheels.
    """
    require_least("width_m", width_m, 0.2, "for rounded corners")
    require_least("depth_m", depth_m, 0.2, "for rounded corners")
    require_least("height_m", height_m, 0.25, "for its wheels")
    scale = np.array([0.78, 0.89, 1.0])
    z = np.array([0.04, 0.5 * height_m, 0.93 * height_m])
    outline = [rounded_rectangle([depth_m * s, width_m * s], 0.06 * s) for s in scale]
    body = loft(raised(np.stack(outline), z))
    cover = rounded_rectangle([depth_m * 1.06, width_m * 1.06], 0.07)
    lid = loft(raised(np.stack([cover, cover]), np.array([0.93, 1.0]) * height_m))
    axle = 0.36 * depth_m
    wheels = [shifted(wheel(0.1, 0.05), [axle, side * 0.40 * width_m, 0.1]) for side in (-1.0, 1.0)]
    return merged([body, lid, *wheels])


@measured
def dumpster(length_m: float = 1.8, depth_m: float = 1.2, height_m: float = 1.3) -> trimesh.Trimesh:
    """A steel container on short feet, its front to -x and higher at the back, with a sloping lid; length along y.

    Raises:
        ValueError: a measure that is not positive, or a height that its feet take up.
    """
    require_least("height_m", height_m, 0.25, "for its feet")
    foot, front, half = 0.12, 0.82 * height_m, depth_m / 2
    profile = np.array([[-0.92 * half, foot], [half, foot], [half, height_m], [-half, front]])
    body = prism(profile, length_m)
    feet = [
        box([0.1, 0.1, foot], [x * 0.7 * half, y * 0.4 * length_m, foot / 2]) for x in (-1.0, 1.0) for y in (-1.0, 1.0)
    ]
    sleeves = [box([0.5 * depth_m, 0.06, 0.14], [0.0, y * (length_m / 2 + 0.03), 0.55 * height_m]) for y in (-1.0, 1.0)]
    return merged([body, *feet, *sleeves])


@measured
def donation_box(width_m: float = 1.1, depth_m: float = 1.0, height_m: float = 1.9) -> trimesh.Trimesh:
    """A clothes-donation box of sheet steel with a chute hood on its front (-x).

    Raises:
        ValueError: a measure that is not positive.
    """
    body = box([depth_m, width_m, height_m])
    hood_profile = np.array([[-0.16, 0.0], [0.0, 0.0], [0.0, 0.38], [-0.05, 0.38]])
    hood = shifted(prism(hood_profile, 0.7 * width_m), [-depth_m / 2, 0.0, 0.68 * height_m])
    return merged([body, hood])


def random_dustbin(rng: np.random.Generator, name: str = "dustbin") -> Obstacle:
    """A litter bin (half of them), a wheeled bin, a dumpster or a donation box.

    Litter bins have radii of 0.20-0.35 m and heights of 0.7-1.1 m.
    """
    kind = rng.choice(["litter", "wheeled", "dumpster", "donation"], p=[0.5, 0.15, 0.25, 0.1])
    if kind == "litter":
        taper, dome = rng.choice([0.0, rng.uniform(0.05, 0.2)]), rng.choice([0.0, rng.uniform(0.08, 0.18)])
        mesh = litter_bin(rng.uniform(0.20, 0.35), rng.uniform(0.7, 1.1), float(taper), float(dome))
        return Obstacle(mesh, Material.named(str(rng.choice(["metal", "plastic"]))), name, category="dustbin")
    if kind == "wheeled":
        mesh = wheeled_bin(rng.uniform(0.50, 0.62), rng.uniform(0.62, 0.76), rng.uniform(0.98, 1.1))
        return Obstacle(mesh, Material.named("plastic"), name, category="dustbin")
    if kind == "dumpster":
        mesh = dumpster(rng.uniform(1.4, 2.0), rng.uniform(0.9, 1.3), rng.uniform(1.1, 1.5))
    else:
        mesh = donation_box(rng.uniform(0.9, 1.3), rng.uniform(0.8, 1.1), rng.uniform(1.7, 2.1))
    return Obstacle(mesh, Material.named("metal"), name, category="dustbin")
