"""Image paths by acoustic-spaces and what they cost, JSON in and out; a program of its own.

In: {"geometry": as its scenes have it, "order": n, "sources": [[x, y, z], ...], "receivers": [[[x, y, z], ...], ...]};
out: {"length_m": for each pair [...], "pair_ms": processor time a pair}.
"""

from __future__ import annotations

import json
import sys
from time import process_time
from typing import Any


def walked(asked: dict[str, Any]) -> dict[str, Any]:
    """All pairs twice, of which the second time counts."""
    from acoustic_spaces.engine.simulate import early_paths
    from acoustic_spaces.room import Room
    from acoustic_spaces.scene import Scene

    pairs = [(s, r) for s, some in zip(asked["sources"], asked["receivers"], strict=True) for r in some]
    scene = Scene.model_validate({
        "name": "speed",
        "geometry": asked["geometry"],
        "materials": {"hard": {"absorption": [0.01] * 8, "scattering": 0.0}},
        "assignments": {},
        "default_material": "hard",
        "sources": [{"name": f"s{k}", "position": s} for k, (s, _) in enumerate(pairs)],
        "listeners": [{"name": f"r{k}", "position": r} for k, (_, r) in enumerate(pairs)],
        "simulation": {
            "early": {"method": "image_sources", "max_order": asked["order"], "diffraction": "none"},
            "transition_ms": 1000.0, "ir_length_s": 1.5,
        },
    })  # fmt: skip
    room, found, spent = Room.from_scene(scene), [], 0.0
    for _ in range(2):
        begin = process_time()
        found = [early_paths(room, f"s{k}", f"r{k}").distance_m.tolist() for k in range(len(pairs))]
        spent = process_time() - begin
    return {"length_m": found, "pair_ms": 1e3 * spent / len(pairs)}


if __name__ == "__main__":
    json.dump(walked(json.load(sys.stdin)), sys.stdout)
