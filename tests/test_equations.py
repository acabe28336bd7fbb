"""The equations of motion that the package writes from a description, read back, against papers and machines."""

import random
import re

import pytest
import sympy as sp

import vibrocap as vc
from mechanisms import MECHANISMS
from vibrocap.cli.main import main
from vibrocap.physics.catalogue import machines
from vibrocap.physics.equations import _symbols, equations_of
from vibrocap.physics.parameters import parameter_table
from vibrocap.physics.symbols import printed

TOKEN = re.compile(r"\d+(?:\.\d+)?(?:e-?\d+)?|[^\W\d]\w*'*|[-+^/()]")
FUNCTIONS = ("sin", "cos", "sqrt", "exp", "tanh", "atan")


def read(text, known):
    """What a side of an equation says: its symbols as they stand in `known`, beside each other multiplied."""
    texts, before = [], ""
    for token in TOKEN.findall(text):
        named = token not in "-+^/()"
        if (named or token == "(") and before and before not in ("-", "+", "^", "/", "(", *FUNCTIONS):
            texts.append("*")
        texts.append("**" if token == "^" else token if not named or token[0].isdigit() else f"known[{token!r}]")
        before = token
    return eval("".join(texts), {"known": known})


def test_equation_9_of_the_paper_follows():
    """Liu et al. 2019: the accelerations of pendulum and capsule, and equation 4 as it is printed before them."""
    names = ("λ", "ρ", "ν", "θ", "θ'", "θ''", "X''", "R", "drive", "N")
    known = dict(zip(names, sp.symbols("lambda rho nu theta w a A R P_0 N"), strict=True))
    known |= {"sin": sp.sin, "cos": sp.cos}
    lam, rho, nu, theta, w, a, A, R, drive, _ = (known[name] for name in names)
    equations = equations_of(vc.PendulumCapsule(normal_load="dynamic"))
    first, second, load = (
        [read(side, known) for side in line.split(" = ")] for line in (*equations.motion, *equations.loads)
    )
    assert sp.expand(first[0] - (a - sp.cos(theta) * A)) == 0
    assert sp.expand(first[1] - (sp.sin(theta) + drive - rho * theta - nu * w)) == 0
    solution = sp.solve([first[0] - first[1], second[0] - second[1]], [a, A])
    P, B = drive + sp.sin(theta) - rho * theta - nu * w, lam + 1 - sp.cos(theta) ** 2
    angle = ((lam + 1) * P - sp.sin(theta) * sp.cos(theta) * w**2 - R * sp.cos(theta)) / B
    capsule = (sp.cos(theta) * P - sp.sin(theta) * w**2 - R) / B
    assert sp.simplify(solution[a] - angle) == 0
    assert sp.simplify(solution[A] - capsule) == 0
    assert sp.simplify(load[1] - (lam + 1 - sp.sin(theta) * a - sp.cos(theta) * w**2)) == 0


@pytest.mark.parametrize("kind", [*machines().values(), *MECHANISMS], ids=lambda kind: kind.name)
def test_what_is_written_holds_along_motions(kind):
    """Both sides of every line, at random numbers: the rates, loads and energy are those that the machine computes."""
    draw, drive = random.Random(2), vc.Biharmonic(0.2, 1.3, 0.1, 0.4)
    machine = kind().driven_by(drive)
    derived, written = machine._form()[0].derived, equations_of(machine)
    symbols = _symbols(machine, derived)
    assert len({*symbols.values()}) == len(symbols), "two quantities have one symbol"
    for _ in range(3):
        t, force = draw.uniform(0.0, 6.0), draw.uniform(-1.0, 1.0)
        y = [draw.uniform(-0.1, 0.1) if name not in kind.switched else 1.0 for name in kind.states]
        frictions = [draw.uniform(-0.5, 0.5) for _ in kind.contact_states]
        numbers = [v for v in (getattr(machine, i.name) for i in parameter_table(kind)) if isinstance(v, (int, float))]
        values = [t, force, 1.0, 0.0, *numbers, *y, *frictions]
        for wave in [machine.imposed] if kind.imposes_motion else [signal.default for signal in kind.signals.values()]:
            values += [wave.value(t), wave.slope(t), wave.curvature(t)]
        known = {printed(symbol): values[at] for at, symbol in symbols.items()}
        rates = dict(zip(kind.states, machine.rates(t, tuple(y), force, tuple(frictions)), strict=True))
        for name in derived.names:
            at = derived.inputs.states[kind.states.index(derived.rates[name])].operands[0]
            own = symbols[derived.inputs.states[kind.states.index(name)].operands[0]]
            known[printed(f"{symbols[at]}'")] = rates[derived.rates[name]]
            known.setdefault(printed(f"{own}'"), rates[name])
        known |= {name: getattr(__import__("math"), name) for name in FUNCTIONS}
        contacts = machine.contacts(t, tuple(y), force)
        for i, (contact, fixed) in enumerate(zip(contacts, machine.loads(), strict=True), start=1):
            load = fixed
            if machine.follows_load:
                n, *slopes = contact.reaction
                load = n + sum(s * r for s, r in zip(slopes, frictions, strict=True))
            name = f"N_{i}" if len(contacts) > 1 else "N"
            known[printed(name.replace("N", "load") if name in symbols.values() else name)] = load
        known["H"] = machine.energy(t, tuple(y))
        for at, force_of in enumerate(machine.actuator(t, tuple(y), tuple(frictions)).values(), start=1):
            known[printed("F_a" if at == 1 else f"F_a{at}")] = force_of
        held = {line for line in written.motion if any(stop.rigid for stop in derived.stops)}
        for line in (line for line in written.lines if line not in held):
            left, right = (read(side, known) for side in line.split(" = "))
            assert left == pytest.approx(right, rel=1e-10, abs=1e-10), line


def test_the_command_lists_and_shows_machines(capsys):
    assert main(["list", "machines"]) == 0
    assert all(name in capsys.readouterr().out for name in ("pendulum-capsule",))
    assert main(["list", "clutch"]) == 0
    shown = capsys.readouterr().out
    assert "N = a drive + N₀" in shown
    assert "engine_inertia" in shown
    assert main(["list", "machines", "examples/weight-as-load.toml", "--latex"]) == 0
    assert r"\theta'' - X''\,\cos\left(\theta\right) = " in capsys.readouterr().out
    assert main(["list", "pendulum", "--json"]) == 2
    assert "is called 'pendulum'; did you mean 'pendulum-crawler'" in capsys.readouterr().err
