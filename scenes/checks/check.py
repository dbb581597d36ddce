"""Is a scene fit to be simulated? Meshes, their places, and the phone's path through them.

An error says that the simulation would be wrong: a closed body whose normals point inwards returns no echo, a phone
inside an obstacle records nothing real. A warning says what is probably not meant.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import combinations
from typing import Literal

import numpy as np
import trimesh

from obstaclewatch.support.vectors import dot, norm
from obstaclewatch.support.words import counted
from scenes.checks.mesh_overlap import inside, overlap_depth, winding_number
from scenes.files.schema import UNITS_M
from scenes.obstacles.solids import shifted
from scenes.truth.truth import NOT_IN_THE_WAY, contact
from simulator.meshes.clean_meshes import cleaned
from simulator.meshes.common_planes import on_common_planes
from simulator.phone.phone import Phone
from simulator.scene.pose import Walk
from simulator.scene.scene import Obstacle, Scene, welded, with_area
from simulator.world.prepared_scene import parts_of

SMALLEST_M, LARGEST_M = 0.03, 60.0
"""Outside these an obstacle's greatest extent is not that of a thing in a street: its unit is probably another."""

TOUCH_M = 1e-4
"""Overlaps and gaps up to this count as touching."""

AFLOAT_M = 0.02
"""Something this far above the ground hangs in the air: soles and tyres are meshed within this."""

BESIDE_GROUND_M = 0.02
GROUND_M2 = 10.0
"""A plane of more is ground or wall to what stands by it."""

