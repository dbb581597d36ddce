"""What every search for paths of one call has in common."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from obstaclewatch.support.arrays import Flags, Floats
from simulator.phone.phone import Phone
from simulator.scene.air import Air
from simulator.scene.fidelity import Fidelity
from simulator.waves import band
from simulator.waves.band import REFERENCE_HZ
from simulator.waves.sweep import Sweep
from simulator.world.audible import Audible
from simulator.world.rejection_log import Reason, Rejected, RejectionLog
from simulator.world.world import Tracing

OF_OTHERS = 10.0  # least area of mirrors of other obstacles re those of the same, where there are several in a path
NOISE_MARGIN_DB = 40.0  # the matched filter raises an echo by 20 dB over the noise in band, and 20 dB are to spare


@dataclass(frozen=True)
class Search:
    """One call's poses, what is asked for, and the log of what is rejected.

    Attributes:
        tracing: the poses in the prepared world.
        phone: transducers, levels and noise.
        air: speed of sound and absorption.
        fidelity: what is modelled.
        sweep: how the phone moves while a chirp lasts; None for poses taken one by one, and for beeps too short or too
            narrow to have an instant for each frequency.
        log: collects rejections and choices; it holds no input of any search.
    """

    tracing: Tracing
    phone: Phone
    air: Air
    fidelity: Fidelity
    sweep: Sweep | None = None
    log: RejectionLog = field(default_factory=RejectionLog)

    @property
    def max_order(self) -> int:
        """Greatest number of reflections of a path."""
        return self.fidelity.max_order

    @cached_property
    def large_mirrors(self) -> Flags:
        """(P,) patches that may be met in paths of three reflections and more."""
        return self.tracing.world.patches.area_m2 >= self.fidelity.mirror_m2

    @cached_property
    def large_towards(self) -> Flags:
        """(P, O) patches that may be met in such paths on the way to each obstacle: of others, the larger ones alone.

        Small faces of one obstacle reflect to each other from close by, as the sleeves of a dumpster do.
        """
        patches, obstacles = self.tracing.world.patches, np.arange(len(self.tracing.world.obstacles))
        own = patches.obstacle[:, None] == obstacles
        return patches.area_m2[:, None] >= self.fidelity.mirror_m2 * np.where(own, 1.0, OF_OTHERS)

    @cached_property
    def audible(self) -> Audible:
        """What is loud enough to be kept."""
        return Audible.of(self.fidelity)

    @cached_property
    def lost_in_noise(self) -> float:
        """Gain under which an echo is lost in the noise; 0 without noise."""
        floor_db = self.phone.noise_spl_db - self.phone.level_spl_db - NOISE_MARGIN_DB
        return float(10.0 ** (floor_db / 20.0))

    @property
    def limit_m(self) -> float:
        """Longest path."""
        return 2.0 * self.fidelity.max_range_m

    @cached_property
    def band_hz(self) -> Floats:
        """(K,) frequencies at which gains are worked out."""
        return band.nodes_hz(self.fidelity.band_points)

    @cached_property
    def band_wavenumber_1_m(self) -> Floats:
        """(K,) wavenumbers at these, rad/m."""
        return self.wavenumbers_1_m(self.band_hz)

    @cached_property
    def wavenumber_1_m(self) -> float:
        """In the middle of the band, rad/m."""
        return 2.0 * np.pi * REFERENCE_HZ / self.air.sound_speed_m_s

    def wavenumbers_1_m(self, frequency_hz: Floats) -> Floats:
        """(K,) wavenumbers at K frequencies, rad/m."""
        return 2.0 * np.pi * frequency_hz / self.air.sound_speed_m_s

    def reject(self, reason: Reason, count: int, describe: Callable[[], Rejected]) -> None:
        """Book `count` candidates; `describe` is asked about them only if they are listed."""
        self.log.reject(reason, count, describe)
