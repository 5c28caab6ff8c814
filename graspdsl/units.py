"""Numbers as people write them, with units, fractions and decimal commas, as bare numbers in SI units."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping

# By SI unit: what else people write, and how many of the SI unit that is.
_SIZES: Mapping[str, Mapping[str, float]] = {
    "m": {
        "km": 1e3,
        "m": 1.0,
        "dm": 1e-1,
        "cm": 1e-2,
        "mm": 1e-3,
        "μm": 1e-6,
        "in": 0.0254,
        "inch": 0.0254,
        "ft": 0.3048,
    }
    | dict.fromkeys(("metre", "metres", "meter", "meters"), 1.0),
    "s": {"s": 1.0, "ms": 1e-3, "μs": 1e-6, "us": 1e-6, "min": 60.0, "h": 3600.0}
    | dict.fromkeys(("sec", "secs", "second", "seconds"), 1.0)
    | dict.fromkeys(("mins", "minute", "minutes"), 60.0),
    "N": {"kN": 1e3, "N": 1.0, "cN": 1e-2, "mN": 1e-3, "μN": 1e-6, "newton": 1.0, "newtons": 1.0},
    "kg": {"kg": 1.0, "Kg": 1.0, "KG": 1.0, "g": 1e-3, "mg": 1e-6, "lb": 0.45359237, "lbs": 0.45359237},
    "rad": {"rad": 1.0, "mrad": 1e-3, "radian": 1.0, "radians": 1.0}
    | dict.fromkeys(("°", "deg", "degree", "degrees"), math.pi / 180.0),
    "N·m": dict.fromkeys(("Nm", "N·m", "N*m", "N m"), 1.0)
    | dict.fromkeys(("mNm", "mN·m", "mN m", "Nmm", "N·mm"), 1e-3),
    "m/s": {"m/s": 1.0, "cm/s": 1e-2, "mm/s": 1e-3},
    "m/N": {"m/N": 1.0, "cm/N": 1e-2, "mm/N": 1e-3},
    "N/m": {"N/m": 1.0, "N/cm": 1e2, "N/mm": 1e3},
    "kg/m³": {"kg/m3": 1.0, "g/cm3": 1e3},
    "Hz": {"Hz": 1.0, "kHz": 1e3},
    "1": {"%": 1e-2},
}
UNITS = {name: (unit, size) for unit, sizes in _SIZES.items() for name, size in sizes.items()}

_PLAIN = r"[+-]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_NUMBER = re.compile(rf"({_PLAIN}) ?([^\s0-9.,].*)?")
# Not 1,000: who knows which comma that is.
_DECIMAL_COMMA = re.compile(r"(?<![0-9.,])([+-]?(?:0*|[0-9]+(?![0-9]*,[0-9]{3}(?![0-9])))),([0-9]+)(?![0-9.,])")
_THOUSANDS = re.compile(r"(?<![0-9.,])[0-9]{1,3}(?:[ _'’][0-9]{3})+(?![0-9])")
_OF_PI = re.compile(rf"([+-]?)({_PLAIN})?[ *·]*(?:π|pi)(?: ?/ ?({_PLAIN}))?", re.IGNORECASE)
_FRACTION = re.compile(rf"({_PLAIN}) ?/ ?({_PLAIN})")
_SIGNS = str.maketrans("−–‐⁄⋅×º˚", "---/··°°")
LONGEST = 60  # characters


def number_meant(text: str) -> tuple[float, str | None] | None:
    """The number that a text means, in SI units, and its SI unit if it has one; None for any other text.

    ``5 mm`` is 0.005 and m, ``30,5`` is 30.5, ``π/2`` is 1.5708.
    """
    if len(text) > LONGEST:
        return None
    plain = unicodedata.normalize("NFKC", text.translate(_SIGNS)).translate(_SIGNS).strip()
    plain = _THOUSANDS.sub(lambda found: re.sub("[ _'’]", "", found.group()), plain)
    plain = _DECIMAL_COMMA.sub(r"\1.\2", plain)
    if found := _NUMBER.fullmatch(plain):
        number, unit = float(found.group(1)), (found.group(2) or "").strip()
        if not unit:
            return _finite(number, None)
        si = UNITS.get(unit) or (UNITS.get(unit.lower()) if len(unit) > 2 else None)
        if si is not None:
            return _finite(number * si[1], si[0])
    if found := _OF_PI.fullmatch(plain):
        sign, factor, divisor = found.groups()
        return _divided(float(factor or 1.0) * (-1.0 if sign == "-" else 1.0) * math.pi, divisor or "1", "rad")
    if found := _FRACTION.fullmatch(plain):
        return _divided(float(found.group(1)), found.group(2), None)
    return None


def _divided(number: float, divisor: str, unit: str | None) -> tuple[float, str | None] | None:
    return _finite(number / float(divisor), unit) if float(divisor) else None


def _finite(number: float, unit: str | None) -> tuple[float, str | None] | None:
    return (number, unit) if math.isfinite(number) else None
