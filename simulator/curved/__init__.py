"""Reflection off smooth surfaces: stationary points, one or two to a path."""
