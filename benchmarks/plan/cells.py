"""From a suite and a tier to the list of its cells."""

from __future__ import annotations

import hashlib
import math
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np

from benchmarks.cells.check import check_cell, check_detectors, check_place
from benchmarks.cells.detectors import parse_detector, source_digest
from benchmarks.cells.equipment import equipment_key
from benchmarks.cells.memory import check_memory
from benchmarks.cells.situations.own_scene import scene_digest
from benchmarks.cells.spec import Cell, Conditions, label_of_walk
from benchmarks.plan.suite import Group, OwnScene, Probe, Standing, Suite
from benchmarks.plan.sweep import at_point
from benchmarks.plan.unknowns import with_unknowns
from scenes import load_encounter

MOST_CELLS = 200_000
"""A plan of so many takes 2 GB; the largest suite of the project has a hundredth of them."""
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0


def plan_cells(suite: Suite, tier: str) -> list[Cell]:
    """The cells of a tier, in a fixed order.

    A smaller tier holds the first walks of every stratum (scene x category, or category x distance), so its cells
    are also cells of the larger tiers and every stratum is present. Collision and non-collision walks, and the
    phones, alternate within a stratum. A sweep plans each of them at all of its points, one after the other.

    Raises:
        ValueError: an unknown tier, a plan without a cell, with one twice or with more than
            `MOST_CELLS`, or a cell that could not run.
    """
    chosen = suite.tier(tier)
    _check_size(suite, chosen.size)
    walks = [walk for group in suite.groups for walk in _walks(suite, group, chosen.size)]
    cells = [cell for walk in walks for cell in _drawn(suite, walk)]
    cells += [cell for own in suite.scenes for cell in _own_walks(suite, own, chosen.size)]
    if suite.standing is not None:
        cells += _standing(suite, suite.standing, chosen.size)
    cells += list(_probes(suite))
    points = [{}] if suite.sweep is None else suite.sweep.visited()
    cells = [_with_sources(at_point(cell, point)) for cell in cells for point in points]
    if not cells:
        raise ValueError(f"suite '{suite.name}' must have at least one cell at tier '{tier}', got none")
    _tell_apart(cells)
    _check(cells)
    return cells


def plan_digest(cells: Sequence[Cell], fingerprint: str) -> str:
    """SHA-256 over the cells of a plan, hexadecimal."""
    return hashlib.sha256("\n".join(cell.digest(fingerprint) for cell in cells).encode()).hexdigest()


def cell_seed(suite: Suite, stratum: str, index: int) -> int:
    """The seed of one walk: its own stream of the suite's seed, apart for the splits dev and test."""
    key = int.from_bytes(hashlib.sha256(f"{suite.split}/{stratum}".encode()).digest()[:4], "big")
    return int(np.random.SeedSequence(suite.seed, spawn_key=(key, index)).generate_state(1, np.uint32)[0])


def is_collision(index: int, fraction: float) -> bool:
    """Whether the walk of that number is on a collision course: `fraction` of any run of walks, evenly spread."""
    return int(np.floor((index + 1) * fraction + 1e-9)) > int(np.floor(index * fraction + 1e-9))


def _check_size(suite: Suite, size: Callable[[int], int]) -> None:
    """Count the cells without making them: a file of a stranger may ask for more than memory holds."""
    walks = [count for group in suite.groups for count in group.counts.values()] + [own.count for own in suite.scenes]
    cells = sum(map(size, walks))
    if suite.standing is not None:
        places = len(suite.standing.range_m) * len(suite.standing.bearing_rad)
        cells += places * sum(map(size, suite.standing.counts.values()))
    cells += sum(len(probe.phones) * math.prod(map(len, probe.over.values())) for probe in suite.probes)
    cells *= 1 if suite.sweep is None else suite.sweep.size
    if cells > MOST_CELLS:
        raise ValueError(f"suite '{suite.name}' must have at most {MOST_CELLS} cells, got {cells}")


