"""What `TrackingDetector` can be set to: those of the paper's constants that it has a use for."""

from __future__ import annotations

from dataclasses import dataclass, fields

from obstaclewatch.paper.settings import PaperSettings

_DEFAULT = PaperSettings()


@dataclass(frozen=True)
class TrackingSettings:
    """Constants of the tracking detector, with the paper's defaults.

    Attributes:
        near_m, far_m: one-way ranges that are searched.
        floor_db: least threshold, relative to the direct sound.
        max_candidates: tracks in a detection, the nearest first.
        danger_m: alerts are raised within.
        walker_half_width_m: half the width of the walker's body.
        direct_delay_s: calibrated delay of the direct peak at microphone 0; None takes the air path.

    Raises:
        ValueError: a value out of range; the message names it.

    >>> from obstaclewatch import TrackingSettings
    >>> TrackingSettings(danger_m=2.0).far_m
    7.0
    """

    near_m: float = _DEFAULT.near_m
    far_m: float = _DEFAULT.far_m
    floor_db: float = _DEFAULT.floor_db
    max_candidates: int = _DEFAULT.max_candidates
    danger_m: float = _DEFAULT.danger_m
    walker_half_width_m: float = _DEFAULT.walker_half_width_m
    direct_delay_s: float | None = _DEFAULT.direct_delay_s

    def __post_init__(self) -> None:
        same = PaperSettings(**{each.name: getattr(self, each.name) for each in fields(self)})  # the same ranges
        for each in fields(self):
            object.__setattr__(self, each.name, getattr(same, each.name))
        if self.walker_half_width_m == 0.0:
            raise ValueError("walker_half_width_m must be positive to judge trajectories, got 0.0")

    @classmethod
    def of(cls, settings: TrackingSettings | PaperSettings | None) -> TrackingSettings:
        """Settings as they are given; those of the paper only where nothing else of them was changed.

        Raises:
            ValueError: another type, or a constant that the tracking detector has no use for.
        """
        if settings is None or isinstance(settings, TrackingSettings):
            return settings or cls()
        settings = PaperSettings.of(settings)
        names = [each.name for each in fields(cls)]
        for each in fields(settings):
            value = getattr(settings, each.name)
            if each.name not in names and value != getattr(_DEFAULT, each.name):
                raise ValueError(
                    f"TrackingDetector takes {', '.join(names)} of the settings, got {each.name}={value!r}"
                )
        return cls(**{name: getattr(settings, name) for name in names})
