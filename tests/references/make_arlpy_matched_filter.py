"""Makes arlpy_matched_filter.npz: pulse compression by arlpy 1.9.3, the peer of `obstaclewatch.signal.matched_filter`.

arlpy asks for numpy below 2, so it cannot be installed beside this project. Run this in an environment of its own:

    python3.11 -m venv peer && peer/bin/pip install arlpy==1.9.3
    peer/bin/python tests/references/make_arlpy_matched_filter.py

The script needs nothing of this project: the beep is written out again.
"""

from pathlib import Path

import numpy as np
from arlpy.signal import mfilter
from scipy.signal import hilbert

RATE_HZ = 192_000.0
DELAY_S = np.array([0.31e-3, 5.1237e-3, 11.7011e-3, 12.3003e-3, 29.99e-3])
GAIN = np.array([1.0, 0.05, -0.3, 0.2, 0.004])
STEP = 8


def beep(time_s):
    """The paper's: 18-23 kHz in 50 ms under a Hann window."""
    window = np.where((time_s >= 0.0) & (time_s <= 0.05), 0.5 - 0.5 * np.cos(2.0 * np.pi * time_s / 0.05), 0.0)
    return window * np.cos(2.0 * np.pi * (18_000.0 * time_s + 50_000.0 * time_s**2))


def main():
    time_s = np.arange(17_280) / RATE_HZ
    block = sum(gain * beep(time_s - delay) for gain, delay in zip(GAIN, DELAY_S, strict=True))
    replica = beep(np.arange(9_600) / RATE_HZ)
    analytic = mfilter(hilbert(replica), hilbert(block)) / np.sum(np.abs(hilbert(replica)) ** 2)
    np.savez_compressed(
        Path(__file__).with_name("arlpy_matched_filter.npz"),
        delay_s=DELAY_S,
        gain=GAIN,
        step=STEP,
        magnitude=analytic[:7_200:STEP],
    )


main()
