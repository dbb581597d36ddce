"""Every image path among axis-aligned boxes, in exact rational arithmetic: no tolerance decides who is on a border.

All sequences of faces are tried. A face counts with its border; a leg is stopped by the open inside of a box. Paths
whose legs pass within `GRAZING` of a box's surface without meeting it there are neither required nor forbidden:
rounding may decide whether such a ray is stopped.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction

Point = tuple[Fraction, ...]
Box = tuple[Point, Point]  # lowest and highest corner
Face = tuple[int, int, int]  # box, axis, side: 0 lowest, 1 highest

GRAZING = Fraction(1, 5000)


@dataclass(frozen=True)
class ImagePath:
    """One image: reflections counted, where the source appears, the points from the source on, who else is grazed."""

    order: int
    image: Point
    points: tuple[Point, ...]
    grazes: bool


def image_paths(boxes: Sequence[Box], source: Point, receiver: Point, max_order: int) -> list[ImagePath]:
    """Unhidden image paths of orders 1 to `max_order`, one for each image and order."""
    faces = [(b, axis, side) for b in range(len(boxes)) for axis in range(3) for side in range(2)]
    found: dict[tuple[int, Point], ImagePath] = {}
    for order in range(1, max_order + 1):
        for sequence in _sequences(boxes, faces, source, receiver, order):
            images = [source]
            for face in sequence:
                images.append(_mirrored(boxes, face, images[-1]))
            points = _unfolded(boxes, sequence, images, receiver)
            if points is None:
                continue
            free, grazes = _free(boxes, points)
            key = (order, images[-1])
            if (free or grazes) and (key not in found or found[key].grazes):
                found[key] = ImagePath(order, images[-1], points, grazes)
    return list(found.values())


def _sequences(
    boxes: Sequence[Box], faces: list[Face], source: Point, receiver: Point, order: int
) -> Iterator[tuple[Face, ...]]:
    """All in which the first face is turned to the source, the last to the receiver, and no box follows itself."""
    first = [f for f in faces if _height(boxes, f, source) >= 0]
    last = [f for f in faces if _height(boxes, f, receiver) >= 0]
    if order == 1:
        yield from ((f,) for f in first if f in last)
        return
    for middle in itertools.product(faces, repeat=order - 2):
        for ends in itertools.product(first, last):
            sequence = (ends[0], *middle, ends[1])
            if all(a[0] != b[0] for a, b in itertools.pairwise(sequence)):
                yield sequence


def _height(boxes: Sequence[Box], face: Face, point: Point) -> Fraction:
    box, axis, side = face
    return (point[axis] - boxes[box][side][axis]) * (1 if side else -1)


def _mirrored(boxes: Sequence[Box], face: Face, point: Point) -> Point:
    box, axis, side = face
    plane = boxes[box][side][axis]
    return tuple(2 * plane - x if k == axis else x for k, x in enumerate(point))


def _unfolded(
    boxes: Sequence[Box], sequence: tuple[Face, ...], images: list[Point], receiver: Point
) -> tuple[Point, ...] | None:
    """Source, reflection points, receiver; None if a face is missed or met from behind."""
    points = [receiver]
    for face, image in zip(reversed(sequence), reversed(images), strict=False):
        here, there = _height(boxes, face, points[-1]), _height(boxes, face, image)
        if here < 0 or there >= 0:
            return None
        share = here / (here - there)
        crossing = tuple(a + share * (b - a) for a, b in zip(points[-1], image, strict=True))
        low, high = boxes[face[0]]
        if not all(low[k] <= crossing[k] <= high[k] for k in range(3)):
            return None
        points.append(crossing)
    return (*reversed([*points, images[0]]),)


def _free(boxes: Sequence[Box], points: tuple[Point, ...]) -> tuple[bool, bool]:
    """Whether no box is in the way, and whether one nearly is or barely is."""
    free, grazes = True, False
    for a, b in itertools.pairwise(points):
        for box in boxes:
            if _stopped(a, b, _grown(box, Fraction(0))):
                free = False
                if _stopped(a, b, _grown(box, -GRAZING)):
                    return False, False
                grazes = True
            elif _stopped(*_middle(a, b), _grown(box, GRAZING)):
                grazes = True
    return free, grazes


def _middle(a: Point, b: Point) -> tuple[Point, Point]:
    """The leg without its ends, which lie on surfaces."""
    way = [(y - x) / 50 for x, y in zip(a, b, strict=True)]
    return tuple(x + w for x, w in zip(a, way, strict=True)), tuple(y - w for y, w in zip(b, way, strict=True))


def _grown(box: Box, margin: Fraction) -> Box:
    return tuple(x - margin for x in box[0]), tuple(x + margin for x in box[1])


def _stopped(a: Point, b: Point, box: Box) -> bool:
    """Whether the open segment passes through the open inside of a box."""
    enter, leave = Fraction(0), Fraction(1)
    for k in range(3):
        low, high, way = box[0][k] - a[k], box[1][k] - a[k], b[k] - a[k]
        if low >= high or (way == 0 and not low < 0 < high):
            return False
        if way != 0:
            enter, leave = max(enter, min(low / way, high / way)), min(leave, max(low / way, high / way))
    return enter < leave
