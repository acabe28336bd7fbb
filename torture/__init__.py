"""Attacks on the package, with seeds: kills, links, settings, waits, damage, full disks, fuzzed cases, commands, pairs.

`python -m torture` (`make torture`) runs them all and prints a table; docs/trust.md keeps its
figures and says which promise each of them tests. Nothing here is part of the package.
"""

import sys
from pathlib import Path

TESTS = Path(__file__).parents[1] / "tests"
if str(TESTS) not in sys.path:
    sys.path.append(str(TESTS))  # the stand-in for the engine, which the tests use too
