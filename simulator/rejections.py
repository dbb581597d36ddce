"""The paths that were found and rejected: where they would have run, for which reason, at what level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import check_counts
from obstaclewatch.support.arrays import Floats, Ints, Strings
from simulator.paths import as_rows
from simulator.phone.phone import Phone
from simulator.scene.fidelity import Fidelity
from simulator.scene.pose import Pose
from simulator.scene.scene import Scene
from simulator.trace import names_of, still_search, traced
from simulator.world.candidates import concatenated, nothing
from simulator.world.prepared_scene import PreparedScene
from simulator.world.rejection_log import RejectionLog
from simulator.world.world import World


@dataclass(frozen=True, eq=False)
class Rejections:
    """R paths that were rejected, strongest first.

    Attributes:
        mask: (R,) reason, as in `Paths.rejected`.
        level_db: (R,) estimated level at 20 kHz, dB re the free field 1 m in front of the speaker. With air, materials
            and directivity where the geometry is whole; sequences that miss their patches have the level of their
            image (behind a mirror: one over its distance), edges an upper bound, both without them. -inf where shadows
            leave nothing.
        pose, mic, order: (R,) as in `Paths`.
        kind: (R,) as in `Paths`.
        obstacle: (R,) names of the obstacles that would have been met, joined by " > ".
        sequence: (R, N) reflectors, -1 padded, as in `Paths`.
        points_m: (R, N + 2, 3) source, reflection points, microphone (repeated), world frame. Where a patch is missed
            these are the crossings with its endless plane, on either side of the two ends; NaN where the unfolded way
            runs along the plane and there is none.
        counts: all that were rejected for each reason, listed or not.

    Example:
        >>> import trimesh
        >>> from simulator import Air, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_rejected
        >>> wall = trimesh.creation.box(bounds=[[2.0, -2.0, 0.0], [2.1, 2.0, 3.0]])
        >>> scene = Scene([Obstacle(wall, Material.rigid(), "wall")], Air.lossless(343.0))
        >>> pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))
        >>> rejected = trace_rejected(scene, Phone.named("ideal"), pose)
        >>> print(rejected[rejected.mic == 0].obstacle[0])
        wall
    """

    mask: Strings
    level_db: Floats
    pose: Ints
    mic: Ints
    order: Ints
    kind: Strings
    obstacle: Strings
    sequence: Ints
    points_m: Floats
    counts: Mapping[str, int]

    def __len__(self) -> int:
        return len(self.mask)

    def __getitem__(self, mask: ArrayLike) -> Rejections:
        """Those that a boolean mask, an index array or a slice selects."""
        index = as_rows(mask, len(self))
        return replace(self, **{f.name: getattr(self, f.name)[index] for f in fields(self) if f.name != "counts"})

    @property
    def left_out(self) -> int:
        """How many were rejected and are not listed here."""
        return sum(self.counts.values()) - len(self)

    def explain(self) -> str:
        """One line each, strongest first."""
        lines = [f"{len(self)} paths rejected, {self.left_out} more not listed"]
        for k in range(len(self)):
            points = self.points_m[k, 1 : self.order[k] + 1]
            way = " ".join("(" + ", ".join(f"{x:.2f}" for x in point) + ")" for point in points)
            lines.append(
                f"  {self.level_db[k]:.1f} dB, pose {self.pose[k]}, microphone {self.mic[k]}, {self.kind[k]}: "
                f"{self.obstacle[k]} at {way}: {self.mask[k]}"
            )
        return "\n".join(lines)


def trace_rejected(
    scene: Scene | PreparedScene, phone: Phone, pose: Pose, fidelity: Fidelity | None = None,
    time_s: ArrayLike = 0.0, limit: int = 1000,
) -> Rejections:  # fmt: skip
    """What `trace_paths` with the same arguments rejects, by the masks of that very run.

    Sequences of mirrors that the search never builds, because a patch or a body cannot be lit through the ones before
    it or lies beyond the range, are no contributions and not listed. A smooth surface has no mirror point where its
    own lies more than 0.3 m beside a mirror.

    Args:
        scene, phone, pose, fidelity, time_s: as for `trace_paths`.
        limit: the strongest so many are listed; `Rejections.left_out` counts the rest.

    Raises:
        ValueError: as `trace_paths`, or a limit below 1.

    Example:
        >>> import trimesh
        >>> from simulator import Air, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_rejected
        >>> wall = trimesh.creation.box(bounds=[[2.0, -2.0, 0.0], [2.1, 2.0, 3.0]])
        >>> scene = Scene([Obstacle(wall, Material.rigid(), "wall")], Air.lossless(343.0))
        >>> pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))
        >>> loudest = trace_rejected(scene, Phone.named("ideal"), pose, limit=5)
        >>> len(loudest), bool(loudest.level_db[0] >= loudest.level_db[-1])
        (5, True)
    """
    check_counts(1, limit=limit)
    search = still_search(scene, phone, pose, fidelity, time_s, RejectionLog(limit))
    traced(search)
    return _listed(search.tracing.world, search.log, max(search.max_order, 1))


def _listed(world: World, log: RejectionLog, width: int) -> Rejections:
    """The strongest of all groups, in one order."""
    amplitude = np.concatenate([np.zeros(0)] + [each for _, each, _ in log.entries])
    mask = np.repeat(
        np.array([reason for reason, _, _ in log.entries], dtype=np.str_),
        np.array([len(each) for _, each, _ in log.entries], dtype=np.int64),
    )
    rank = np.argsort(-amplitude, kind="stable")[: log.listed]
    found = concatenated([nothing(width)] + [found for _, _, found in log.entries])[rank]
    with np.errstate(divide="ignore"):  # nothing is left of some, such as of edges deep in the shadow of another
        level_db = 20.0 * np.log10(amplitude[rank])
    return Rejections(
        mask[rank], level_db, found.pose, found.mic, found.order, found.kind,
        names_of(world, found), found.sequence, found.points_m + world.origin_m, log.totals,
    )  # fmt: skip