WALK_STEP_S = 0.02
MEETING_STEP_S = 0.25


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong.

    Attributes:
        severity: "error" or "warning".
        obstacle: name of what it is about; "phone" or "scene" for the rest.
        rule: short name of the rule.
        message: what was found, with its numbers.
    """

    severity: Literal["error", "warning"]
    obstacle: str
    rule: str
    message: str


def check_scene(scene: Scene, walk: Walk | None = None, phone: Phone | None = None) -> list[Finding]:
    """All findings: obstacle by obstacle, then between them, then along the walk.

    Args:
        scene: to check; overlaps of what moves are looked for every 0.25 s of the walk, at time 0 without one.
        walk: the phone's path, followed from 0 to its duration every 20 ms; None leaves it out.
        phone: its transducers; None takes the phone's origin alone.
    """
    found = [finding for obstacle in scene.obstacles for finding in _mesh_findings(obstacle)]
    found += _ground_findings(scene)
    found += _overlap_findings(scene, 0.0 if walk is None else walk.duration_s)
    if walk is not None:
        found += _walk_findings(scene, walk, phone)
    return found


def _mesh_findings(obstacle: Obstacle) -> Iterator[Finding]:
    mesh, name = obstacle.mesh, obstacle.name
    if obstacle.category not in NOT_IN_THE_WAY:
        yield from _scale_findings(name, mesh)
    joined = welded(mesh)
    yield from _triangle_findings(name, joined)
    if obstacle.category not in NOT_IN_THE_WAY:
        shell, closed = cleaned(mesh)  # bodies that touch along an edge are closed each by itself
        yield from _shell_findings(name, shell if closed else joined)
        if closed:
            yield from _winding_findings(name, joined, shell)
    yield from _uneven_findings(obstacle)
    yield from _merged_findings(obstacle)


def _scale_findings(name: str, mesh: trimesh.Trimesh) -> Iterator[Finding]:
    size = float(mesh.extents.max())
    if SMALLEST_M <= size <= LARGEST_M:
        return
    fits = [unit for unit, scale in UNITS_M.items() if unit != "m" and 0.2 <= size * scale <= 20.0]
    fits += [unit for unit, scale in UNITS_M.items() if unit != "m" and 0.2 <= size / scale <= 20.0]
    hint = f"; read in another of {', '.join(dict.fromkeys(fits))} it would be of usual size" if fits else ""
    yield Finding("warning", name, "scale", f"is {size:.4g} m large, outside {SMALLEST_M}-{LARGEST_M:g} m{hint}")


def _triangle_findings(name: str, mesh: trimesh.Trimesh) -> Iterator[Finding]:
    flat = int((~with_area(mesh)).sum())
    if flat:
        yield Finding("warning", name, "slivers", f"has {flat} triangles without area, which are left out")
    twice = int((~mesh.unique_faces()).sum())
    if twice:
        yield Finding("warning", name, "doubles", f"has {twice} triangles on the same corners as others")


def _shell_findings(name: str, mesh: trimesh.Trimesh) -> Iterator[Finding]:
    if not mesh.is_watertight:
        used = np.bincount(mesh.edges_unique_inverse)
        open_, many = int((used == 1).sum()), int((used > 2).sum())
        of_more = "of more than two triangles"
        parts = [counted(open_, "open edge")] * (open_ > 0)
        parts += [counted(many, f"edge {of_more}", f"edges {of_more}")] * (many > 0)
        message = f"is not watertight ({', '.join(parts)}): both sides of its faces reflect"
        yield Finding("warning", name, "open", message)
    if not mesh.is_winding_consistent:
        message = "has neighbouring triangles wound against each other: both sides of its faces reflect"
        yield Finding("warning", name, "winding", message)
    elif mesh.is_watertight:
        inverted = _inverted(mesh.split(only_watertight=False))
        if inverted:
            message = f"has normals inwards on {inverted} of its closed bodies, which return no echo; flip their faces"
            yield Finding("error", name, "normals", message)


def _winding_findings(name: str, joined: trimesh.Trimesh, shell: trimesh.Trimesh) -> Iterator[Finding]:
    """Triangles that are wound the other way in what is read of a mesh."""
    normal = joined.triangles_cross[with_area(joined)]
    if len(normal) == len(shell.faces):
        over = int((dot(normal, shell.triangles_cross) < 0.0).sum())
        if over:
            message = f"has {counted(over, 'triangle')} wound against the others, read the other way round"
            yield Finding("warning", name, "winding", message)


def _uneven_findings(obstacle: Obstacle) -> Iterator[Finding]:
    mesh, _ = cleaned(obstacle.mesh)
    level = on_common_planes(mesh, obstacle.surface)
    if level is not mesh:
        moved_m = norm(level.vertices - mesh.vertices).max()
        message = (
            "has flat or flush faces that are uneven, as rounded coordinates leave them: levelling them moves "
            f"corners by up to {1e3 * moved_m:.2g} mm"
        )
        yield Finding("warning", obstacle.name, "uneven", message)


def _merged_findings(obstacle: Obstacle) -> Iterator[Finding]:
    reading = parts_of(obstacle, np.zeros(3)).reading
    plane_m2 = np.bincount(reading.patch + 1, np.asarray(reading.mesh.area_faces))  # 0 for what is no plane
    plane_m2[0] = 0.0
    large = plane_m2[reading.patch + 1] > GROUND_M2
    bodies = np.setdiff1d(reading.piece[reading.curved], reading.piece[large])
    if large.any() and len(bodies):
        message = (
            f"holds planes of up to {plane_m2.max():.3g} m2 and {len(bodies)} rounded bodies in one mesh: echoes over "
            "both are left out; `Obstacle.split()`, or `split: true` in a scene file, makes an obstacle of each part"
        )
        yield Finding("warning", obstacle.name, "merged", message)


def _inverted(bodies: list[trimesh.Trimesh]) -> int:
    """How many bodies point inwards, but for those that are cavities in others."""
    count = 0
    for k, body in enumerate(bodies):
        if body.volume < 0.0:
            others = [np.asarray(other.triangles) for other in bodies[:k] + bodies[k + 1 :]]
            around = np.concatenate([*others, np.zeros((0, 3, 3))])
            count += float(winding_number(around, np.asarray(body.vertices[:1]))[0]) < 0.5
    return count


def _ground_findings(scene: Scene) -> Iterator[Finding]:
    level = _ground_level(scene)
    if level is None:
        yield Finding("warning", "scene", "ground", "has no ground: its echo and all corners with it are missing")
        return
    for obstacle in _things(scene):
        bottom = float(obstacle.mesh.bounds[0, 2]) - level
        if bottom < -BESIDE_GROUND_M:
            yield Finding("warning", obstacle.name, "sunk", f"reaches {-bottom:.3g} m below the ground")
        if bottom > AFLOAT_M:
            yield Finding("warning", obstacle.name, "afloat", f"hangs {bottom:.3g} m above the ground")
        if obstacle.velocity_m_s[2] != 0.0:
            message = f"moves up or down, at {obstacle.velocity_m_s[2]:g} m/s"
            yield Finding("warning", obstacle.name, "velocity", message)


def _ground_level(scene: Scene) -> float | None:
    """Height of the ground's highest point; None without a ground."""
    tops = [float(o.mesh.bounds[1, 2]) for o in scene.obstacles if o.category in NOT_IN_THE_WAY]
    return max(tops) if tops else None


