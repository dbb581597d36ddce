"""How loud obstacles echo: peak of the matched filter over the direct sound, over all that a street varies.

Every obstacle is drawn as `random_obstacle` draws it, rotated as it stands to a walker, and put on hard ground with its
nearest point straight ahead at the distance in plan. Images in the ground count: a bin lower than the phone echoes
through its corner with the ground.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from obstaclewatch.support.arrays import Floats
from scenes.obstacles import ground, random_obstacle
from scenes.streets.approaches import target_yaw
from scenes.streets.placing import distance_along, placed
from simulator.paths import Paths
from simulator.phone.phone import Phone
from simulator.scene.materials import Material
from simulator.scene.pose import Pose, held_rotation
from simulator.scene.scene import Obstacle, Scene
from simulator.trace import trace_paths

TARGET = "target"
BAND_HZ = (18_000.0, 23_000.0)
BINS = 512  # of the band: unambiguous over 17 m of range
PADDING = 4
PITCH_RAD = float(np.deg2rad(30.0))
HEIGHTS_M = (1.2, 1.3, 1.4)


@dataclass(frozen=True)
class EchoLevels:
    """Levels of one category at one distance.

    Attributes:
        category, distance_m: of the obstacles.
        level_db: (N,) echo of each draw over the direct sound; -inf where there is none.
    """

    category: str
    distance_m: float
    level_db: Floats

    def percentile_db(self, percent: float) -> float:
        """That percentile of the levels, an obstacle without echo counting as the quietest."""
        return float(np.percentile(self.level_db, percent, method="lower"))


def echo_levels(category: str, distance_m: float, phone: Phone, count: int = 40, seed: int = 0) -> EchoLevels:
    """Levels of obstacles drawn at random, from phones at 1.2, 1.3 and 1.4 m pitched up by 30 degrees.

    Args:
        category: of the obstacles, one of `scenes.obstacles.CATEGORIES`.
        distance_m: in plan from the phone to the obstacle.
        phone: whose microphone 0 records, and whose own direct sound is the reference.
        count: of obstacles; each gives a level for every height of the phone.
        seed: of the draws.

    Raises:
        ValueError: an unknown category, or a distance within which an obstacle cannot stand ahead.
    """
    streams = np.random.SeedSequence(seed).spawn(count)
    levels = [_levels(category, distance_m, phone, np.random.default_rng(stream)) for stream in streams]
    return EchoLevels(category, distance_m, np.concatenate(levels))


def _levels(category: str, distance_m: float, phone: Phone, rng: np.random.Generator) -> Floats:
    """(3,) levels of one obstacle at the three heights of the phone, dB."""
    drawn = random_obstacle(category, rng, TARGET)
    target = placed(drawn, np.zeros(2), target_yaw(rng, category))
    along = distance_along(target, np.zeros(2), np.zeros(2), np.array([1.0, 0.0]), distance_m)
    floor = Obstacle(ground(), Material.named("concrete-paving"), "ground", surface="flat", category="ground")
    number = len(HEIGHTS_M)
    place = np.stack([np.zeros(number), np.zeros(number), np.array(HEIGHTS_M)], axis=-1)
    pose = Pose(place, held_rotation(np.zeros(number), np.full(number, PITCH_RAD), np.zeros(number)))
    paths = trace_paths(Scene((floor, placed(target, [along, 0.0]))), phone, pose)
    echo = paths[np.char.find(paths.obstacle, TARGET) >= 0]
    with np.errstate(divide="ignore"):  # no echo is -inf
        return 20.0 * np.log10(_peaks(echo) / _peaks(paths[paths.order == 0]))


def _peaks(paths: Paths) -> Floats:
    """(N,) peak of the compressed pulse at microphone 0 of each pose, Hann over the band; a unit path gives 1."""
    response = paths.transfer_function(np.linspace(*BAND_HZ, BINS))[:, 0]
    window = np.hanning(BINS)
    pulse = np.fft.fft(response * window / window.sum(), PADDING * BINS, axis=1)
    return np.abs(pulse).max(axis=1)
