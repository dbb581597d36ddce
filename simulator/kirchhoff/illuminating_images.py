"""Images of speaker and microphones as ends of Kirchhoff's sum, with what each of them sees of the body."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.vectors import dot, norm
from simulator.images.given_planes import image_in
from simulator.images.image_pairs import Body
from simulator.waves.sweep import Sweep
from simulator.world.frames import into_rest, rotated
from simulator.world.search_context import Search
from simulator.world.world import Tracing

NEARBY_S = 5e-3  # to either side of the instant at which a velocity is taken
NOWHERE_M = 1e-9  # what is nearer has no direction


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
        drift_m: (E, 3) their velocities times `Sweep.coupling_s`; 0 where nothing moves.
        lean: (E, 3) of the transducers (`Transducer.lean`), in that frame and mirrored as the points are.
        group: (E,) sorted.
        view: (E,) which of the views each has.
        lit: (V, F) facets of the body that nothing hides in each view.
    """

    point_m: Floats
    drift_m: Floats
    lean: Floats
    group: Ints
    view: Ints
    lit: Flags

    @classmethod
    def of(cls, search: Search, body: Body, sights: Sights, origin_m: Floats, view: Ints, lit: Flags) -> Ends:
        """Images with a view of a body; of those that move where they are as the chirp passes `REFERENCE_HZ`.

        Args:
            origin_m: (E, 3) the image of the speaker from which sound strikes the body, where things move.
        """
        frame = search.tracing.placed[sights.pose, body.obstacle]
        point, drift = into_rest(sights.point_m, frame), np.zeros_like(sights.point_m)
        if search.sweep is not None:
            before_m, after_m = (norm(into_rest(each, frame) - body.center_m) for each in (origin_m, sights.point_m))
            struck_s = before_m / search.air.sound_speed_m_s
            own_s = np.where(sights.side == 0, 0.0, struck_s + after_m / search.air.sound_speed_m_s)
            point, drift = _moving(search.tracing, search.sweep, body.obstacle, sights, own_s, struck_s)
        return cls(point, drift, _leans(search, sights, frame), sights.pose, view, lit)

    def over(self, point_m: Floats, chosen: Ints | slice = slice(None)) -> tuple[Floats, Floats]:
        """Distances of all ends, or of those chosen, from a point of the body or one each, and how much greater the
        chirp makes them seem."""
        offset = self.point_m[chosen] - point_m
        distance = norm(offset)
        return distance, dot(self.drift_m[chosen], offset) / np.maximum(distance, NOWHERE_M)

    def strays_m(self, body: Body) -> float:
        """Most by which the chirp makes half a path over a body longer or shorter re that over its centre."""
        away = norm(self.point_m - body.center_m)
        across = np.where(away > body.radius_m, np.sqrt(2.0) * body.radius_m / np.maximum(away, body.radius_m), 2.0)
        return float((norm(self.drift_m) * across).max(initial=0.0))


def _moving(
    tracing: Tracing, sweep: Sweep, obstacle: int, sights: Sights, own_s: Floats, struck_s: Floats
) -> tuple[Floats, Floats]:
    """(E, 3) images and how far they drift, seen from a body as sound strikes it.

    Mirrors are taken to stand still.

    Args:
        own_s: (E,) when sound leaves or reaches each image, after it leaves the speaker.
        struck_s: (E,) when it strikes the body, after the same.
    """
    where = sights.pose, sights.order, sights.sequence
    velocity = _mirrored(tracing, sweep.velocity_m_s[sights.pose, sights.side], where)
    of_body = np.full(len(sights), obstacle)

    def seen_at(instant_s: float) -> Floats:
        struck = tracing.time_s[sights.pose] + instant_s + struck_s
        frame = tracing.frames.of(of_body, sights.pose, struck)
        return into_rest(sights.point_m + velocity * (instant_s + own_s)[:, None], frame)

    before, after = (seen_at(sweep.passed_s + shift_s) for shift_s in (-NEARBY_S, NEARBY_S))
    return 0.5 * (before + after), (after - before) * (sweep.coupling_s / (2.0 * NEARBY_S))


def _mirrored(tracing: Tracing, vector: Floats, where: tuple[Ints, Ints, Ints]) -> Floats:
    """(E, 3) vectors as mirrors show them: (pose, order, sequence)."""
    tip, foot = (image_in(tracing.mirrors, each, *where) for each in (vector, 0.0 * vector))
    return tip - foot


def _leans(search: Search, sights: Sights, frame: Floats) -> Floats:
    """(E, 3) of the images of transducers as a body in frames (E, 4) sees them."""
    phone, tracing, where = search.phone, search.tracing, (sights.pose, sights.order, sights.sequence)
    own = np.array([each.lean for each in (phone.speaker, *phone.mics)])[sights.side]
    held = np.broadcast_to(tracing.pose.rotation.as_matrix(), (len(tracing.pose), 3, 3))[sights.pose]
    return rotated(_mirrored(tracing, np.einsum("eij,ej->ei", held, own), where), -frame[:, 3])