def _things(scene: Scene) -> list[Obstacle]:
    return [obstacle for obstacle in scene.obstacles if obstacle.category not in NOT_IN_THE_WAY]


def _overlap_findings(scene: Scene, duration_s: float) -> Iterator[Finding]:
    for one, other in combinations(_things(scene), 2):
        moving = bool(np.any(one.velocity_m_s != other.velocity_m_s))
        for time in np.arange(0.0, duration_s + 1e-9, MEETING_STEP_S) if moving else (0.0,):
            depth = _depth_at(one, other, float(time))
            if depth > TOUCH_M:
                when = f" at {time:.1f} s" if moving else ""
                message = f"reaches {depth:.3g} m or more into '{other.name}'{when}"
                yield Finding("warning", one.name, "overlap", message)
                break


def _depth_at(one: Obstacle, other: Obstacle, time_s: float) -> float:
    """How deep two obstacles overlap at an instant, as seen from the second."""
    shift = time_s * (one.velocity_m_s - other.velocity_m_s)
    low, high = np.asarray(one.mesh.bounds) + shift
    if (low >= other.mesh.bounds[1]).any() or (high <= other.mesh.bounds[0]).any():
        return 0.0
    return overlap_depth(shifted(one.mesh, shift) if shift.any() else one.mesh, other.mesh)


def _walk_findings(scene: Scene, walk: Walk, phone: Phone | None) -> Iterator[Finding]:
    time = np.arange(0.0, walk.duration_s, WALK_STEP_S)
    pose = walk.pose(time)
    parts = np.zeros((1, 3)) if phone is None else np.vstack([phone.geometry.speaker_m, phone.geometry.mics_m])
    places = pose.to_world(parts)
    level = _ground_level(scene)
    lowest = float(places[:, :, 2].min())
    if level is not None and lowest <= level:
        message = f"comes down to z = {lowest:.3g} m, and the ground is at {level:g} m"
        yield Finding("error", "phone", "below ground", message)
    for obstacle in scene.obstacles:
        drift = time[:, None, None] * obstacle.velocity_m_s
        within = inside(obstacle.mesh, (places - drift).reshape(-1, 3)).reshape(len(time), -1).any(axis=1)
        if within.any():
            message = f"lies inside '{obstacle.name}' from {time[np.argmax(within)]:.2f} s on"
            yield Finding("error", "phone", "inside", message)
    for obstacle in _things(scene):
        yield from _contact_findings(obstacle, walk)


def _contact_findings(obstacle: Obstacle, walk: Walk) -> Iterator[Finding]:
    met = contact(obstacle, walk).contact_time_s
    if met == 0.0:
        yield Finding("error", obstacle.name, "start", "touches the walker's body before the walk begins")
    elif met < walk.duration_s - 0.1:
        rest = walk.duration_s - met
        message = f"is met at {met:.2f} s, and the walk goes on through it for {rest:.2f} s"
        yield Finding("warning", obstacle.name, "walked through", message)
