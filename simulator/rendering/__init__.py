"""From paths to samples: the emitted beep as a table, its sum over all paths, and the recording's rate."""
