"""A second call does only what its case needs: it imports no other part, no other command and no writer of kernels.

And the kernel that it finds without writing its text is the one that was made of that text.
"""

import json
import os
import subprocess
import sys

import pytest

import vibrocap as vc
from cases import DEFAULTS
from vibrocap.motion.recording.equations import equations
from vibrocap.numerics import linker as link
from vibrocap.numerics.run import motion

CASE = f"{DEFAULTS}amplitude = 1.8\n"
CALL = """import json, sys
from vibrocap.cli.main import main
code = main(["simulate", "case.toml", "--periods", "2", "--json"])
print(json.dumps([code, sorted(name for name in sys.modules if name.startswith("vibrocap."))]), file=sys.stderr)
"""


def call(folder):
    """(what the command printed, modules of the package that it imported)."""
    environment = os.environ | {"VIBROCAP_CACHE": str(folder / "cache")}
    done = subprocess.run([sys.executable, "-c", CALL], cwd=folder, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    code, modules = json.loads(done.stderr.splitlines()[-1])
    assert code == 0
    return done.stdout, set(modules)


def in_room(modules, room):
    return {name.rpartition(".")[2] for name in modules if name.rpartition(".")[0] == f"vibrocap.{room}"}


@pytest.mark.slow
def test_a_second_call_writes_no_kernel_and_imports_what_its_case_needs(tmp_path):
    (tmp_path / "case.toml").write_text(CASE)
    first, before = call(tmp_path)
    second, after = call(tmp_path)
    assert second == first
    assert in_room(before, "numerics.codegen")
    assert not in_room(after, "numerics.codegen")
    assert in_room(after, "cli.commands") == {"simulate"}
    assert in_room(after, "physics.friction") == {"law", "curves"}
    assert {"phases", "scheduled", "loadings"}.isdisjoint(in_room(after, "physics.drives"))
    assert {"rows", "linkage_crawler", "vibrated_bodies"}.isdisjoint(in_room(after, "physics.machines"))


def key(system, order=12, literal=False):
    recorded = equations(system)
    return link.kernel_key(recorded, motion.motion_layout(recorded, order), literal=literal)


SYSTEM = vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Harmonic(amplitude=1.8))


def test_kernels_that_differ_have_other_keys():
    """By law, machine, drive, load, order; parameters are numbers of the vector, which every kernel is given."""
    others = [
        vc.System(vc.PendulumCapsule(), vc.Stribeck(), vc.Harmonic()),
        vc.System(vc.PendulumCapsule(normal_load="dynamic"), vc.Exponential(), vc.Harmonic()),
        vc.System(vc.PendulumCapsule(), vc.Exponential(), vc.Square()),
        vc.System(vc.TwoMassCapsule(), vc.Exponential(), vc.Harmonic()),
    ]
    keys = [key(SYSTEM), key(SYSTEM, order=10), key(SYSTEM, literal=True), *map(key, others)]
    assert len(set(keys)) == len(keys)
    assert key(vc.System(vc.PendulumCapsule(mass_ratio=3.0), vc.Exponential(), vc.Harmonic(amplitude=0.7))) == keys[0]


@pytest.mark.parametrize("what", ["the numerics", "a module of the records"])
def test_another_version_of_the_code_has_other_keys(what, monkeypatch):
    before = key(SYSTEM)
    if what == "the numerics":
        from vibrocap.numerics import compiler

        monkeypatch.setattr(compiler, "source_hash", lambda folder: "another")
    else:
        monkeypatch.setattr(link, "_text_hash", lambda module: "another")
    assert key(SYSTEM) != before


def test_nodes_recorded_later_change_no_key():
    """Measures of one's own are recorded on the graph of the equations."""
    before = key(SYSTEM)
    graph = equations(SYSTEM).graph
    graph.node("state", 0) * graph.node("state", 1) + 17.25
    assert key(SYSTEM) == before
