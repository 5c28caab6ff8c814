"""Trajectories made by hand."""

from __future__ import annotations

import numpy as np

from graspdsl.trials.trajectories import Rows


def whole_rows(ticks: int, contacts: int = 3, joints: int = 10, levels: int = 2) -> Rows:
    """A trajectory that any reader takes, of a hand that stands still and touches nothing."""
    shapes = {
        **dict.fromkeys(("phase", "stage", "force_residual", "moment_residual"), ()),
        "touching": (contacts,),
        "joints": (joints,),
        "observed_disturbance": (levels,),
        **dict.fromkeys(("points", "normals", "forces"), (contacts, 3)),
        "object_position": (3,),
        "object_rotation": (3, 3),
    }
    zeros = {name: np.zeros((ticks, *shape), np.float32) for name, shape in shapes.items()}
    return {"tick": np.arange(ticks, dtype=np.float32), "time": np.arange(ticks, dtype=np.float32) / 50, **zeros}
