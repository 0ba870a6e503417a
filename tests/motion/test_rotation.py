"""Laws of rotations, with scipy as the oracle."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from footfix.motion import rotation

RNG = np.random.default_rng(7)
ORDERS = ["".join(order) for order in itertools.permutations("XYZ")]


def random_quaternions(n: int) -> np.ndarray:
    return Rotation.random(n, random_state=np.random.RandomState(3)).as_quat()


def same_rotation(a: np.ndarray, b: np.ndarray, tolerance: float = 1e-12) -> bool:
    return bool(np.all(np.abs(np.abs(np.sum(a * b, -1)) - 1.0) < tolerance))


@pytest.mark.parametrize("order", [*ORDERS, "X", "ZY", "", "ZXZ"])
def test_from_euler_is_scipys_intrinsic(order: str) -> None:
    angles = RNG.uniform(-7.0, 7.0, (50, len(order)))
    ours = rotation.from_euler(angles, order)
    theirs = Rotation.from_euler(order, angles).as_quat() if order else np.tile([0, 0, 0, 1.0], (50, 1))
    assert same_rotation(ours, theirs)


@pytest.mark.parametrize("order", ORDERS)
def test_euler_round_trip_on_any_branch(order: str) -> None:
    angles = RNG.uniform(-9.0, 9.0, (500, 3))
    back = rotation.to_euler(rotation.from_euler(angles, order), order, near=angles)
    assert np.allclose(back, angles, atol=1e-9)


@pytest.mark.parametrize("order", ORDERS)
@pytest.mark.parametrize("pole", [0.5 * np.pi, -0.5 * np.pi])
def test_gimbal_lock_keeps_the_rotation_and_the_last_angle(order: str, pole: float) -> None:
    angles = RNG.uniform(-3.0, 3.0, (50, 3))
    angles[:, 1] = pole
    q = rotation.from_euler(angles, order)
    near = angles + [0.3, 0.0, 0.2]
    back = rotation.to_euler(q, order, near=near)
    assert same_rotation(rotation.from_euler(back, order), q, 1e-11)
    assert np.allclose(back[:, 2], near[:, 2])


def test_group_axioms_and_action() -> None:
    a, b, c = random_quaternions(30), random_quaternions(30)[::-1], random_quaternions(31)[1:]
    v = RNG.normal(size=(30, 3))
    assert np.allclose(rotation.multiply(a, rotation.inverse(a)), rotation.identity((30,)))
    left = rotation.multiply(rotation.multiply(a, b), c)
    assert np.allclose(left, rotation.multiply(a, rotation.multiply(b, c)))
    assert np.allclose(rotation.rotate(rotation.multiply(a, b), v), rotation.rotate(a, rotation.rotate(b, v)))
    assert np.allclose(rotation.rotate(a, v), Rotation.from_quat(a).apply(v))


def test_matrix_and_rotation_vector_round_trips() -> None:
    q = np.concatenate([random_quaternions(100), np.eye(4), [[1e-9, 0, 0, 1.0]]])
    assert np.allclose(rotation.to_matrix(q), Rotation.from_quat(q).as_matrix())
    assert same_rotation(rotation.from_matrix(rotation.to_matrix(q)), q)
    vector = rotation.to_rotation_vector(q)
    assert np.allclose(rotation.from_rotation_vector(vector), Rotation.from_rotvec(vector).as_quat())
    assert same_rotation(rotation.from_rotation_vector(vector), q)
    assert np.allclose(rotation.angle(q), np.linalg.norm(vector, axis=-1))


def test_between_takes_one_direction_to_the_other() -> None:
    a, b = RNG.normal(size=(40, 3)), RNG.normal(size=(40, 3))
    b[0], b[1] = -a[0], a[1]
    turned = rotation.rotate(rotation.between(a, b), a / np.linalg.norm(a, axis=1, keepdims=True))
    assert np.allclose(turned, b / np.linalg.norm(b, axis=1, keepdims=True))


def test_slerp_ends_and_middle() -> None:
    a, b = random_quaternions(20), random_quaternions(20)[::-1]
    assert same_rotation(rotation.slerp(a, b, np.zeros(20)), a)
    assert same_rotation(rotation.slerp(a, b, np.ones(20)), b)
    middle = rotation.slerp(a, b, np.full(20, 0.5))
    whole = rotation.angle(rotation.multiply(rotation.inverse(a), b))
    assert np.allclose(rotation.angle(rotation.multiply(rotation.inverse(a), middle)), whole / 2)


def test_continuous_only_flips_signs() -> None:
    q = rotation.from_axis_angle(np.array([0.0, 1.0, 0.0]), np.linspace(0, 20, 200))
    flipped = q * np.where(RNG.random(200) < 0.5, -1.0, 1.0)[:, None]
    smooth = rotation.continuous(flipped)
    assert same_rotation(smooth, q)
    assert np.all(np.sum(smooth[1:] * smooth[:-1], -1) > 0)
