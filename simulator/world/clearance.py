"""Whether the phone has room: no transducer inside a body, nothing between speaker and microphones or driven through.

What the scene says otherwise is refused by name: image sources, rays and integrals would all answer, each wrongly.
The walker's own body goes with the phone and is asked for its winding alone.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import trimesh

from obstaclewatch.support.arrays import Floats
from simulator.world.frames import into_rest
from simulator.world.visibility import Blocker
from simulator.world.world import Tracing, World

ON_FACE_M = 1e-5  # a transducer no deeper than this in a body lies on its face
LONGEST_PHONE_M = 0.5  # speaker and microphones farther apart are no phone: there the direct sound may be hidden
TRANSDUCERS = ("the speaker", "microphone 0", "microphone 1")


def check_poses(tracing: Tracing) -> None:
    """Refuse poses in which the phone has no room.

    Raises:
        ValueError: a transducer is inside a closed body or outside of a room, or an obstacle stands between the speaker
            and a microphone.
    """
    points = tracing.transducers_m
    for index in range(len(tracing.world.obstacles)):
        _check_inside(tracing, index, points)
    for mic in range(2):
        ends = points[:, 0], points[:, 1 + mic]
        if np.linalg.norm(ends[1][0] - ends[0][0]) <= LONGEST_PHONE_M:
            _check_between(tracing, mic, *ends)


def check_passage(tracing: Tracing, time_s: Floats, points_m: Floats) -> None:
    """Refuse walks on which an obstacle and the phone pass through each other.

    Args:
        tracing: the walk's poses in their world.
        time_s: (M,) instants in turn, between which the phone moves next to straight.
        points_m: (M, 3, 3) speaker and microphones at those instants, about the world's origin.

    Raises:
        ValueError: a transducer has crossed a surface from one instant to the next.
    """
    drift = tracing.frames.velocity_m_s
    for shadow in _shadows(tracing):
        local = points_m - time_s[:, None, None] * drift[shadow.obstacle]
        start, end = local[:-1].reshape(-1, 3), local[1:].reshape(-1, 3)
        hit = shadow.blocks(start, end)
        if hit.any():
            row = int(np.argmax(hit))
            instant, which = divmod(row, 3)
            name = _struck(tracing.world, shadow, start[[row]], end[[row]])
            raise ValueError(
                f"phone and obstacles must not pass through each other, got '{name}' through {TRANSDUCERS[which]} "
                f"between {time_s[instant]:.3f} and {time_s[instant + 1]:.3f} s"
            )


def _shadows(tracing: Tracing) -> Iterator[Blocker]:
    return (shadow for shadow in tracing.world.blockers if not tracing.frames.carried[shadow.obstacle])


def _check_between(tracing: Tracing, mic: int, speaker_m: Floats, mic_m: Floats) -> None:
    """Refuse an obstacle between the speaker and a microphone, (N, 3) each."""
    for shadow in _shadows(tracing):
        placed = tracing.placed[:, shadow.obstacle]
        hit = shadow.blocks_from(speaker_m, mic_m, placed, np.arange(len(placed)), np.ones(len(placed), dtype=bool))
        if hit.any():
            n = int(np.argmax(hit))
            name = _struck(tracing.world, shadow, *(into_rest(end[[n]], placed[[n]]) for end in (speaker_m, mic_m)))
            raise ValueError(
                f"nothing may stand between speaker and microphones, got '{name}' between the speaker and microphone "
                f"{mic} {_when(tracing.time_s, n)}"
            )


def _check_inside(tracing: Tracing, index: int, points_m: Floats) -> None:
    """Refuse a transducer inside an obstacle: asked of those in the box round a closed one, one by one.

    A mesh wound inwards is a room. From outside of it nothing would echo. The walker's body holds the phone where it
    says.
    """
    body = tracing.world.skins[index][0].solid
    if body is None:
        return
    local = into_rest(points_m, tracing.placed[:, None, index])
    if body.volume >= 0.0:
        _check_parts(tracing, index, local)
        if tracing.frames.carried[index]:
            return
    low, high = body.bounds
    near = ((local > low + ON_FACE_M) & (local < high - ON_FACE_M)).all(axis=2)
    inside, room = near.copy(), body.volume < 0.0
    if near.any():
        inside[near] = body.contains(local[near])
    for n, which in np.argwhere(inside != room):
        if trimesh.proximity.closest_point(body, local[n, [which]])[1][0] <= ON_FACE_M:
            continue
        what, name, when = TRANSDUCERS[which], tracing.world.obstacles[index].name, _when(tracing.time_s, n)
        if room:
            raise ValueError(
                f"the phone must be inside of a body that is wound inwards, as a room is, got {what} outside of "
                f"'{name}' {when}; its mesh.invert() winds it outwards"
            )
        raise ValueError(f"the phone must be outside of all closed bodies, got {what} inside '{name}' {when}")


def _check_parts(tracing: Tracing, index: int, local_m: Floats) -> None:
    """Refuse a part of an obstacle that is wound inwards, unless (N, 3, 3) transducers are in the box round it."""
    for low, high in tracing.world.skins[index][0].rooms_m:
        outside = ((local_m < low - ON_FACE_M) | (local_m > high + ON_FACE_M)).any(axis=2)
        for n, which in np.argwhere(outside)[:1]:
            raise ValueError(
                f"the phone must be inside of a part that is wound inwards, as a room is, got {TRANSDUCERS[which]} "
                f"outside of one of '{tracing.world.obstacles[index].name}' {_when(tracing.time_s, n)}; "
                "trimesh.repair.fix_inversion(mesh, multibody=True) winds all parts outwards"
            )


def _struck(world: World, shadow: Blocker, start_m: Floats, end_m: Floats) -> str:
    """Name of the first obstacle of a blocker that stands between two points (1, 3) of its rest frame."""
    return world.obstacles[shadow.owner[shadow.first_met(start_m, end_m)[0]]].name


def _when(time_s: Floats, n: int) -> str:
    return f"at pose {n} ({time_s[n]:.3f} s)"
