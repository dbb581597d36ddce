"""What no run models, and which of it concerns a scene: what a path would have to meet must be there."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from simulator.world.world import World


def not_modelled(world: World) -> tuple[str, ...]:
    """Those of `NOT_MODELLED` that the planes, edges and curved surfaces of a scene could make, the walker's included.

    They are named for what there is, not for how loud it would be: some of them may be far under the noise.
    """
    return tuple(line for line, concerns in _CONCERNS.items() if concerns(world))


def _curved(world: World) -> bool:
    return len(world.surfaces) > 0


def _curved_beside_own_planes(world: World) -> bool:
    own = [surface.obstacle for surface in world.surfaces]
    return bool(np.isin(world.patches.obstacle, own).any())


_CONCERNS: dict[str, Callable[[World], bool]] = {
    "echoes of the rims of curved surfaces larger than 70 m2, too large for Kirchhoff's integral": _curved,
    "inner edges of corners of less than 60 degrees between planes": lambda world: world.any_facing,
    "two diffractions in one path, but along convex thin panels (8 edges, 5.5 m of rim) and near the border of a "
    "mirror or of the shadow of a second edge": lambda world: len(world.wedges) > 1,
    "a diffraction and a curve in one path": lambda world: len(world.wedges) > 0 and _curved(world),
    "echoes over a plane and a curved surface of one obstacle, as of ground and bin in one mesh: `Obstacle.split()` "
    "makes two obstacles of these, which have them": _curved_beside_own_planes,
    "diffraction at outer edges that two obstacles make together, as mitred walls do":
        lambda world: len(np.unique(world.patches.obstacle)) > 1,
    "how faint strips narrower than half a wavelength (9 mm) echo: here too loud": lambda world: len(world.patches) > 0,
    "sound that bends round a curved body, but for rays off planes or over one edge: it hides all others":
        _curved,
    "two curved reflections one of which is off an uneven body": lambda world: len(world.surfaces) > 1,
    "two curved reflections off one body, or with a plane's between them, and three in one path": _curved,
}  # fmt: skip

NOT_MODELLED = tuple(_CONCERNS)
