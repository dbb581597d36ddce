"""Image paths of a room by acoustic-spaces, as JSON: run as a program of its own, for its licence is not ours.

python -m tests.references.acoustic_spaces_paths < room.json

The room is {"plan": [[x, y], ...], "height": h, "source": [x, y, z], "receivers": [[x, y, z], ...], "order": n}; the
answer is {"vertices": ..., "faces": ..., "paths": for each receiver {"order": [...], "length_m": [...]}}.
"""

from __future__ import annotations

import json
import sys
from typing import Any


def paths(room: dict[str, Any]) -> dict[str, Any]:
    """The room's mesh, and specular paths to every receiver, the direct one included."""
    from acoustic_spaces.engine.simulate import early_paths
    from acoustic_spaces.room import Room
    from acoustic_spaces.scene import Scene

    names = [f"listener {i}" for i in range(len(room["receivers"]))]
    scene = Scene.model_validate({
        "name": "peer",
        "geometry": {"floor_plan": room["plan"], "height": room["height"]},
        "materials": {"hard": {"absorption": [0.01] * 8, "scattering": 0.0}},
        "assignments": {"floor": "hard", "ceiling": "hard", "walls": "hard"},
        "sources": [{"name": "source", "position": room["source"]}],
        "listeners": [{"name": n, "position": p} for n, p in zip(names, room["receivers"], strict=True)],
        "simulation": {
            "early": {"method": "image_sources", "max_order": room["order"], "diffraction": "none"},
            "transition_ms": 1000.0, "ir_length_s": 1.5,
        },
    })  # fmt: skip
    loaded = Room.from_scene(scene)
    found = [early_paths(loaded, "source", name) for name in names]
    return {
        "vertices": loaded.mesh.vertices.tolist(), "faces": loaded.mesh.faces.tolist(),
        "paths": [{"order": each.order.tolist(), "length_m": each.distance_m.tolist()} for each in found],
    }  # fmt: skip


if __name__ == "__main__":
    json.dump(paths(json.load(sys.stdin)), sys.stdout)