def _walks(suite: Suite, group: Group, size: Callable[[int], int]) -> Iterator[Cell]:
    for category, count in group.counts.items():
        for index in range(size(count)):
            yield Cell(
                kind="approach",
                scene=group.scene,
                category=category,
                index=index,
                # Every second walk is a collision by default, so the phones change every two.
                phone=group.phones[(index // 2) % len(group.phones)],
                seed=cell_seed(suite, f"{group.scene}/{category}", index),
                collision=is_collision(index, suite.collision_fraction),
                approach={"recipe": suite.recipe} | group.approach,
                detectors=suite.detectors,
                **_shared(suite),
            )


def _drawn(suite: Suite, walk: Cell) -> list[Cell]:
    """The walk, and once more with the unknowns drawn if the suite asks for it."""
    return [walk, with_unknowns(walk)] if suite.unknowns == "drawn" else [walk]


def _own_walks(suite: Suite, own: OwnScene, size: Callable[[int], int]) -> Iterator[Cell]:
    digest, phones = scene_digest(own.file), own.phones or (None,)
    for index in range(size(own.count)):
        phone = phones[index % len(phones)]
        seed = cell_seed(suite, f"scene/{own.file}", index)
        met = load_encounter(own.file, seed, phone)
        check_memory(met.walk.duration_s, suite.beep.sample_rate_hz)
        yield Cell(
            kind="scene",
            scene=met.scene.name,
            category=met.target.category or "other",
            index=index,
            phone=met.phone.geometry.name,
            seed=seed,
            collision=False,  # not ours to choose: the ground truth says
            approach={"file": own.file, "sha256": digest, "phone": phone},
            detectors=suite.detectors,
            **_shared(suite),
        )


def _standing(suite: Suite, standing: Standing, size: Callable[[int], int]) -> list[Cell]:
    """With the detectors named for them, and with those of a user's own that walk."""
    own = [name for name in suite.detectors if parse_detector(name).module and name not in standing.detectors]
    return [
        Cell(
            kind="standing",
            scene="standing",
            category=category,
            index=index,
            phone=standing.phones[index % len(standing.phones)],
            seed=cell_seed(suite, f"standing/{category}/{range_m:g}", index),
            collision=False,
            range_m=range_m,
            bearing_rad=bearing_rad,
            detectors=(*standing.detectors, *own),
            **_shared(suite) | {"scoring": suite.scoring.model_copy(update={"gate_m": standing.gate_m})},
        )
        for category, count in standing.counts.items()
        for range_m in standing.range_m
        for bearing_rad in standing.bearing_rad
        for index in range(size(count))
    ]


def _probes(suite: Suite) -> Iterator[Cell]:
    """One cell for every probe, phone and combination of values, numbered within its kind and name."""
    numbers: Counter[tuple[str, str]] = Counter()
    for probe, phone, swept in _probe_points(suite):
        number = numbers[probe.kind, probe.name]
        numbers[probe.kind, probe.name] += 1
        yield Cell(
            kind=probe.kind,
            scene=probe.kind,
            category=probe.name,
            index=number,
            phone=phone,
            seed=cell_seed(suite, f"{probe.kind}/{probe.name}", 0),
            collision=False,
            probe=probe.parameters | swept,
            detectors=(),
            **_shared(suite),
        )


def _probe_points(suite: Suite) -> Iterator[tuple[Probe, str, dict[str, Any]]]:
    for probe in suite.probes:
        for phone in probe.phones:
            for chosen in product(*probe.over.values()):
                yield probe, phone, dict(zip(probe.over, chosen, strict=True))


def _shared(suite: Suite) -> dict[str, Any]:
    """The conditions that a cell takes from its suite."""
    return {name: getattr(suite, name) for name in Conditions.model_fields}


def _with_sources(cell: Cell) -> Cell:
    """The cell with the digest of every detector that is not obstaclewatch's own, whose source names cells too."""
    named = [parse_detector(text) for text in cell.detectors]
    sources = {name.text: source_digest(name) for name in named if name.module}
    return cell.model_copy(update={"detector_sources": sources}) if sources else cell


def _tell_apart(cells: Sequence[Cell]) -> None:
    """Refuse walks that stand twice under one label: they would be counted twice, or taken for one."""
    counts = Counter((cell.label, cell.phone, cell.seed) for cell in cells)
    twice = [label for (label, _, _), count in counts.items() if count > 1]
    if twice:
        raise ValueError(
            f"walks must have labels of their own, but {len(twice)} stand more than once, the first is '{twice[0]}': "
            "let the points of the sweep differ, or name them; join groups of one scene and category"
        )


def _check(cells: Sequence[Cell]) -> None:
    """Refuse what could not run before anything runs; cells that differ in nothing that matters are looked at once."""
    for check, key in ((check_place, _place), (check_cell, _but_for_the_walk), (check_detectors, equipment_key)):
        first: dict[str, Cell] = {}
        for cell in cells:
            first.setdefault(key(cell), cell)
        for cell in first.values():
            check(cell)


def _place(cell: Cell) -> str:
    return f"{cell.kind}/{cell.scene}/{cell.category}"


def _but_for_the_walk(cell: Cell) -> str:
    return cell.model_copy(update={"index": 0, "seed": 0, "collision": False, "category": ""}).model_dump_json()


def thinned(cells: list[Cell], limit: int | None) -> list[Cell]:
    """At most so many cells, from the first walk on in steps of the golden section; all without a limit.

    Even steps would keep step with what alternates, such as collisions and other walks. A larger limit adds cells. Of a
    sweep every walk is kept at all points, as many walks as there is room for; of a single one, the first points.

    Raises:
        ValueError: a limit below 1.
    """
    if limit is None:
        return cells
    if limit < 1:
        raise ValueError(f"limit must be at least 1, got {limit}")
    walks: dict[tuple[str, str, int], list[int]] = {}
    for k, cell in enumerate(cells):
        walks.setdefault((label_of_walk(cell.label, cell.variant), cell.phone, cell.seed), []).append(k)
    points, kept = list(walks.values()), list[int]()
    for walk in np.argsort(np.argsort(GOLDEN * np.arange(len(points)) % 1.0)):
        if kept and len(kept) + len(points[walk]) > limit:
            break
        kept += points[walk]
    return [cells[k] for k in sorted(kept[:limit])]
