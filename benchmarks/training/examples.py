"""Examples to learn from: the evidence of every beep of every reception, and whether the walk collides."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from joblib import Parallel, delayed
from numpy.typing import NDArray

from benchmarks.cells.fingerprint import source_fingerprint
from benchmarks.cells.memory import return_freed_memory
from benchmarks.cells.spec import Cell
from benchmarks.plan import unknowns
from benchmarks.training import walks
from benchmarks.training.walks import Seen, Walk, recorded, seen_at_beeps
from obstaclewatch.support.arrays import Flags, Floats, Halves, Ints
from obstaclewatch.support.rows import Rows
from obstaclewatch.support.whole_file import whole_file
from obstaclewatch.tracking.approach_picture import SHAPE
from obstaclewatch.tracking.detector import FARTHEST_M

APART = 2**32
"""Between numbers of walks of two parts, which are seeds below it; whole folds, so that equal seeds share one."""
FOLDS = 4
"""Parts of the walks, each of which one network does not learn from; walks of one seed are in one part."""
SETTLING_BEEPS = 8
"""First beeps, of which nothing is learned."""
PAST_M = -0.02
"""Distance left to which collisions are learned: a touch more than contact."""


@dataclass(frozen=True)
class Examples(Rows):
    """n beeps.

    Attributes:
        walk, reception: (n,) the walk, by the seed it is drawn from, and the number of its reception.
        collides: (n,) whether the walk is a collision.
        left_m: (n,) distance left to contact; NaN without one.
        evidence: (n, F) see `Evidence`.
        pictures: (n, *SHAPE) see `approach_picture`; half precision, as a hundred thousand of them are kept.
    """

    walk: Ints
    reception: Ints
    collides: Flags
    left_m: Floats
    evidence: Floats
    pictures: Halves

    @property
    def without_pictures(self) -> Examples:
        """The same beeps with pictures of no size, for those who look at the rest."""
        return replace(self, pictures=self.pictures[:, :0])

    @property
    def used(self) -> Flags:
        """(n,) beeps to learn from: of collisions those with an alert's distance left, of other walks all."""
        near = (self.left_m <= FARTHEST_M) & (self.left_m > PAST_M)
        return np.where(self.collides, near, True)

    @property
    def fold(self) -> Ints:
        """(n,) which of the folds each walk is in."""
        found: Ints = self.walk % FOLDS
        return found

    @property
    def received(self) -> Ints:
        """(n,) a number for each walk and reception."""
        found: Ints = 1000 * self.walk + self.reception
        return found

    def weights(self) -> Floats:
        """(n,) by which beeps count: every reception as much as every other of its outcome, both outcomes the same."""
        _, which, count = np.unique(self.received, return_inverse=True, return_counts=True)
        weight = 1.0 / count[which]
        share = np.where(self.collides, weight[self.collides].sum(), weight[~self.collides].sum())
        found: Floats = 0.5 * weight / share
        return found


def examples_of(parts: Sequence[Sequence[Cell]], receptions: int, jobs: int, folder: Path) -> Examples:
    """Examples of walks in several parts, whose numbers lie `APART`.

    Each walk's are kept in a file, so that what is interrupted goes on from there. All pictures stay on disk, in one
    file more: those of 10,000 walks take 18 GB.
    """
    paths = walk_files(parts, receptions, jobs, folder)
    return _gathered(paths, numbered(parts), folder / "pictures.npy")


def numbered(parts: Sequence[Sequence[Cell]]) -> Ints:
    """Numbers of the walks of all parts."""
    return np.array([cell.seed + APART * k for k, part in enumerate(parts) for cell in part], dtype=np.int64)


def walk_files(parts: Sequence[Sequence[Cell]], receptions: int, jobs: int, folder: Path) -> list[Path]:
    """The files of all walks, which are made if they are not there: what decisions and bearings are learned from."""
    folder.mkdir(parents=True, exist_ok=True)
    found: list[Path] = Parallel(n_jobs=jobs)(
        delayed(_kept)(cell, receptions, folder) for part in parts for cell in part
    )
    return found


def _kept(cell: Cell, receptions: int, folder: Path) -> Path:
    """The file of a walk's examples, which is made if it is not there: of this walk, by this version of the source."""
    path = folder / f"{cell.digest(_sources())[:16]}-{receptions}.npz"
    if not path.exists():
        walk = recorded(cell)
        seen = [seen_at_beeps(walk, reception) for reception in range(receptions)]
        kept = Examples.joined([_of_reception(walk, each, reception) for reception, each in enumerate(seen)])
        arrays: dict[str, Any] = {name: getattr(kept, name) for name in Examples.__annotations__}
        arrays |= {
            "bearing_reception": np.repeat(np.arange(receptions), [len(each.beep) for each in seen]),
            "bearing_evidence": np.concatenate([each.bearing_evidence for each in seen]),
            "bearing_true_rad": np.concatenate([walk.truth.bearing_rad[each.beep] for each in seen]),
        }
        with whole_file(path, lasting=False) as partial, partial.open("wb") as file:
            np.savez(file, **arrays)
        return_freed_memory()
    return path


@cache
def _sources() -> str:
    """Digest of all that decides an example's numbers."""
    own = (Path(__file__), Path(walks.__file__), Path(unknowns.__file__))
    return hashlib.sha256(b"".join([source_fingerprint().encode(), *(each.read_bytes() for each in own)])).hexdigest()


def _gathered(paths: Sequence[Path], numbers: Ints, pictures_path: Path) -> Examples:
    """The examples of all files, under the numbers of their walks, with their pictures in a file of that name."""
    told: dict[str, list[NDArray]] = {name: [] for name in Examples.__annotations__ if name not in ("walk", "pictures")}
    for path in paths:
        with np.load(path) as stored:
            for name, parts in told.items():
                parts.append(stored[name])
    size = [len(part) for part in told["reception"]]
    with whole_file(pictures_path, lasting=False) as partial:
        pictures = np.lib.format.open_memmap(partial, "w+", np.dtype(np.float16), (sum(size), *SHAPE))
        for path, last, count in zip(paths, np.cumsum(size), size, strict=True):
            with np.load(path) as stored:
                pictures[last - count : last] = stored["pictures"]
    columns = {name: np.concatenate(parts) for name, parts in told.items()}
    columns["walk"] = np.repeat(numbers, size)
    return Examples(**columns, pictures=np.load(pictures_path, mmap_mode="r"))


def _of_reception(walk: Walk, seen: Seen, reception: int) -> Examples:
    rows = slice(SETTLING_BEEPS, None)
    count = len(seen.evidence[rows])
    numbers = np.zeros(count, dtype=np.int64), np.full(count, reception, dtype=np.int64)
    collides = np.full(count, walk.collides)
    return Examples(*numbers, collides, walk.left_m[rows], seen.evidence[rows], seen.pictures[rows])
