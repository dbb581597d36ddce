"""Kirchhoff's integral, for bodies that are neither large and flat nor smooth."""
