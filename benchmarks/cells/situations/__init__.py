"""What a cell simulates: approaches, standing phones, scenes of one's own, and what varies."""
