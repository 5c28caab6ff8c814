"""Where PyBullet is not installed, a test that asks for it is skipped at that very moment, and all others are run."""

from __future__ import annotations

import importlib.util
import sys
from collections.abc import Sequence
from importlib.abc import MetaPathFinder
from types import ModuleType

import pytest

ENGINE = "pybullet"


class _NotInstalled(MetaPathFinder):
    """Is asked after all other finders, for what they have not found."""

    def find_spec(self, name: str, path: Sequence[str] | None, target: ModuleType | None = None) -> None:
        """Nothing is found, but the test ends where it is the engine or its data."""
        del path, target
        if name.startswith(ENGINE):
            pytest.skip(f"needs {ENGINE}, which this Python has not", allow_module_level=True)


if importlib.util.find_spec(ENGINE) is None:
    sys.meta_path.append(_NotInstalled())
