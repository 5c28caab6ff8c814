"""Numbers as people write them, with units, fractions and decimal commas, as bare numbers in SI units."""

from __future__ import annotations

import math
import re
import unicodedata

_TURN = math.pi / 180.0
# The SI unit of each unit, and how many of those one is.
UNITS: dict[str, tuple[str, float]] = {
    **{"km": ("m", 1e3), "m": ("m", 1.0), "dm": ("m", 1e-1), "cm": ("m", 1e-2), "mm": ("m", 1e-3), "μm": ("m", 1e-6)},
    **{"s": ("s", 1.0), "ms": ("s", 1e-3), "μs": ("s", 1e-6), "us": ("s", 1e-6)},
    **{"kN": ("N", 1e3), "N": ("N", 1.0), "cN": ("N", 1e-2), "mN": ("N", 1e-3), "μN": ("N", 1e-6)},
    **{"kg": ("kg", 1.0), "g": ("kg", 1e-3), "mg": ("kg", 1e-6)},
    **dict.fromkeys(("metre", "metres", "meter", "meters"), ("m", 1.0)),
    **dict.fromkeys(("in", "inch", "inches"), ("m", 0.0254)),
    **dict.fromkeys(("ft", "foot", "feet"), ("m", 0.3048)),
    **dict.fromkeys(("sec", "secs", "second", "seconds"), ("s", 1.0)),
    **dict.fromkeys(("min", "mins", "minute", "minutes"), ("s", 60.0)),
    **dict.fromkeys(("h", "hour", "hours"), ("s", 3600.0)),
    **dict.fromkeys(("newton", "newtons"), ("N", 1.0)),
    **dict.fromkeys(("Kg", "KG"), ("kg", 1.0)),
    **dict.fromkeys(("lb", "lbs"), ("kg", 0.45359237)),
    **dict.fromkeys(("rad", "radian", "radians"), ("rad", 1.0)),
    **dict.fromkeys(("°", "deg", "degree", "degrees"), ("rad", _TURN)),
    **{"mrad": ("rad", 1e-3), "Hz": ("Hz", 1.0), "kHz": ("Hz", 1e3), "%": ("1", 1e-2)},
    **{"m/s": ("m/s", 1.0), "cm/s": ("m/s", 1e-2), "mm/s": ("m/s", 1e-3)},
    **{"m/N": ("m/N", 1.0), "cm/N": ("m/N", 1e-2), "mm/N": ("m/N", 1e-3)},
    **{"N/m": ("N/m", 1.0), "N/mm": ("N/m", 1e3), "N/cm": ("N/m", 1e2)},
    **{"kg/m3": ("kg/m³", 1.0), "g/cm3": ("kg/m³", 1e3)},
    **dict.fromkeys(("Nm", "N·m", "N*m", "N m"), ("N·m", 1.0)),
    **dict.fromkeys(("mNm", "mN·m", "mN*m", "mN m", "Nmm", "N·mm", "N*mm"), ("N·m", 1e-3)),
}

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
