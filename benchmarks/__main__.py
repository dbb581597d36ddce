"""`python -m benchmarks` is `obstaclewatch`, where no script is installed."""

from __future__ import annotations

from benchmarks.cli import main

if __name__ == "__main__":
    main()
