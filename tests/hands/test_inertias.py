"""Moments of inertia of a model, held against what the engine keeps of them and which joints it then moves."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from graspdsl.models.urdf_text import urdf_text
from graspdsl.worlds.bullet.engine import pybullet, silenced

from .models import model_of

TARGET = 0.5
TICKS = 240
NO_MOMENTS = (0.0, 0.0, 0.0)
LIMIT = '<limit lower="-1" upper="1" effort="1" velocity="10"/>'


def _inertia(moments: Iterable[str], products: Iterable[str] = ("0", "0", "0")) -> str:
    pairs = zip(("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), [*moments, *products], strict=True)
    return f"<inertia {' '.join(f'{key}={json.dumps(value)}' for key, value in pairs)}/>"


def _link(name: str, inertia: str, mass: float = 0.1, place: str = "0 0 0") -> str:
    return f'<link name="{name}"><inertial><origin xyz="{place}"/><mass value="{mass}"/>{inertia}</inertial></link>'


def _joint(name: str, parent: str, child: str, kind: str = "revolute", axis: str = "0 0 1", origin: str = "") -> str:
    ends = f'<parent link="{parent}"/><child link="{child}"/>{origin}'
    return f'<joint name="{name}" type="{kind}">{ends}<axis xyz="{axis}"/>{LIMIT}</joint>'


BASE = _link("base", _inertia(["1e-3"] * 3), 1.0)
SOUND = _inertia(["1e-5"] * 3)


def _finger(inertia: str, kind: str = "revolute", place: str = "0 0 0") -> str:
    return (
        f"<robot name='h'>{BASE}{_link('finger', inertia, place=place)}{_joint('bend', 'base', 'finger', kind)}</robot>"
    )


@contextmanager
def _loaded(urdf: str, folder: Path) -> Iterator[tuple[Any, int, int]]:
    """A model as the world loads it, without gravity: the engine, its client, the body."""
    (folder / "model.urdf").write_text(urdf, encoding="utf-8")
    engine = pybullet()
    client = engine.connect(engine.DIRECT)
    try:
        with silenced():
            body = engine.loadURDF(
                str(folder / "model.urdf"),
                useFixedBase=True,
                flags=engine.URDF_USE_INERTIA_FROM_FILE,
                physicsClientId=client,
            )
        yield engine, client, body
    finally:
        engine.disconnect(client)


def _driven(urdf: str, folder: Path) -> tuple[tuple[float, ...], float]:
    """The principal moments that the engine has of the first moved link, and where its joint, driven, comes to."""
    with _loaded(urdf, folder) as (engine, client, body):
        moments = engine.getDynamicsInfo(body, 0, client)[2]
        engine.setJointMotorControl2(
            body, 0, engine.POSITION_CONTROL, targetPosition=TARGET, force=1.0, physicsClientId=client
        )
        for _ in range(TICKS):
            engine.stepSimulation(client)
        return moments, engine.getJointState(body, 0, client)[0]


def _checked(urdf: str) -> str:
    return urdf_text(model_of(urdf))


def _rounded(numbers: Iterable[float], digits: int) -> list[str]:
    return [f"{number:.{digits - 1}e}" for number in numbers]


def _flat_bodies() -> Iterator[tuple[list[str], list[str]]]:
    """Moments and products of plates and rods: of three digits along the axes of the link, of four turned from them."""
    draw = np.random.default_rng(5)
    for number in range(24):
        one, other = 10.0 ** draw.uniform(-7, -3) * draw.uniform(0.2, 1.0, 2)
        moments = np.array([one, other, one + other] if number % 2 else [one, one, 0.0])
        turn = np.linalg.qr(draw.normal(size=(3, 3)))[0]
        tensor = turn * moments @ turn.T
        if number % 2:
            yield _rounded(moments, 3), ["0", "0", "0"]
        yield _rounded(np.diag(tensor), 4), _rounded(tensor[[0, 0, 1], [1, 2, 2]], 4)


@pytest.mark.slow
def test_rounded_moments_of_flat_bodies_are_kept_and_driven(tmp_path: Path) -> None:
    mended = 0
    for moments, products in _flat_bodies():
        urdf = _finger(_inertia(moments, products), place="0 0.01 0")
        kept, place = _driven(_checked(urdf), tmp_path)
        xx, yy, zz, xy, xz, yz = map(float, [*moments, *products])
        written = np.linalg.eigvalsh([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        np.testing.assert_allclose(np.sort(kept), written, atol=1e-2 * written[-1])
        assert place == pytest.approx(TARGET, abs=1e-3)
        mended += _driven(urdf, tmp_path)[0] == NO_MOMENTS
    assert mended > 0  # as written the engine drops some of them


def test_rounded_moments_of_a_thin_plate_about_its_own_axis(tmp_path: Path) -> None:
    urdf = _finger(_inertia(["1e-5", "1e-5", "2.0000001e-5"]))
    assert _driven(urdf, tmp_path) == (NO_MOMENTS, 0.0)
    kept, place = _driven(_checked(urdf), tmp_path)
    np.testing.assert_allclose(kept, [1e-5, 1e-5, 2e-5], rtol=1e-6)
    assert place == pytest.approx(TARGET, abs=1e-3)


def test_a_plate_in_mjcf_is_kept_and_driven(tmp_path: Path) -> None:
    inertial = '<inertial pos="0 0 0" mass="0.1" diaginertia="1e-5 1e-5 2.00000005e-5"/>'
    body = f'<body name="p">{inertial}<body name="f">{inertial}<joint name="j" range="0 90"/></body></body>'
    kept, place = _driven(_checked(f"<mujoco><worldbody>{body}</worldbody></mujoco>"), tmp_path)
    np.testing.assert_allclose(kept, [1e-5, 1e-5, 2e-5], rtol=1e-6)
    assert place == pytest.approx(TARGET, abs=1e-3)


def test_sound_moments_stay_as_they_are_written() -> None:
    found = model_of(_finger(_inertia(["1.23e-5", "2e-5", "3e-5"])))
    np.testing.assert_allclose(found.links["finger"].inertia, np.diag([1.23e-5, 2e-5, 3e-5]), atol=1e-19)
    assert found.warnings == ()


FROZEN = {
    "moments of no body": _finger(_inertia(["1e-5", "1e-5", "1e-4"])),
    "none about the axis": _finger(_inertia(["1e-5", "1e-5", "0"])),
    "as good as none about the axis": _finger(_inertia(["1e-5", "1e-5", "1e-16"])),
    "none": _finger(_inertia(["0"] * 3)),
    "only about an axis that turns freely": (
        f"<robot name='h'>{BASE}{_link('between', _inertia(['0'] * 3), 0.0)}{_link('finger', SOUND)}"
        f"{_joint('bend', 'base', 'between')}{_joint('free', 'between', 'finger')}</robot>"
    ),
}


@pytest.mark.parametrize("name", FROZEN)
def test_what_the_engine_would_hold_still_is_mended(name: str, tmp_path: Path) -> None:
    assert _driven(FROZEN[name], tmp_path)[1] == 0.0
    assert _driven(_checked(FROZEN[name]), tmp_path)[1] == pytest.approx(TARGET, abs=1e-3)


MOVED = {
    "none about the axis, but a lever": _finger(_inertia(["1e-5", "1e-5", "0"]), place="0.02 0 0"),
    "a cross without mass": (
        f"<robot name='h'>{BASE}{_link('between', _inertia(['0'] * 3), 0.0)}{_link('finger', SOUND)}"
        f"{_joint('bend', 'base', 'between')}{_joint('free', 'between', 'finger', axis='0 1 0')}</robot>"
    ),
}


@pytest.mark.parametrize("name", MOVED)
def test_what_the_engine_moves_stays(name: str, tmp_path: Path) -> None:
    assert _driven(_checked(MOVED[name]), tmp_path)[1] == pytest.approx(TARGET, abs=1e-3)
