"""A sweep of the vibro-impact capsule beside heyoka.py's batch integrator with hand-written events.

The capsule of Liu et al. 2013 over its mass ratio strikes its stop, sticks and slips. Both run at equal measured error.
As in `sweep_peers_heyoka.py` the modes are parameters of the integrator, switched in the events' callbacks: one event
means that stick or slip ends, one that the stop is reached or left.

In ten of the thousand runs heyoka loses an event, at rounding level too, and the motion parts from ours; the closed
form of these motions (tests/exact_stops.py) has as many impacts as ours. Where a slide starts 1e-15 inside its mode
instead of 1e-12 there are twelve. So 99 % of the runs tell the error.

`python -m benchmarks impacts` prints medians of alternating runs on one thread.
"""

import dataclasses
import math
import statistics
import time
from collections.abc import Callable
from typing import Any

import numpy as np

import vibrocap as vc
from benchmarks.named_sweeps import ERROR_ASKED, SHARE_ASKED
from vibrocap.motion.recording.equations import equations, parameter_values
from vibrocap.numerics.run.budget import Budget, EnsembleStart
from vibrocap.numerics.run.ensemble import ensemble_run

MACHINE = vc.VibroImpactCapsule()
DRIVE = vc.Harmonic(amplitude=1.6, frequency=0.95)
LIMIT = 1.0
SYSTEM = vc.System(MACHINE, vc.Coulomb(coulomb_coefficient=LIMIT, static_coefficient=LIMIT), DRIVE)
MASS_RATIOS = np.linspace(1.3, 8.0, 1000)  # of lighter capsules half move chaotically
PERIODS = 20
END = PERIODS * 2.0 * math.pi / DRIVE.frequency
# The largest tried at which 99 % of the runs end within the error asked.
TOLERANCE, HEYOKA_TOLERANCE = 5e-7, 1e-7
ROUNDS = 7
NUDGE = 1e-12  # a capsule that leaves stick starts this much inside its mode
SIDE, SLIPPING, MASS_RATIO, TOUCHING = range(4)

Sweep = Callable[[], np.ndarray]


def prepare_vibrocap(tolerance: float = TOLERANCE) -> Sweep:
    """Final states [runs, 4]; compiled and warm."""
    recorded = equations(SYSTEM)
    parameters = np.tile(parameter_values(SYSTEM), (len(MASS_RATIOS), 1))
    parameters[:, recorded.parameter_paths.index("machine.mass_ratio")] = MASS_RATIOS
    arguments = recorded, parameters, np.zeros((len(MASS_RATIOS), len(SYSTEM.state_names)))

    def run() -> np.ndarray:
        return ensemble_run(
            EnsembleStart(*arguments), Budget(PERIODS, tolerance, 10_000, 50_000_000, window=1), threads=1
        ).state[:, :4]

    run()
    return run


@dataclasses.dataclass
class Modes:
    """The callbacks of both events on the arrays of a batch integrator, read and written as memoryviews."""

    impacts: list[int] = dataclasses.field(default_factory=list)  # of each lane, where they are counted

    def bind(self, integrator: Any) -> None:
        """Look at the arrays of this integrator."""
        rows: list[Any] = [memoryview(row) for row in (*integrator.pars, *integrator.state)]
        self.side, self.slipping, _, self.touching, self.place, self.rate, _, self.velocity = rows

    def contact(self, _integrator, _direction, lane: int) -> bool:
        """The capsule comes to rest and sticks or turns, or leaves stick."""
        p, place = MACHINE, self.place[lane]
        pull = p.stiffness * place + p.damping * self.rate[lane]
        pull += self.touching[lane] * p.stop_stiffness * (place - p.gap)
        if self.slipping[lane] and -LIMIT < pull < LIMIT:
            self.slipping[lane] = self.velocity[lane] = 0.0
        else:
            side = 1.0 if pull > 0.0 else -1.0
            self.side[lane], self.slipping[lane], self.velocity[lane] = side, 1.0, side * NUDGE
        return True

    def stop(self, _integrator, _direction, lane: int) -> bool:
        """The stop is reached or left."""
        self.touching[lane] = 1.0 - self.touching[lane]
        return True

    def counted_stop(self, integrator, direction, lane: int) -> bool:
        """The same, and counts."""
        self.impacts[lane] += not self.touching[lane]
        return self.stop(integrator, direction, lane)


