"""Labels drawn over pictures."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from graspdsl.worlds.annotations import INK, Label, annotated, label_boxes

WIDTH, HEIGHT = 640, 480
places = st.tuples(st.floats(0.0, WIDTH), st.floats(0.0, HEIGHT)).map(np.array)


@given(st.lists(places, min_size=1, max_size=4))
def test_labels_are_inside_the_picture_beside_their_places_and_not_over_one_another(at: list[np.ndarray]) -> None:
    boxes = label_boxes([Label(place, f"finger-{number}") for number, place in enumerate(at)], WIDTH, HEIGHT)
    for place, (left, top, right, bottom) in zip(at, boxes, strict=True):
        assert 0 <= left < right <= WIDTH
        assert 0 <= top < bottom <= HEIGHT
        assert not left <= place[0] <= right
    for one, other in itertools.combinations(boxes, 2):
        assert one[2] <= other[0] or other[2] <= one[0] or one[3] <= other[1] or other[3] <= one[1]


def test_a_label_is_written_in_its_box_and_joined_to_its_place() -> None:
    picture = np.full((HEIGHT, WIDTH, 3), 128, dtype=np.uint8)
    label = Label(np.array([300.0, 200.0]), "finger-1")
    drawn = np.asarray(annotated(picture, [], [], [label]))
    (left, top, right, bottom), border = label_boxes([label], WIDTH, HEIGHT)[0], 2
    rows, columns = np.nonzero((drawn != picture).any(axis=-1))
    written = columns >= left - border
    assert columns[written].max() <= right + border
    assert top - border <= rows[written].min() < rows[written].max() <= bottom + border
    assert set(range(300, round(left) - border)) <= set(columns[~written])
    assert np.ptp(rows[~written]) < 10
    assert (drawn[200, 300] == INK).all()
    assert (drawn[:, round(left) :] == INK).all(axis=-1).any()
