"""From samples to echoes: matched filter, peaks, phases, background."""
