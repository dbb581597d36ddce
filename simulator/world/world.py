"""A scene made ready for tracing: reflectors, blockers and frames about an origin near the phone."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats, Ints
from simulator.scene.pose import Pose
from simulator.scene.scene import Obstacle
from simulator.surfaces.near_balls import Groups, grouped
from simulator.surfaces.opposite_edges import runs_to_opposite_m
from simulator.surfaces.patch_ends import PatchEnds, patch_ends
from simulator.surfaces.reflectors import MeshReading, PlanarPatches, SmoothSurface
from simulator.surfaces.surface_borders import Border, borders_of
from simulator.surfaces.wedges import Wedges
from simulator.world.frames import Frames, wedges_out_of_rest
from simulator.world.interactions import Numbering
from simulator.world.mirrors import Mirrors, Planes, any_ahead, any_facing, placed_mirrors
from simulator.world.rounded_parts import RoundedParts, Screens, corners_of
from simulator.world.shared_planes import planes_at_ends, planes_of, plates_of
from simulator.world.visibility import OFFSET, Blocker


@dataclass(frozen=True)
class World:
    """Everything that does not depend on where the phone is.

    Attributes:
        obstacles: the scene's, then the walker's body if there is one.
        carried: (O,) which of them go with the walker.
        origin_m: (3,) subtracted from all coordinates: far from the origin of a map, float64 keeps its micrometres.
        patches: planar patches of all obstacles.
        at_rest: the patches, to be asked which lies ahead of which.
        surfaces: smooth surfaces of all obstacles.
        wedges: sharp edges of all obstacles.
        skins: what the facets of each obstacle are, and its smooth surface, for sums over it.
        blockers: what casts shadows; those at rest in one, and those that move alike.
        rounded: the rounded facets of all obstacles; none without curved surfaces.
        sharp: as `blockers`, without the rounded facets.
    """

    obstacles: tuple[Obstacle, ...]
    carried: Flags
    origin_m: Floats
    patches: PlanarPatches
    at_rest: Planes
    surfaces: tuple[SmoothSurface, ...]
    wedges: Wedges
    skins: tuple[tuple[MeshReading, SmoothSurface | None], ...]
    blockers: tuple[Blocker, ...]
    rounded: RoundedParts
    sharp: tuple[Blocker, ...]

    @cached_property
    def clear_m(self) -> float:
        """How far clear of surfaces lines of sight begin and end, for Embree's float32."""
        return OFFSET * max((shadow.extent_m for shadow in self.blockers), default=1.0)

    @cached_property
    def sees_others(self) -> Flags:
        """(P,) patches that have another one ahead on some side."""
        return np.asarray(any_ahead(self.at_rest))  # type: ignore[call-arg]

    @cached_property
    def any_facing(self) -> bool:
        """Whether some patch may follow another one."""
        return bool(any_facing(self.at_rest))  # type: ignore[call-arg]

    @cached_property
    def borders(self) -> tuple[tuple[Border, ...], ...]:
        """Where each smooth surface ends or bends otherwise: asked for only where integrals may take over from rays."""
        return tuple(borders_of(self.skins[surface.obstacle][0], surface) for surface in self.surfaces)

    @cached_property
    def patch_ends(self) -> PatchEnds:
        """Where the patches end, as `surfaces.patch_ends` has it."""
        return patch_ends(self.wedges, [reading for reading, _ in self.skins], self.patches.obstacle)

    @cached_property
    def blunt(self) -> Flags:
        """(P,) patches that end at creases with smooth surfaces alone, such as the face of a wheel."""
        ends = np.diff(self.patch_ends.first) > 0
        flags: Flags = ends & ~np.isin(np.arange(len(self.patches)), self.wedges.patch)
        return flags

    @cached_property
    def _blunt_reflectors(self) -> Flags:
        """(R + 1,) whether every reflector is a blunt patch; not what comes at the end."""
        return np.pad(self.blunt, (0, len(self._owner) - len(self.blunt)))

    def is_blunt(self, number: Ints) -> Flags:
        """Whether reflectors, by their numbers, are blunt patches; not for -1."""
        return self._blunt_reflectors[number]

    @cached_property
    def blunt_screens(self) -> Screens:
        """The blunt patches as screens at rest."""
        readings = [reading for reading, _ in self.skins]
        first = np.cumsum([0, *(reading.planes for reading in readings)])
        obstacle = self.patches.obstacle[self.blunt]
        own = np.flatnonzero(self.blunt) - first[obstacle]
        return Screens.of([corners_of(readings[i], readings[i].patch == k) for i, k in zip(obstacle, own, strict=True)])

    @cached_property
    def planes(self) -> Ints:
        """(P,) planes of the patches, as `shared_planes.planes_of` has them."""
        return planes_of(self.patches)

    @cached_property
    def planes_at_ends(self) -> Ints:
        """(W, 2, M) planes in which the sharp edges end, as `shared_planes.planes_at_ends` has them."""
        return planes_at_ends(self.wedges, self.patches, self.planes)

    @cached_property
    def plates(self) -> Ints:
        """(L,) planes of the patches or of thin plates, as `shared_planes.plates_of` has them."""
        return plates_of(self.wedges, self.patches, self.planes)

    @cached_property
    def runs_to_opposite_m(self) -> Floats:
        """(W, 2) how far the faces of the sharp edges run, as `surfaces.opposite_edges` has it."""
        return runs_to_opposite_m(self.wedges)

    @cached_property
    def edge_groups(self) -> Groups:
        """The sharp edges in groups of neighbours, at rest."""
        middle = 0.5 * (self.wedges.start_m + self.wedges.end_m)
        return grouped(middle, 0.5 * self.wedges.length_m, self.wedges.obstacle)

    @cached_property
    def numbering(self) -> Numbering:
        """The numbers of all reflectors."""
        counts = len(self.patches), len(self.surfaces), len(self.wedges)
        return Numbering(np.cumsum([0, *counts]))

    @cached_property
    def _owner(self) -> Ints:
        """(R + 1,) obstacle of every reflector, and -1 at the end."""
        surfaces = np.array([s.obstacle for s in self.surfaces], dtype=np.int64)
        bodies = np.arange(len(self.obstacles))
        owners = [self.patches.obstacle, surfaces, self.wedges.obstacle, bodies, np.array([-1])]
        return np.concatenate(owners).astype(np.int64)

    def obstacle_of(self, number: Ints) -> Ints:
        """The obstacles of reflectors by their numbers; -1 for -1."""
        return self._owner[number]

    @cached_property
    def _own_parts(self) -> Flags:
        """(R + 1, P) whether every reflector is a plane or an edge of the piece that a rounded part is of."""
        own = self.rounded.own_patch.T
        nothing = np.zeros((len(self.surfaces), own.shape[1]), dtype=bool)
        bodies = np.zeros((len(self.obstacles) + 1, own.shape[1]), dtype=bool)
        return np.concatenate([own[: len(self.patches)], nothing, own[self.wedges.patch].any(axis=1), bodies])

    def parts_met(self, number: Ints) -> Flags:
        """(C, P) whether reflectors (C, N) are planes or edges of the pieces that rounded parts are of."""
        return np.logical_or.reduce(self._own_parts[number], axis=1)


