"""Turns by products of matrices, held against those of quaternions, component by component."""

from __future__ import annotations

import numpy as np

from footfix.locomotion.cycles import leg_vectors
from footfix.motion import rotation, vectors
from footfix.motion.clip import Floats

RNG = np.random.default_rng(3)


def some(*shape: int) -> Floats:
    return rotation.normalize(RNG.normal(size=(*shape, 4)))


def apart(a: Floats, b: Floats) -> float:
    return float(np.abs(a - b).max())


def test_matrices_and_quaternions_are_those_of_the_rotations() -> None:
    q = some(7, 3)
    q[0, 0], q[0, 1], q[0, 2] = np.eye(4)[0], np.eye(4)[1], np.eye(4)[3]  # half turns, and none
    m = rotation.to_matrix(q)
    assert apart(leg_vectors.matrices(q), m) < 1e-14
    assert apart(rotation.to_matrix(leg_vectors.quaternions(m)), m) < 1e-14
    assert leg_vectors.quaternions(m[:0]).shape == (0, 3, 4)


def test_turning_after_is_a_product() -> None:
    first, then = some(6, 2), some(2)
    both = rotation.multiply(then, first)
    made = first.swapaxes(0, 1) @ leg_vectors.products(then)
    assert apart(made.swapaxes(0, 1), both) < 1e-14
    made = leg_vectors.squares(first.swapaxes(0, 1)) @ leg_vectors.matrix_products(then)
    assert apart(made.swapaxes(0, 1).reshape(6, 2, 3, 3), rotation.to_matrix(both)) < 1e-14
    angle = RNG.normal(size=6)
    turned = rotation.multiply(rotation.about_vertical(angle), first[:, 0])
    assert apart(leg_vectors.turned_about_up(angle, first[:, 0]), turned) < 1e-14
    assert apart(leg_vectors.about_up(angle), rotation.to_matrix(rotation.about_vertical(angle))) < 1e-14


def test_rotation_vectors_there_and_back() -> None:
    for size in (2.0, 1e-5, 1e-12, 0.0):
        v = size * vectors.unit(RNG.normal(size=(5, 2, 3)))
        assert apart(leg_vectors.exponentials(v), rotation.from_rotation_vector(v)) < 1e-14
        assert apart(leg_vectors.turned_by(v), rotation.to_matrix(rotation.from_rotation_vector(v))) < 1e-14
        start = rotation.to_matrix(some(5, 2))
        assert apart(leg_vectors.turns_between(start, leg_vectors.turned_by(v) @ start), v) < 1e-14 + 1e-9 * size


def test_vectors_are_multiplied_and_turned_onto_one_another() -> None:
    a, b = RNG.normal(size=(2, 5, 2, 3))
    assert apart(leg_vectors.cross(a, b), np.cross(a, b)) < 1e-14
    assert apart(leg_vectors.dot(a, b), vectors.dot(a, b)) < 1e-14
    assert apart(leg_vectors.between(a, b), rotation.to_matrix(rotation.between(a, b))) < 1e-12
    assert apart(leg_vectors.unit(np.zeros((2, 3))), np.zeros((2, 3))) == 0.0
