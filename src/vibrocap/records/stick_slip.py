"""Stick-slip in measured force records: phases, period, slips, levels of friction and regime of the motion."""

import dataclasses
import math
from collections.abc import Sequence
from typing import Annotated, Any

import numpy as np

from vibrocap.arguments import ArgumentError, is_number
from vibrocap.quantities.declared import Measured, RecordedForce
from vibrocap.records.phases import Phase, falls, phases, stick_bend, with_minor
from vibrocap.records.pull import Pull, pull, settings_of
from vibrocap.records.record import Record
from vibrocap.records.regimes import (
    AGREE,
    HALF_STICK_X,
    INERTIAL,
    STEADY,
    STICK_SLIP,
    Drift,
    Recurrence,
    Regime,
    period_drift,
    recurrence,
    regime,
    stretch_periods,
)

LOADING = (0.3, 3.0)  # stick phases that rise at another multiple of k V are taken for a slip in the units
FREE_SLIP = 1.5  # a slip that takes more of the time which inertia alone needs is an overdamped one
LEAST_SLIP = 0.2  # of 2 pi sqrt(m/k); a slip of a free mass takes at least half of it
EXTREMES, SLIP_END = "mean of the extreme levels", "level at the end of the slip"


@dataclasses.dataclass(frozen=True)
class Spread:
    """Mean, median and standard deviation of a quantity over `number` phases; the deviation of one phase is None."""

    mean: float
    median: float
    deviation: float | None
    number: int

    @property
    def error(self) -> float | None:
        """Standard error of the mean, for values that are independent."""
        return None if self.deviation is None else self.deviation / math.sqrt(self.number)


SpreadOfTime = Annotated[Spread, Measured("s")]
SpreadOfLength = Annotated[Spread, Measured("m")]
SpreadOfForce = Annotated[Spread, Measured("")]


@dataclasses.dataclass(frozen=True, eq=False)
class StickSlip:
    """What a force record tells of stick-slip, forces in the unit of the record (`force_unit`), all else in SI.

    What neither the record nor the arguments determine is None.

    phases: slips and the stick phases between them, none in the steady regime; a slip is `minor` if its fall is below a
        share (half by default) of the mean fall, the others are "main" slips
    period: from one main slip's start to the next [s], in the inertial regime from top to top; where only some falls
        stand above the noise (`regime.from_spectrum`), from the spectra of stretches of the record
    drift: of the period, from the first to the last third of the record;  recurrence: the period without phases
    slip: distance that the slider travels in a main slip [m], dF/k + V dt: while it slips, the spring is pulled on
    release: how much shorter the spring gets in a main slip [m], dF/k
    stick_duration, slip_duration: of stick phases and main slips [s];  stick_fraction: share of the time at rest
    static_level: force at the start of main slips;  slip_end_level: at their end; in the stick-slip regime only
    kinetic_level: kinetic friction, and by `kinetic_from` the mean of the extreme levels (a free mass overshoots as far
        as it fell short) or the level at the end of the slip (an overdamped one stops at it)
    static_coefficient, kinetic_coefficient: the means over the normal force
    loading_ratio: median rate at which stick phases rise, over k V; 1 for a slider that does not creep
    time, force: what was analysed, without spikes [n];  velocity: of the slider, V - (1/k) dF/dt [n] m/s
    noise: standard deviation of a sample;  spikes: samples replaced;  window: of the running mean that shows the falls
    """

    name: str
    force_unit: str
    regime: Regime
    phases: tuple[Phase, ...]
    period: SpreadOfTime | None
    drift: Drift | None
    recurrence: Recurrence
    slip: SpreadOfLength | None
    release: SpreadOfLength | None
    stick_duration: SpreadOfTime | None
    slip_duration: SpreadOfTime | None
    stick_fraction: float | None
    static_level: SpreadOfForce | None
    slip_end_level: SpreadOfForce | None
    kinetic_level: RecordedForce | None
    kinetic_from: str | None
    static_coefficient: float | None
    kinetic_coefficient: float | None
    loading_ratio: float | None
    time: np.ndarray
    force: np.ndarray
    velocity: np.ndarray | None
    noise: RecordedForce
    spikes: int
    window: int
    stiffness: Annotated[float, Measured("N/m")] | None
    mass: Annotated[float, Measured("kg")] | None
    pulling_speed: Annotated[float, Measured("m/s")] | None
    normal_force: Annotated[float, Measured("N")] | None
    notes: tuple[str, ...]

    in_record = (
        "name force_unit regime phases period drift recurrence slip release stick_duration slip_duration "
        "stick_fraction static_level slip_end_level kinetic_level kinetic_from static_coefficient "
        "kinetic_coefficient loading_ratio noise spikes window stiffness mass pulling_speed normal_force notes"
    )

    @property
    def slips(self) -> tuple[Phase, ...]:
        """The slips, minor ones too."""
        return tuple(phase for phase in self.phases if phase.kind == "slip")

    @property
    def main_slips(self) -> tuple[Phase, ...]:
        return tuple(phase for phase in self.slips if not phase.minor)

    @property
    def sticks(self) -> tuple[Phase, ...]:
        return tuple(phase for phase in self.phases if phase.kind == "stick")


