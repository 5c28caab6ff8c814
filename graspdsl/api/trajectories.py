"""The trajectory of a trial: its arrays, a row a tick, with what each tells and its unit."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from graspdsl.arrays import Float32Array
from graspdsl.diagnostics import known_names_hint
from graspdsl.trials.trajectories import CHANNELS


class Trajectory(Mapping[str, Float32Array]):
    """The arrays of a trial by name, read-only, their first axis the ticks; none where it ended before its first tick.

    ``units``: the SI unit of each; ``about``: what each tells; ``axes``: its axes, ``("ticks", "contacts", 3)``.
    """

    def __init__(self, arrays: Mapping[str, Float32Array]) -> None:
        self._arrays = dict(arrays)
        for array in self._arrays.values():
            array.flags.writeable = False

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each array."""
        return {name: CHANNELS[name].unit for name in self}

    @property
    def about(self) -> dict[str, str]:
        """What each array tells."""
        return {name: CHANNELS[name].about for name in self}

    @property
    def axes(self) -> dict[str, tuple[int | str, ...]]:
        """The axes of each array: what there is one of in each place, or how many numbers."""
        return {name: ("ticks", *CHANNELS[name].axes) for name in self}

    def __getitem__(self, name: str) -> Float32Array:
        try:
            return self._arrays[name]
        except KeyError:
            raise KeyError(f"there is no {name!r}; {known_names_hint(name, self, 'arrays')}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._arrays)

    def __len__(self) -> int:
        return len(self._arrays)

    def __repr__(self) -> str:
        rows = (f"{name} {array.shape} [{CHANNELS[name].unit}]" for name, array in self.items())
        return f"<Trajectory: {', '.join(rows)}>"
