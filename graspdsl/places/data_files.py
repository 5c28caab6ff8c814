"""Files of data that come with the package, in YAML: read fast and without places, for their faults are nobody's."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

# libyaml's, which is some ten times faster, where PyYAML was built with it.
_LOADER: Any = getattr(yaml, "CSafeLoader", yaml.SafeLoader)


def data_in(path: Path) -> Any:
    """What a YAML file of the package holds."""
    return yaml.load(path.read_text("utf-8"), _LOADER)