@dataclass(frozen=True)
class Tracing:
    """One call's poses in a prepared world.

    Attributes:
        world: reflectors and blockers.
        frames: where the obstacles are at any instant.
        pose: N poses about the world's origin.
        time_s: (N,) when they are taken.
        source_m, mics_m: (N, 3) speaker and (N, 2, 3) microphones.
        placed: (N, O, 4) frames of the obstacles at those instants.
    """

    world: World
    frames: Frames
    pose: Pose
    time_s: Floats
    source_m: Floats
    mics_m: Floats
    placed: Floats

    @cached_property
    def transducers_m(self) -> Floats:
        """(N, 3, 3) speaker and microphones."""
        return np.concatenate([self.source_m[:, None], self.mics_m], axis=1)

    @cached_property
    def middle_m(self) -> Floats:
        """(N, 3) middle of speaker and microphones: the same whichever of them speaks."""
        return (self.source_m + self.mics_m.sum(axis=1)) / 3.0

    @cached_property
    def mirrors(self) -> Mirrors:
        """The patches where they stand at each pose."""
        return placed_mirrors(self.world.patches, self.world.at_rest, self.placed)

    @cached_property
    def wedges(self) -> Wedges:
        """(N W,) the sharp edges where they stand at each pose, pose by pose."""
        rest = self.world.wedges
        every = np.tile(np.arange(len(rest)), len(self.pose))
        return wedges_out_of_rest(rest[every], self.placed[:, rest.obstacle].reshape(-1, 4))
