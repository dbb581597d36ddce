"""What came back: every path with its delay and gain, by which mechanism, off which obstacle, and what was refused."""

from __future__ import annotations

import reprlib
from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from html import escape
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from obstaclewatch.support.argument_types import as_finite, check_types
from obstaclewatch.support.arrays import Complexes, Floats, Ints, Strings
from obstaclewatch.support.words import counted
from simulator.phone.phone import Phone
from simulator.waves import band
from simulator.world.rejection_log import Choice

REPR_ROWS, HTML_ROWS = 12, 40
_WIDTHS = (4, 3, 9, 9, 8, 5, 0)


@dataclass(frozen=True, eq=False, repr=False)
class Paths:
    """Paths between the speaker and the two microphones, for one pose or many.

    Attributes:
        delay_s: (P,) travel time.
        band_gain: (P, K) complex gain at the Chebyshev nodes of 15-25 kHz without the travel phase: the path
            contributes gain e^{-j 2 pi f delay}. Pressure relative to the free field 1 m in front of the speaker; a
            lossless mirror path has 1 / length. On a walk, cells of bodies have at each frequency what they return as
            the chirp passes it.
        mic: (P,) microphone, 0 top or 1 bottom.
        pose: (P,) index of the pose.
        order: (P,) number of reflections, an edge counting as one; 0 is the direct sound.
        kind: (P,) "direct", "specular", "curved", "edge", "kirchhoff", or "mixed" (one curved surface, edge or body
            among mirrors, two curved surfaces, or several edges of a thin panel). An edge has a row for its apex and
            one for each end, and a body by Kirchhoff's integral one for each cell, which add up.
        obstacle: (P,) names of the obstacles in the order met, joined by " > "; "" for the direct sound through
            the air, "case" for that through the phone's case.
        sequence: (P, N) reflectors in the order met, -1 padded: planar patches, then smooth surfaces, then edges, then
            bodies. N is the fidelity's `max_order`, or more if a path meets more edges of a panel.
        points_m: (P, N + 2, 3) source, reflection points, then the microphone (repeated), world frame.
        face: (P, N) facet of the smooth surface met at each reflection, -1 where none is.
        uv: (P, N, 2) position within that facet.
        phone: the phone, for its frequency responses.
        poses: number of poses traced.
        rejected: how many candidates were rejected for each reason.
        left_out: what was not modelled, a line each.
        choices: the mechanism taken for each obstacle whose rays may be wrong, and the errors estimated.

    Example:
        >>> import trimesh
        >>> from simulator import Air, Material, Obstacle, Phone, Pose, Scene, held_rotation, trace_paths
        >>> wall = trimesh.creation.box(bounds=[[2.0, -2.0, 0.0], [2.1, 2.0, 3.0]])
        >>> scene = Scene([Obstacle(wall, Material.rigid(), "wall")], Air.lossless(343.0))
        >>> pose = Pose([0.0, 0.0, 1.3], held_rotation(heading_rad=0.0))
        >>> paths = trace_paths(scene, Phone.named("ideal"), pose)
        >>> echo = paths[(paths.kind == "specular") & (paths.mic == 0)]
        >>> length_m = 343.0 * echo.delay_s
        >>> print(echo.obstacle[0], length_m.round(3), (length_m * abs(echo.gain)).round(6))
        wall [3.88] [1.]
        >>> paths.transfer_function([18e3, 20e3, 22e3]).shape
        (2, 3)
        >>> echo
        Paths(1 at 1 pose)
          pose  mic  delay, ms  level, dB      kind  order  off
             0    0     11.312      -11.8  specular      1  wall
    """

    delay_s: Floats
    band_gain: Complexes
    mic: Ints
    pose: Ints
    order: Ints
    kind: Strings
    obstacle: Strings
    sequence: Ints
    points_m: Floats
    face: Ints
    uv: Floats
    phone: Phone
    poses: int
    rejected: Mapping[str, int]
    left_out: tuple[str, ...]
    choices: tuple[Choice, ...] = ()

    def __len__(self) -> int:
        return len(self.delay_s)

    def __repr__(self) -> str:
        """The strongest paths, a line each; `explain` says what became of the others."""
        rows = self._strongest(REPR_ROWS)
        lines = [f"Paths({len(self)} at {self._poses_named()})"]
        lines += [f"  {'  '.join(cell.rjust(width) for cell, width in zip(row, _WIDTHS, strict=True))}" for row in rows]
        return "\n".join([*lines, *([f"  and {len(self) - REPR_ROWS} weaker ones"] if len(self) > REPR_ROWS else [])])

    def _poses_named(self) -> str:
        return f"{self.poses} pose{'s' * (self.poses != 1)}"

    def _repr_html_(self) -> str:
        """The strongest paths as a table, for notebooks."""
        head, *rows = self._strongest(HTML_ROWS)
        cells = [f"<th>{'</th><th>'.join(head)}</th>"] + [
            f"<td>{'</td><td>'.join(map(escape, row))}</td>" for row in rows
        ]
        more = f"<p>and {len(self) - HTML_ROWS} weaker ones</p>" if len(self) > HTML_ROWS else ""
        return f"<table><tr>{'</tr><tr>'.join(cells)}</tr></table>{more}"

    def _strongest(self, count: int) -> list[tuple[str, ...]]:
        """Rows of text about the strongest paths, under a row of headings."""
        level_db = self._level_db
        return [
            ("pose", "mic", "delay, ms", "level, dB", "kind", "order", "off"),
            *(
                (str(self.pose[k]), str(self.mic[k]), f"{1e3 * self.delay_s[k]:.3f}", f"{level_db[k]:.1f}",
                 str(self.kind[k]), str(self.order[k]), str(self.obstacle[k]))
                for k in np.argsort(-level_db, kind="stable")[:count]
            ),
        ]  # fmt: skip

    def __getitem__(self, mask: ArrayLike) -> Paths:
        """The paths that a boolean mask, an index array or a slice selects.

        Raises:
            ValueError: anything else, such as a single number.
        """
        index = as_rows(mask, len(self))
        rows: dict[str, Any] = {f.name: getattr(self, f.name)[index] for f in fields(self) if f.name not in _SHARED}
        return replace(self, **rows)

    def __add__(self, other: Paths) -> Paths:
        """These paths, then the others.

        Raises:
            ValueError: no paths, or of another phone object, number of poses, `band_points` or width of `sequence`.
        """
        check_types(other=(other, Paths))
        if other.phone is not self.phone:
            raise ValueError(f"paths to be added must be of one phone object, got {self.phone} and {other.phone}")
        sizes = [(each.poses, each.band_gain.shape[1], each.sequence.shape[1]) for each in (self, other)]
        if sizes[0] != sizes[1]:
            raise ValueError(
                f"paths to be added must have as many poses, band points and columns of sequence, got {sizes[0]} and "
                f"{sizes[1]}"
            )
        rows: dict[str, Any] = {
            f.name: np.concatenate([getattr(self, f.name), getattr(other, f.name)])
            for f in fields(self) if f.name not in _SHARED
        }  # fmt: skip
        return replace(self, **rows)

    @cached_property
    def gain(self) -> Complexes:
        """(P,) complex gain at 20 kHz."""
        return self.gain_at(band.REFERENCE_HZ)[:, 0]

    @property
    def _level_db(self) -> Floats:
        """(P,) level at 20 kHz."""
        return 20.0 * np.log10(np.maximum(np.abs(self.gain), 1e-300))

    def obstacles_met(self) -> list[tuple[str, ...]]:
        """Names of the obstacles that each path meets, in turn; () for the direct sound, ("case",) through the case."""
        names, which = np.unique(self.obstacle, return_inverse=True)
        met = [tuple(name.split(" > ")) if name else () for name in names.tolist()]
        return [met[k] for k in which.tolist()]

    def gain_at(self, frequency_hz: ArrayLike) -> Complexes:
        """(P, F) gains at any frequency; held at their end values outside 15-25 kHz."""
        return band.evaluate(band.coefficients(self.band_gain), _frequencies(frequency_hz))

    def transfer_function(self, frequency_hz: ArrayLike) -> Complexes:
        """Pressure at each microphone, responses included, over the free-field pressure 1 m in front of the speaker.

        Args:
            frequency_hz: (F,) frequencies; gains are held at their end values outside 15-25 kHz.

        Returns:
            (2, F) for a single pose, (N, 2, F) for N poses.
        """
        frequency = _frequencies(frequency_hz)
        terms = self.gain_at(frequency) * np.exp(-2j * np.pi * frequency * self.delay_s[:, None])
        total = np.zeros((self.poses, 2, len(frequency)), dtype=np.complex128)
        np.add.at(total, (self.pose, self.mic), terms)
        responses = np.stack([self.phone.speaker.response(frequency) * m.response(frequency) for m in self.phone.mics])
        total *= responses
        return total[0] if self.poses == 1 else total

    def explain(self) -> str:
        """What was modelled, what was rejected and why, and what was left out, in plain lines."""
        count = counted(len(self), "path")
        lines = [f"{count} at {self._poses_named()} and 2 microphones; order counts reflections, levels are re 1 m"]
        for kind in np.unique(self.kind):
            rows = self.kind == kind
            level = self._level_db[rows].max()
            lines.append(f"  {kind}: {int(rows.sum())}, order up to {self.order[rows].max()}, strongest {level:.1f} dB")
        lines += [f"  rejected, {name}: {number}" for name, number in self.rejected.items() if number]
        lines += [f"  {choice}" for choice in self.choices]
        lines += [f"  left out: {line}" for line in self.left_out]
        return "\n".join(lines)


def _frequencies(frequency_hz: ArrayLike) -> Floats:
    """(F,)."""
    frequency = np.atleast_1d(as_finite("frequency_hz", frequency_hz))
    if frequency.ndim != 1:
        raise ValueError(f"frequency_hz must have shape () or (F,), got {frequency.shape}")
    return frequency


def as_rows(chosen: ArrayLike | slice, count: int) -> Any:
    """A mask, an index array or a slice as numpy takes it: what it selects of columns of `count` rows are columns.

    Raises:
        ValueError: anything else, such as a single number, or a mask of another length.
    """
    if isinstance(chosen, slice):
        return chosen
    index = np.asarray(chosen)
    if index.ndim == 1 and index.size == 0 and index.dtype != bool:
        return index.astype(np.int64)
    if index.ndim != 1 or index.dtype.kind not in "biu":
        raise ValueError(f"paths must be selected by a mask, an index array or a slice, got {reprlib.repr(chosen)}")
    if index.dtype == bool and len(index) != count:
        raise ValueError(f"a mask must have one truth value for each of {count} paths, got {len(index)}")
    return index


_SHARED = ("phone", "poses", "rejected", "left_out", "choices")
