"""Branches of steady motions: the time to follow 200 points with their multipliers, and whole diagrams.

Medians of warm calls, with the time of all cores beside them. A branch runs on one core: a point takes a few maps, one
after the other, each with its tangents on the lanes of one call.
"""

import vibrocap as vc
from benchmarks.attractors import capsule, timed

POINTS = 200
ASKED = 3.0  # seconds, EM


def main() -> None:
    """Print times and what was found."""
    print(f"\nFollowing {POINTS} points of a branch with multipliers: at most {ASKED:g} s for EM")
    print(f"  {'':44s}{'s':>8s}{'core s':>8s}{'points':>8s}{'special':>9s}")
    for name, law in (("EM", vc.Exponential()), ("LM", vc.LuGre())):
        system = capsule(law)
        travelling = vc.orbit(system, initial={"angle": 1.0})
        symmetric = vc.shoot(system, travelling.state, half=True)
        for label, start, over, between, step in (
            ("symmetric, amplitude 1 to 3", symmetric, "drive.amplitude", (1.0, 3.0), 0.01),
            ("travelling, amplitude to both its ends", travelling, "drive.amplitude", (1.0, 3.0), 0.0045),
        ):  # fmt: skip

            def run(start=start, over=over, between=between, step=step, system=system) -> vc.Branch:
                return vc.branch(system, over, between, orbit=start, step=step)

            spent, cores, found = timed(run)
            assert isinstance(found, vc.Branch)
            row = f"{spent:8.2f}{cores:8.2f}{len(found):8d}{len(found.special_points):9d}"
            print(f"  {f'{name}, {label}':44s}{row}")
        whole = (system, "drive.amplitude", (1.0, 3.0))
        spent, cores, diagram = timed(lambda whole=whole: vc.branches(*whole, initial={"angle": 1.0}))
        assert isinstance(diagram, vc.BranchDiagram)
        points, special = sum(map(len, diagram.branches)), len(diagram.table())
        print(f"  {f'{name}, whole diagram, amplitude 1 to 3':44s}{spent:8.2f}{cores:8.2f}{points:8d}{special:9d}")
    _cycles()
    _crossings()


def _cycles() -> None:
    """Cycles that nothing drives in time, their period among the unknowns."""
    machine = vc.Oscillator(mass=1.0, stiffness=2.0, damping=0.0, belt_speed=0.1)
    belt = vc.System(machine, vc.Coulomb(static_coefficient=1.5, coulomb_coefficient=1.0), vc.Constant())
    spent, cores, found = timed(lambda: vc.branch(belt, "machine.belt_speed", (0.05, 0.5), settle_periods=200))
    assert isinstance(found, vc.Branch)
    row = f"{spent:8.2f}{cores:8.2f}{len(found):8d}{len(found.special_points):9d}"
    print(f"  {'block on a belt, belt speed 0.05 to 0.5':44s}{row}")


def _crossings() -> None:
    """Zeros of the steady drift over the mass ratio, from a scan of 200 settled motions."""
    for name, law in (("EM", vc.Exponential()), ("LM", vc.LuGre())):
        system = capsule(law, stiffness=0.58, damping=1.2)
        options = {"initial": {"angle": 1.0}, "points": POINTS}
        spent, cores, found = timed(
            lambda system=system, options=options: vc.crossing(
                system, "drift", "machine.mass_ratio", (0.2, 8.1), **options
            )
        )
        assert isinstance(found, vc.Crossings)
        print(
            f"  {f'{name}, zero of the drift over the mass ratio':44s}{spent:8.2f}{cores:8.2f}"
            f"{POINTS:8d}{len(found.places):9d}"
        )


if __name__ == "__main__":
    main()
