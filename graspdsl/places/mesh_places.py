"""Where the meshes are that a URDF names: beside it, or in a package of ROS, which is a folder."""

from __future__ import annotations

import os
from functools import cached_property
from pathlib import PurePosixPath

from graspdsl.diagnostics import DiagnosticError, listed
from graspdsl.places.files import SpecFolder, refusal
from graspdsl.places.wording import shortened

PACKAGE = "package://"
MANIFEST = "package.xml"  # stands in the folder of a package
MOST_PLACES = 8  # that a complaint lists


class MeshPlaces:
    """The meshes of one URDF, which is named as a spec names files.

    A ``package://name/path`` is looked for in the folders about the URDF, up to that of the spec: first in one that
    bears the package's name, then in one that holds a package.xml, then in each, the nearest first, with the package's
    name before the path and without; then in the folders of ROS_PACKAGE_PATH.
    """

    def __init__(self, files: SpecFolder, urdf: str) -> None:
        self._files, self._urdf = files, urdf
        here = PurePosixPath(urdf).parent
        self._folders = (here, *here.parents)

    def name(self, mesh: str) -> str:
        """The path of a mesh as a spec would name it.

        Raises DiagnosticError for an absolute path in a URDF that the spec names by a relative one, and for a file of a
        package that is in none of these places.
        """
        if mesh.startswith(PACKAGE):
            return self._in_package(mesh)
        path = self._folders[0] / mesh.removeprefix("file://")
        if path.is_absolute() and not self._folders[0].is_absolute():
            message = f"{self._urdf} names a file outside of the folder of the spec: {path}"
            raise refusal("outside-of-folder", message, "write the absolute path of the URDF itself")
        return str(path)

    def _in_package(self, mesh: str) -> str:
        package, _, rest = mesh.removeprefix(PACKAGE).partition("/")
        rest = rest.lstrip("/")  # or it would be an absolute path
        named = [folder / rest for folder in self._folders if folder.name == package]
        marked = [folder / rest for folder in self._packages]
        around = [place for folder in self._folders for place in (folder / package / rest, folder / rest)]
        paths = filter(os.path.isabs, os.environ.get("ROS_PACKAGE_PATH", "").split(os.pathsep))
        elsewhere = [PurePosixPath(path, package, rest) for path in paths]
        places = list(dict.fromkeys(map(str, named + marked + around + elsewhere)))
        found = next(filter(self._exists, places), None)
        if found is None:
            more = ["so on"] if len(places) > MOST_PLACES else []
            hint = f"looked for {listed([*map(shortened, places[:MOST_PLACES]), *more])}, from the folder of the spec"
            raise refusal("file-not-found", f"there is no file {shortened(mesh)}", hint)
        return found

    @cached_property
    def _packages(self) -> tuple[PurePosixPath, ...]:
        """The nearest folder with a manifest. It is read, so that it is among the copies of what the spec names."""
        for folder in self._folders:
            manifest = str(folder / MANIFEST)
            if self._exists(manifest):
                self._files.read(manifest)
                return (folder,)
        return ()

    def _exists(self, name: str) -> bool:
        try:
            return os.path.exists(self._files.place(name))
        except DiagnosticError:
            return False
