"""The spec that the tests start from."""

from __future__ import annotations

import pytest

GOOD = """\
graspdsl: 1
name: towel-roll-two-contacts
about: Experiment 1. The thumb against a virtual finger, on a standing towel roll.
scene:
  world: bullet                    # bullet | floating
  hand: barrett
  mount: gantry
  object: towel-roll
  friction: 0.4
  sensing: load-cell
resources:
  γ1: finger-3
  γ2: finger-1
  γ3: finger-2
  Γ: "{γ1, <γ2,γ3>}"
parameters: {κ_f: 0.5, x_ref: [0.1, 0, 1e-3]}
controllers:
  π_mine|Γ_τ Γ_σ: φ_fr|τ_fr(Γ_τ) σ_fr(Γ_σ)
  π_two|Γ Γ: {is: "π_mine|Γ Γ ◁ π_fr|Γ Γ", equation: "4.30", about: both}
program:
  - run: π_close|Γ Γ
    until: {contact: all, hold: 0.2}
    limit: 8.0                     # s
  - run: π_s|Γ Γ (π_gx|Γ Γ)
    until: {force_residual: 0.1, moment_residual: 0.005, hold: 1.0}
    limit: 30
evaluate: [force-closure, ferrari-canny, lift, shake]
trials:
  count: 58
  seed: 2006
  start:
    approach: side
    roll: {uniform: [-1.5, 1.5]}
    height: {uniform: [0.06, 0.16]}
    standoff: 0.047
"""


@pytest.fixture(scope="session")
def good() -> str:
    """The text of a spec without a fault."""
    return GOOD
