"""Ground truth from meshes and walks alone."""

from scenes.truth.truth import GroundTruth, ground_truth

__all__ = ["GroundTruth", "ground_truth"]