def stick_slip(
    time: Any,
    force: Any,
    *,
    stiffness: float | None = None,
    mass: float | None = None,
    pulling_speed: float | None = None,
    normal_force: float | None = None,
    coefficient: bool = False,
    minor: float = 0.5,
    name: str = "record",
) -> StickSlip:
    """Stick-slip in the force record of a slider that is pulled through a spring at constant speed.

    While the slider sticks the force rises at k V; it slips when the static friction is reached. For static and kinetic
    Coulomb friction (docs/model.md, belt), with D = (F_s - F_k)/k and w = sqrt(k/m),

        stick time 2 D/V, slip time (2/w)(pi - atan(w D/V)), slip 2 D + V (slip time)

    time [n] s: increasing; uneven sampling is interpolated, gaps are refused;  force [n]: N, positive on average
    stiffness: of spring and machine together, N/m;  mass: of the slider, kg;  pulling_speed: m/s;  normal_force: N
    coefficient: the force is given as friction over normal force; then the normal force (m g where only the mass is
        given) turns it into what the spring feels
    minor: slips whose fall is below this share of the mean fall count as minor: partial slips, on which the period of
        an irregular record depends; 0 for none, and in the inertial regime there are none
    name: of the record in results

    Raises RecordError with every complaint: NaN, lengths that differ, a time that runs backwards, a constant force,
    fewer than 64 samples, a gap, numbers that are not positive.
    Limits: a slip has to stand above 8 standard deviations of the noise that smoothing leaves. Its start and end are
    located to their stated errors and to 3 % of its duration (a parabola is fitted where a cosine is); with noise of
    10 % of the fall these are up to a quarter of its duration, while levels and slips are within 3 % of the fall.
    """
    further = []
    if not (is_number(minor) and 0.0 <= minor < 1.0):
        further.append(f"minor: should be a share of at least 0 and less than 1, got {minor!r}")
    numbers = {"stiffness": stiffness, "mass": mass, "pulling_speed": pulling_speed, "normal_force": normal_force}
    pulled = pull(time, force, numbers, coefficient, name, further)
    clean = falls(pulled.force)
    repeats = recurrence(clean.force, pulled.step, clean.window)
    every = phases(pulled.time, clean)
    turning = (pulled.time[clean.tops], pulled.time[clean.bottoms])
    extremes = (clean.force[clean.tops], clean.force[clean.bottoms])
    heights = extremes[0] - extremes[1]
    clearness = float(np.mean(heights)) / clean.least if len(heights) and clean.least > 0 else math.inf
    bend = stick_bend(pulled.time, clean, every)
    kind = regime(every, *turning, repeats, pulled.inertial_period, bend, clearness)
    # What wanders has no phases; what swings has no partial slips.
    marked = () if kind.name == STEADY else with_minor(every, minor if kind.name == STICK_SLIP else 0.0)
    main = [phase for phase in marked if phase.kind == "slip" and not phase.minor]
    sticks = [phase for phase in marked if phase.kind == "stick"]
    if kind.from_spectrum and kind.typical_period is not None:
        periods = stretch_periods(clean.force, pulled.step, clean.window, kind.typical_period)
    else:
        periods = np.diff(turning[0] if kind.name == INERTIAL else [slip.start for slip in main])
    level, how = _kinetic(main, sticks, kind, extremes)
    rests = main if kind.name == STICK_SLIP else []
    static = _spread([slip.start_force for slip in rests])
    rate, give, speed = pulled.loading_rate, pulled.compliance, pulled.pulling_speed
    loading = None if rate is None or not sticks else float(np.median([-s.fall / s.duration for s in sticks])) / rate
    at_rest = sum(stick.duration for stick in sticks)
    velocity = None
    if give is not None and speed is not None:
        usual = float(np.median([slip.duration for slip in main])) if main else 3 * clean.window * pulled.step
        window = max(5, round(usual / (3.0 * pulled.step)))
        velocity = slider_velocity(pulled.time, clean.force, 1.0 / give, speed, window)
    return StickSlip(
        name=name,
        force_unit="1" if coefficient else "N",
        regime=kind,
        phases=marked,
        period=_spread(periods),
        drift=period_drift(periods),
        recurrence=repeats,
        slip=None if give is None or speed is None else _spread([s.fall * give + speed * s.duration for s in main]),
        release=None if give is None else _spread([slip.fall * give for slip in main]),
        stick_duration=_spread([stick.duration for stick in sticks]),
        slip_duration=_spread([slip.duration for slip in main]),
        stick_fraction=at_rest / (marked[-1].end - marked[0].start) if marked else None,
        static_level=static,
        slip_end_level=_spread([slip.end_force for slip in rests]),
        kinetic_level=level,
        kinetic_from=how,
        static_coefficient=static.mean / pulled.weight if static and pulled.weight else None,
        kinetic_coefficient=level / pulled.weight if level is not None and pulled.weight else None,
        loading_ratio=loading,
        time=pulled.time,
        force=clean.force,
        velocity=velocity,
        noise=clean.noise,
        spikes=clean.spikes,
        window=clean.window,
        **numbers | {"normal_force": pulled.normal_force},
        notes=(*pulled.notes, *_notes(pulled, kind, loading, level, main), *_doubts(periods, repeats, kind, marked)),
    )


