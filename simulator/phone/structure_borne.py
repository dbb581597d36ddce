"""Direct sound through the phone's case: an arrival of its own at each microphone, ahead of the airborne one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from simulator.paths import Paths
from simulator.phone.transducers import StructureBorne


def through_case(paths: Paths, sound: StructureBorne) -> Paths:
    """One path a pose and microphone, in the form of the airborne paths, named "case"."""
    pose, mic = (index.ravel() for index in np.indices((paths.poses, 2)))
    count, width = len(pose), paths.sequence.shape[1]
    direct = paths[(paths.order == 0) & (paths.obstacle == "")]
    gain = sound.gain[mic].astype(np.complex128)
    return replace(
        direct,
        delay_s=sound.delay_s[mic],
        gain=gain,
        band_gain=np.repeat(gain[:, None], paths.band_gain.shape[1], axis=1),
        mic=mic,
        pose=pose,
        obstacle=np.full(count, "case"),
        sequence=np.full((count, width), -1),
    )
