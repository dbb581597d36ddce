"""Images of speaker and microphones as ends of Kirchhoff's sum, with what each of them sees of the body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.rows import Rows
from simulator.images.given_planes import image_in
from simulator.world.frames import into_rest, rotated
from simulator.world.search_context import Search


@dataclass(frozen=True)
class Sights(Rows):
    """E images from which a body may be seen.

    Attributes:
        pose, side: (E,) pose, and 0 for the speaker, 1 and 2 for the microphones.
        order, sequence, point_m: (E,), (E, N), (E, 3) as in `image_tree.Images`.
    """

    pose: Ints
    side: Ints
    order: Ints
    sequence: Ints
    point_m: Floats


@dataclass(frozen=True)
class Ends:
    """E points that see a body, group by group: those of one pose.

    Attributes:
        point_m: (E, 3) in the body's rest frame, images included.
        lean: (E, 3) of the transducers (`Transducer.lean`), in that frame and mirrored as the points are.
        group: (E,) sorted.
        view: (E,) which of the views each has.
        lit: (V, F) facets of the body that nothing hides in each view.
    """

    point_m: Floats
    lean: Floats
    group: Ints
    view: Ints
    lit: Flags

    @classmethod
    def of(cls, search: Search, obstacle: int, sights: Sights, view: Ints, lit: Flags) -> Ends:
        """Images with a view of an obstacle."""
        frame = search.tracing.placed[sights.pose, obstacle]
        return cls(into_rest(sights.point_m, frame), _leans(search, sights, frame), sights.pose, view, lit)


def _leans(search: Search, sights: Sights, frame: Floats) -> Floats:
    """(E, 3) of the images of transducers as a body in frames (E, 4) sees them."""
    phone, tracing, where = search.phone, search.tracing, (sights.pose, sights.order, sights.sequence)
    own = np.array([each.lean for each in (phone.speaker, *phone.mics)])[sights.side]
    held = np.broadcast_to(tracing.pose.rotation.as_matrix(), (len(tracing.pose), 3, 3))[sights.pose]
    tip, foot = (image_in(tracing.mirrors, each, *where) for each in (np.einsum("eij,ej->ei", held, own), 0.0 * own))
    return rotated(tip - foot, -frame[:, 3])
