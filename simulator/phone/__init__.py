"""The phone as an instrument: transducers, noise, measured presets."""

from simulator.phone.phone import Phone

__all__ = ["Phone"]