def stick_slip_of(record: Record, **changes: Any) -> StickSlip:
    """Stick-slip of a measured `Record`, with what its conditions say.

    conditions: stiffness_N_per_m, mass_kg, pulling_speed_m_per_s;  changes: arguments of `stick_slip` that take their
    place. A normal force that varies counts with its mean.
    """
    return stick_slip(record.time, record.force, **{"name": record.name, **settings_of(record), **changes})


def slider_velocity(
    time: np.ndarray, force: np.ndarray, stiffness: float, pulling_speed: float, window: int = 5
) -> np.ndarray:
    """Velocity of a slider that is pulled through a spring at constant speed, [n] m/s, from the force in it.

        x' = V - (1/k) dF/dt

    The derivative is that of parabolas fitted to `window` samples around each (Savitzky and Golay 1964), which delays
    nothing. time: evenly spaced [n] s;  force [n] N;  stiffness N/m;  pulling_speed m/s
    """
    from scipy.signal import savgol_filter

    step = float(time[-1] - time[0]) / (len(time) - 1)
    rate = np.asarray(savgol_filter(force, window | 1, 2, deriv=1, delta=step))
    return pulling_speed - rate / stiffness


def _spread(values: Any) -> Spread | None:
    values = np.asarray(values, dtype=float)
    values = values[np.isfinite(values)]
    if not len(values):
        return None
    deviation = float(values.std(ddof=1)) if len(values) > 1 else None
    return Spread(float(values.mean()), float(np.median(values)), deviation, len(values))


def _kinetic(
    main: list[Phase], sticks: list[Phase], kind: Regime, extremes: tuple[np.ndarray, np.ndarray]
) -> tuple[float | None, str | None]:
    """(kinetic level, what it was taken from), None where the record does not tell.

    A mass that only Coulomb friction holds swings as far below the kinetic level as it began above it, within the slip
    time (2/w)(pi - atan(w D/V)), where w D/V is w/2 of the stick time. One that takes longer is held back by more.
    """
    middle = 0.5 * float(extremes[0].mean() + extremes[1].mean()) if len(extremes[0]) else None
    if kind.name == INERTIAL:
        return middle, EXTREMES
    if kind.name != STICK_SLIP or kind.inertial_period is None or not main or not sticks:
        return None, None
    at_end = float(np.mean([slip.end_force for slip in main]))
    at_start = float(np.mean([slip.start_force for slip in main]))
    rest = float(np.median([stick.duration for stick in sticks]))
    free = kind.inertial_period * (1.0 - math.atan(math.pi * rest / kind.inertial_period) / math.pi)
    if float(np.median([slip.duration for slip in main])) > FREE_SLIP * free:
        return at_end, SLIP_END
    return 0.5 * (at_start + at_end), EXTREMES


def _notes(pulled: Pull, kind: Regime, loading: float | None, level: float | None, main: list[Phase]) -> list[str]:
    """What could not be told, and what looks wrong."""
    notes = []
    missing = [field for field in ("stiffness", "mass", "pulling_speed") if getattr(pulled, field) is None]
    if "stiffness" in missing:
        notes += ["stiffness: not given; slips in metres and the slider's velocity are unknown"]
    elif pulled.compliance is None:
        notes += ["normal_force: not given, nor the mass; a coefficient alone does not give the stretch of the spring"]
    elif "pulling_speed" in missing:
        notes += ["pulling_speed: not given; a slip is the release of the spring dF/k alone, without V dt"]
    if kind.inertial_period is None:
        lacking = " and ".join(field for field in ("mass", "stiffness") if field in missing)
        notes.append(f"{lacking}: not given; the effect of inertia on the period is unknown")
        if kind.name == STICK_SLIP and level is None:
            notes.append(f"{lacking}: not given; the kinetic level is the {EXTREMES} or the {SLIP_END}, by inertia")
    if loading is not None and kind.name == STICK_SLIP and not LOADING[0] <= loading <= LOADING[1]:
        notes.append(
            f"stiffness, pulling_speed, force: stick phases rise at {loading:.3g} times k V; "
            "it looks as if one of them were in another unit, or the force were a coefficient"
        )
    if kind.inertial_period is not None and main:
        share = float(np.median([slip.duration for slip in main])) / kind.inertial_period
        if share < LEAST_SLIP:
            notes.append(
                f"mass, stiffness: slips take {share:.2g} of 2 pi sqrt(m/k), where inertia alone needs half of it; "
                "it looks as if one of them were wrong"
            )
    return notes


