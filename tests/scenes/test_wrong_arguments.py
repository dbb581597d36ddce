"""What callers of scenes and of a detector's settings get wrong ends in one ValueError that names rule and value."""

from __future__ import annotations

import numpy as np
import pytest

from obstaclewatch import Errata, assumed_sound_speed
from scenes import Pace, Route, RouteWalk, ground_truth, load_encounter, make_approach
from scenes.obstacles.solids import box
from scenes.truth.swept import Body
from simulator import Material, Obstacle, Phone, Scene, StraightWalk

WALK = StraightWalk([0.0, 0.0, 1.3], 0.0, 1.3, 4.0)
PHONE = Phone.named("ideal")
ROUTE = Route([[0.0, 0.0], [4.0, 0.0]])


def truth(velocity=(0.0, 0.0, 0.0), **changed):
    crate = Obstacle(box([0.5, 0.5, 1.5], [4.0, 0.0, 0.0]), Material.rigid(), "crate", velocity_m_s=velocity)
    return ground_truth(**{"scene": Scene([crate]), "walk": WALK, "phone": PHONE, "time_s": [0.0]} | changed)


WRONG = {
    "velocity_m_s of 'crate' must be level": lambda: truth((0.0, 0.0, -2.0)),
    "seed must be a whole number, 0 or more, got None": lambda: load_encounter("absent.yaml", seed=None),
    "seed must be a whole number, 0 or more, got -1": lambda: load_encounter("absent.yaml", seed=-1),
    "time_s must be finite, got": lambda: truth(time_s=[np.nan]),
    r"time_s must have shape \(\) or \(T,\), T > 0, got \(0,\)": lambda: truth(time_s=[]),
    "time_s must lie within the walk, 0 to 4 s, .*, got -0.1": lambda: truth(time_s=[0.0, -0.1]),
    "time_s must lie within the walk, .*, got 4.1": lambda: truth(time_s=[4.1, 5.0]),
    "scene must be of type Scene, got None": lambda: truth(scene=None),
    "phone must be of type Phone": lambda: truth(phone=PHONE.geometry),
    "half_width_m must be a number, got 'a'": lambda: truth(half_width_m="a"),
    "half_width_m must not be negative, got inf": lambda: truth(half_width_m=np.inf),
    "height_m must be a number, got None": lambda: Body(height_m=None),
    "collision must be of type .*bool.*, got 'no'": lambda: make_approach("campus", "car", 1, collision="no"),
    r"category must be of type str, got \['car'\]": lambda: make_approach("campus", ["car"], 1),
    "beep_period_s must be a number, got 'a'": lambda: make_approach("campus", "car", 1, beep_period_s="a"),
    "pace must be of type Pace, got 1.3": lambda: RouteWalk(ROUTE, 1.3, duration_s=2.0),
    "route must be of type Route, got None": lambda: RouteWalk(None, Pace(1.3), duration_s=2.0),
    "gait must be of type .*Gait.*, got 5": lambda: RouteWalk(ROUTE, Pace(1.3), duration_s=2.0, gait=5),
    "waypoints_m must be numbers, got 'a'": lambda: Route("a"),
    "speed_m_s must be a number, got None": lambda: Pace(None),
    "pressure_pa must lie within 10000..200000 Pa, got 1013.25": lambda: assumed_sound_speed(20.0, 0.5, 1013.25),
    "correlate_once must be of type bool, got 'no'": lambda: Errata(correlate_once="no"),
}


@pytest.mark.parametrize("rule", WRONG)
def test_what_is_wrong_is_named_with_its_rule(rule):
    with pytest.raises(ValueError, match=rule):
        WRONG[rule]()
