"""Triangles of polygons: as many as there must be, of the area of the polygon, none turned round."""

import numpy as np
import pytest

from t4d.polygons import triangulate

SHAPES = {
    "triangle": [(0, 0), (1, 0), (0, 1)],
    "square": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "dart": [(0, 0), (2, -1), (0.5, 0), (2, 1)],
    "dart from its tip": [(0.5, 0), (2, 1), (0, 0), (2, -1)],
    "quad with a straight corner": [(0, 0), (1, 0), (2, 0), (1, 1)],
    "square with corners on its sides": [(0, 0), (1, 0), (2, 0), (2, 1), (2, 2), (1, 2), (0, 2), (0, 1)],
    "L": [(0, 0), (3, 0), (3, 1), (1, 1), (1, 3), (0, 3)],
    "star": [((1 + i % 2) * np.cos(i * np.pi / 7), (1 + i % 2) * np.sin(i * np.pi / 7)) for i in range(14)],
    "ring with a slit": [(0, 0), (3, 0), (3, 3), (0, 3), (0, 0), (1, 1), (1, 2), (2, 2), (2, 1), (1, 1)],
}


def area(points):
    x, y = np.asarray(points, dtype=float).T
    return (x * np.roll(y, -1) - np.roll(x, -1) * y).sum() / 2


@pytest.mark.parametrize("name", SHAPES)
def test_triangles_cover_a_polygon_in_any_plane(name):
    flat = np.array(SHAPES[name], dtype=float)
    for plane in (np.eye(3), np.linalg.qr(np.random.default_rng(3).normal(size=(3, 3)))[0]):
        points = flat @ plane[:2] + [5, -3, 2]
        triangles, polygons = triangulate([len(flat)], np.arange(len(flat)), points)
        areas = [area(flat[one]) for one in triangles]
        assert len(triangles) == len(flat) - 2 and (polygons == 0).all()
        assert min(areas) > 1e-6 and np.isclose(sum(areas), area(flat)), areas


def test_polygons_keep_their_order_and_points_and_lines_have_none():
    counts, corners = [4, 1, 3, 2, 6], np.arange(16)
    points = np.random.default_rng(3).normal(size=(16, 3))
    triangles, polygons = triangulate(counts, corners, points)
    assert polygons.tolist() == [0, 0, 2, 4, 4, 4, 4]
    begins = np.cumsum([0, *counts])
    for one, polygon in zip(triangles, polygons):
        assert set(one) <= set(range(begins[polygon], begins[polygon + 1]))


def test_a_polygon_that_crosses_itself_has_as_many():
    points = np.array([(0, 0, 0), (2, 2, 0), (2, 0, 0), (0, 2, 0), (1, 3, 0)], dtype=float)
    assert len(triangulate([5], np.arange(5), points)[0]) == 3
    assert len(triangulate([5], np.arange(5), np.zeros((5, 3)))[0]) == 3