def _doubts(periods: np.ndarray, repeats: Recurrence, kind: Regime, phases: tuple[Phase, ...]) -> list[str]:
    """Where slips, spectrum and correlation tell different periods, and where the period drifts."""
    if not len(periods):
        return []
    notes, mean = [], float(np.mean(periods))
    elsewhere = {"by the spectrum": repeats.spectral_period, "by the correlation": repeats.correlation_period}
    slips = [phase.start for phase in phases if phase.kind == "slip"]
    if any(phase.minor for phase in phases) and len(slips) > 1:
        elsewhere["with the minor slips"] = float(np.mean(np.diff(slips)))
    other = {how: x for how, x in elsewhere.items() if x is not None and abs(x / mean - 1.0) > AGREE / 2}
    if other and not kind.from_spectrum and kind.name != STEADY:
        apart = ", ".join(f"{value:.3g} s {how}" for how, value in other.items())
        notes.append(f"period: {mean:.3g} s between slips, but {apart}: an irregular record, or unseen slips")
    drift = period_drift(periods)
    if drift is not None and drift.significant:
        notes.append(
            f"period: goes from {drift.first:.3g} s in the first third of the record to {drift.last:.3g} s in the last "
            f"(+- {drift.error:.2g} s): its mean depends on the stretch"
        )
    return notes


NUMBERS = ("stiffness", "pulling_speed", "period", "period_ratio", "stick_fraction", "slip")


@dataclasses.dataclass(frozen=True, eq=False)
class RegimeDiagram:
    """Regimes of many records over stiffness and pulling speed: arrays [n] in the order of the records.

    stiffness [N/m], pulling_speed [m/s], names, regimes (words), period [s] and slip [m] (means of main
    slips), period_ratio (typical period over 2 pi sqrt(m/k)), stick_fraction; NaN where a record does not tell
    border: speed [m/s] times sqrt(stiffness) [N/m] at which a Coulomb block sticks for half of its period, from the
    falls of the records: V sqrt(k) = dF/(2 x sqrt(m)), x = w D/V = 1.808; NaN where no mass is known
    """

    names: tuple[str, ...]
    stiffness: np.ndarray
    pulling_speed: np.ndarray
    regimes: tuple[str, ...]
    period: np.ndarray
    period_ratio: np.ndarray
    stick_fraction: np.ndarray
    slip: np.ndarray
    border: float

    def table(self) -> list[dict[str, Any]]:
        """A row for each record, by column name, sorted by stiffness and speed."""
        columns = {"name": self.names, "regime": self.regimes} | {
            name: getattr(self, name).tolist() for name in NUMBERS
        }
        order = np.lexsort((self.pulling_speed, self.stiffness))
        return [{name: column[at] for name, column in columns.items()} for at in order]


def regime_diagram(analyses: Sequence[StickSlip]) -> RegimeDiagram:
    """The regimes of many records over stiffness and pulling speed, which each of them has to know. ValueError else."""
    records = list(analyses)
    if not records:
        raise ArgumentError("analyses", "should be at least one StickSlip, got none")
    for at, record in enumerate(records):
        if record.stiffness is None or record.pulling_speed is None:
            what = "stiffness and pulling_speed are needed for its place in the diagram; give them to stick_slip"
            raise ArgumentError(f"analyses[{at}] ({record.name})", what)
    borders, rows = [], []
    for record in records:
        kind = record.regime
        if kind.name == STICK_SLIP and record.release and record.mass and record.stiffness:
            borders.append(record.release.mean * record.stiffness / (2.0 * HALF_STICK_X * record.mass**0.5))
        period, slip = (spread.mean if spread else None for spread in (record.period, record.slip))
        rows.append((record.stiffness, record.pulling_speed, period, kind.period_ratio, kind.stick_fraction, slip))
    return RegimeDiagram(
        names=tuple(record.name for record in records),
        regimes=tuple(record.regime.name for record in records),
        border=float(np.median(borders)) if borders else float("nan"),
        **dict(zip(NUMBERS, np.array(rows, dtype=float).T, strict=True)),
    )
