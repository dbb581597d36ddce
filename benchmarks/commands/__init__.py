"""Subcommands of `obstaclewatch`, one module each.

They import what they work with when they run: `obstaclewatch run --help` answers at once.
"""

ALLOW_CODE = "allow the modules that a suite file, not one of this project, names as detectors to be imported"
"""Help of the option `--allow-code`."""
