"""A scene of someone else reads meshes of its own folder, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from trimesh.creation import box

from scenes.files.mesh_file import ALLOWED, mesh_path, read_mesh


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    scene = tmp_path / "scene"
    (scene / "meshes").mkdir(parents=True)
    for place in (tmp_path, scene, scene / "meshes"):
        box().export(place / "block.ply")
    return scene


def test_meshes_beside_the_file_and_below_are_read(folder: Path) -> None:
    for name in ("block.ply", "meshes/block.ply", "./meshes/../block.ply"):
        assert len(read_mesh(mesh_path(folder, name), 1.0, "z").faces) == 12


def test_a_mesh_elsewhere_is_refused_unless_its_folder_is_allowed(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Cause: the name was joined to the folder and opened, so `../x.ply` and absolute paths were read."""
    (folder / "link.ply").symlink_to(folder.parent / "block.ply")
    outside = ["../block.ply", str(folder.parent / "block.ply"), "link.ply", "meshes/../../block.ply"]
    for name in outside:
        with pytest.raises(ValueError, match=r"mesh file must lie in the scene file's folder, got"):
            mesh_path(folder, name)
    monkeypatch.setenv(ALLOWED, str(folder.parent))
    for name in outside:
        assert mesh_path(folder, name) == folder.parent / "block.ply"


@pytest.mark.parametrize("name", ["x.dae", "x.npz", "x.zip", "scene.yaml", ""])
def test_other_formats_are_refused(folder: Path, name: str) -> None:
    with pytest.raises(ValueError, match=r"mesh file must be one of \.obj, "):
        mesh_path(folder, name)


@pytest.mark.parametrize("name", ["a\0.ply", "a" * 300 + ".ply"])
def test_impossible_names_are_refused(folder: Path, name: str) -> None:
    with pytest.raises((ValueError, FileNotFoundError), match=r"mesh"):
        mesh_path(folder, name)


def test_a_gltf_reads_no_buffer_outside_its_folder(folder: Path) -> None:
    (folder.parent / "secret.bin").write_bytes(bytes(36))
    text = (
        '{"asset": {"version": "2.0"}, "buffers": [{"uri": "../secret.bin", "byteLength": 36}], "bufferViews": '
        '[{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": '
        '"VEC3"}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}], "scenes": '
        '[{"nodes": [0]}], "scene": 0}'
    )
    (folder / "thing.gltf").write_text(text)
    with pytest.raises(ValueError, match=r"must be one that trimesh reads, got thing\.gltf: .*escapes"):
        read_mesh(mesh_path(folder, "thing.gltf"), 1.0, "y")


def test_points_that_are_not_finite_are_refused(folder: Path) -> None:
    (folder / "nan.obj").write_text("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    with pytest.raises(ValueError, match=r"nan\.obj"):
        read_mesh(mesh_path(folder, "nan.obj"), 1.0, "z")


@pytest.mark.parametrize("name", ["hole.obj", "hole.ply", "hole.stl"])
def test_one_such_point_of_many_is_not_cut_out_in_silence(folder: Path, name: str) -> None:
    """Cause: trimesh dropped the point and its triangles while it read the file."""
    holed = box()
    holed.vertices[0, 2] = np.nan
    holed.export(folder / name)
    with pytest.raises(ValueError, match="between finite points"):
        read_mesh(mesh_path(folder, name), 1.0, "z")