def prepare_heyoka(tolerance: float = HEYOKA_TOLERANCE, counts: np.ndarray | None = None) -> Sweep:
    """The same by heyoka's batch integrator; neighbouring mass ratios share a batch.

    counts: where to write how often each run strikes the stop
    """
    import heyoka as hy

    p, modes = MACHINE, Modes()
    place, rate, position, velocity = hy.make_vars("place", "rate", "position", "velocity")
    pressed = place - p.gap
    pull = p.stiffness * place + p.damping * rate + hy.par[TOUCHING] * p.stop_stiffness * pressed
    push = hy.par[SLIPPING] * (pull - hy.par[SIDE] * LIMIT) / hy.par[MASS_RATIO]
    drive = DRIVE.amplitude * hy.cos(DRIVE.frequency * hy.time)
    moving = hy.par[SLIPPING] * hy.par[SIDE] * velocity + (1.0 - hy.par[SLIPPING]) * (LIMIT * LIMIT - pull * pull)
    options = {"direction": hy.event_direction.negative, "cooldown": 0.0}
    lanes = hy.recommended_simd_size()
    integrator = hy.taylor_adaptive_batch(
        [(place, rate), (rate, drive - pull - push), (position, velocity), (velocity, push)],
        np.zeros((4, lanes)),
        pars=np.ones((4, lanes)),
        tol=tolerance,
        t_events=[
            hy.t_event_batch(moving, callback=modes.contact, **options),
            hy.t_event_batch(
                (2.0 * hy.par[TOUCHING] - 1.0) * pressed,
                callback=modes.stop if counts is None else modes.counted_stop,
                **options,
            ),
        ],
        fast_math=True,
    )
    bound = [event.callback.__self__ for event in integrator.t_events]  # the integrator holds copies
    for each in bound:
        each.bind(integrator)
    ends = np.full(lanes, END)

    def run() -> np.ndarray:
        final = np.empty((len(MASS_RATIOS), 4))
        for begin in range(0, len(MASS_RATIOS), lanes):
            batch = MASS_RATIOS[begin : begin + lanes]
            integrator.set_time(0.0)
            integrator.state[:] = 0.0
            integrator.pars[MASS_RATIO] = batch[-1]
            integrator.pars[MASS_RATIO, : len(batch)] = batch
            integrator.pars[SIDE], integrator.pars[SLIPPING], integrator.pars[TOUCHING] = 1.0, 0.0, 0.0
            bound[1].impacts = [0] * lanes
            integrator.propagate_until(ends)
            outcomes = {result[0] for result in integrator.propagate_res}
            assert outcomes == {hy.taylor_outcome.time_limit}, outcomes
            final[begin : begin + lanes] = integrator.state.T[: len(batch)]
            if counts is not None:
                counts[begin : begin + lanes] = bound[1].impacts[: len(batch)]
        return final

    return run


def error_share(final: np.ndarray, reference: np.ndarray) -> float:
    """The error within which 99 % of the runs end."""
    errors = np.max(np.abs(final - reference), axis=1)
    return float(np.sort(errors)[-1 - int(len(errors) * (1.0 - SHARE_ASKED))])


def main() -> None:
    """Print time, ratio and error of both, and in how many runs the number of impacts differs."""
    runs = len(MASS_RATIOS)
    print(f"\nVibro-impact sweep, {runs} mass ratios, {PERIODS} periods, one thread: error asked {ERROR_ASKED:g}")
    struck = np.zeros(runs, int)
    try:
        peer, tight = prepare_heyoka(), prepare_heyoka(2.3e-16, struck)
    except ImportError:
        print("  heyoka: not installed (pip install -e '.[ref]')")
        return
    reference = tight()
    options = {"periods": PERIODS, "window": PERIODS, "tolerance": TOLERANCE, "threads": 1}
    impacts = vc.ensemble(SYSTEM, {"machine.mass_ratio": MASS_RATIOS}, measures=["impacts"], **options)["impacts"]
    sweeps = {"vibrocap": prepare_vibrocap(), "heyoka, batch": peer}
    times: dict[str, list[float]] = {label: [] for label in sweeps}
    final = {}
    for _ in range(ROUNDS):
        for label, sweep in sweeps.items():
            before = time.process_time()
            final[label] = sweep(periods=60, tolerance=1e-8, settle=0)
            times[label].append(time.process_time() - before)
    print(f"  {'':20s}{'us/run/period':>14s}{'ratio':>9s}{'99 % error':>12s}")
    first = statistics.median(times["vibrocap"])
    for label, measured in times.items():
        spent = statistics.median(measured)
        error = error_share(final[label], reference)
        missed = "  above the error asked" if error > ERROR_ASKED else ""
        print(f"  {label:20s}{spent / runs / PERIODS * 1e6:14.2f}{spent / first:9.2f}{error:12.1e}{missed}")
    differ = int(np.sum(np.round(impacts * PERIODS) != struck))
    print(f"  impacts: {struck.sum()} in the reference (heyoka, tight); in {differ} of {runs} runs not as many")


if __name__ == "__main__":
    main()
