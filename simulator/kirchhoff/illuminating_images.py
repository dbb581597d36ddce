"""Images of speaker and microphones as ends of Kirchhoff's sum, with what each of them sees of the body."""

from __future__ import annotations

from dataclasses import dataclass

from obstaclewatch.support.arrays import Flags, Floats, Ints


@dataclass(frozen=True)
class Ends:
    """E points that see a body, group by group: those of one pose.

    Attributes:
        point_m: (E, 3) in the body's rest frame, images included.
        lean: (E, 3) of the transducers (`Transducer.lean`), in that frame and mirrored as the points are.
        group: (E,) sorted.
        view: (E,) which of the views each has.
        lit: (V, S) spots of the body that nothing hides in each view.
    """

    point_m: Floats
    lean: Floats
    group: Ints
    view: Ints
    lit: Flags
