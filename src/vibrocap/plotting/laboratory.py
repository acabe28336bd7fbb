"""Pictures of what a friction law does: its canonical tests, its test sheet, and what smoothing its contact costs."""

import contextlib
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from vibrocap.laboratory.contact_sizes import contact_sizes
from vibrocap.laboratory.loops import PreslidingLoop, presliding_loop
from vibrocap.laboratory.regularisation import Regularisation, WidthNeeded
from vibrocap.laboratory.test_sheet import REACHES, TestSheet
from vibrocap.physics.friction.law import Law
from vibrocap.plotting.look import style as plots
from vibrocap.plotting.look.labels import bracketed, parts_title
from vibrocap.plotting.look.page import page
from vibrocap.plotting.look.style import BLACK, BLUE, GREEN, ORANGE, SKY, VERMILION
from vibrocap.quantities.dimensional import in_si

COLOURS = (SKY, BLUE, GREEN, ORANGE, VERMILION, BLACK)
CYCLES_SHOWN = 3.2  # of stick-slip
WIDEST = 6.0  # speeds of the contact, of its steady curve
CURVE: dict[str, Any] = {"color": BLACK, "linestyle": (0, (4, 2)), "linewidth": 1.0}
FLAT = 1e-3  # of the break-away force: what is no lag, or no curve
PRINTED = 2.4  # inches: the height of a row of panels on a page
UNITS = "All quantities in the units of the law's parameters."
SHAPES = {"tanh": VERMILION, "arctan": BLUE}
FORMULAS = {"tanh": r"$\tanh(v/\epsilon)$", "arctan": r"$(2/\pi)\,\arctan(v/\epsilon)$"}
WIDTH = r"width of the smoothing $\epsilon$"


def sheet_figure(sheet: TestSheet) -> Figure:
    """The canonical tests of a law: presliding, frictional lag, break-away and stick-slip in one sheet."""
    with _sheet(sheet.law, sheet.load, (10.6, 7.4), 4) as (fig, (presliding, lag, break_away, stick_slip)):
        draw_presliding(sheet.presliding, ax=presliding).set_title("Presliding")
        _draw_lag(lag, sheet)
        _draw_break_away(break_away, sheet)
        _draw_stick_slip(stick_slip, sheet)
    plots.footnote(fig, f"{_creep_label(sheet)} {UNITS}")
    return fig


def law_figure(law: Law, *, load: float = 1.0) -> Figure:
    """A law: its steady curve and its presliding loops."""
    with _sheet(law, load, (9.4, 3.6), 2) as (fig, (steady, loops)):
        draw_steady_curve(law, load=load, ax=steady)
        draw_presliding(law, load=load, ax=loops).set_title("Presliding")
    plots.footnote(fig, UNITS)
    return fig


@contextlib.contextmanager
def _sheet(law: Law, load: float, size: tuple[float, float], panels: int) -> Iterator[tuple[Figure, Any]]:
    """A figure of a law under its parameters, and its panels, two of them in a row where they have room."""
    width, rows = page().width_or(size[0]), panels if page().narrow else panels // 2
    title = parts_title([law], width, f"load {load:g}")
    with plots.new_figure((width, _height(size[1], rows) + 0.17 * (title.count("\n") + 1))) as fig:
        yield fig, fig.subplots(rows, panels // rows).ravel()
        plots.setting(fig, title)


def _height(usual: float, rows: int) -> float:
    """The height of a sheet, in inches: on a page so much for each row of panels."""
    return usual if page().width is None else PRINTED * rows


def draw_steady_curve(law: Law, *, load: float = 1.0, widest: float | None = None, ax: Axes | None = None) -> Axes:
    """Friction force at constant velocity, to both sides; what a set-valued law can hold at rest stands upright.

    widest: the largest speed, by default some of those over which friction changes
    """
    widest = WIDEST * contact_sizes(law, load).speed if widest is None else widest
    speed = widest * np.concatenate((np.geomspace(1e-5, 0.01, 100), np.linspace(0.01, 1.0, 400)[1:]))
    force = np.array([float(law.steady_force(float(v), load)) for v in speed])
    back = force if law.symmetric else np.array([_steady_back(law, float(v), load) for v in speed])
    with plots.drawing(ax, (4.7, 3.6)) as ax:
        ax.plot(speed, force, color=BLUE, linewidth=1.5)
        ax.plot(-speed, -back, color=BLUE, linewidth=1.5)
        if law.kind == "set-valued":
            middle, limit = float(law.holding_centre(load)), float(law.holding_limit(load))
            ends = np.array([middle - limit, middle + limit])
            ax.plot([0.0, 0.0], ends, color=VERMILION, linewidth=2.0, label="held at rest")
            ax.plot([0.0, 0.0], ends, "o", color=VERMILION, markersize=3.5)
            plots.legend(ax)
        ax.set(title="Steady sliding", xlabel="velocity $v$", ylabel="friction force $R$")
    return ax


def _steady_back(law: Law, speed: float, load: float) -> float:
    """Size of the steady force when sliding back, of a law that is not the same in both directions."""
    from vibrocap.laboratory.driven import driven_force

    sizes = contact_sizes(law, load)
    time = np.linspace(0.0, 100.0 * sizes.displacement / speed, 50)
    return -float(driven_force(law, time, np.full(50, -speed), load=load).force[-1])


def draw_presliding(loops: Law | Sequence[PreslidingLoop], *, load: float = 1.0, ax: Axes | None = None) -> Axes:
    """Loops of force over displacement: the first loading thin, the last cycle in full.

    loops: or a law, whose loops are made at some amplitudes
    """
    if isinstance(loops, Law):
        law, displacement = loops, contact_sizes(loops, load).displacement
        loops = tuple(presliding_loop(law, reach * displacement, load=load) for reach in REACHES)
    with plots.drawing(ax, (4.7, 3.6)) as ax:
        for i, (loop, colour) in enumerate(zip(reversed(loops), reversed(COLOURS[: len(loops)]), strict=True)):
            first, last = slice(0, loop.last + 1), slice(loop.last, None)
            ax.plot(loop.displacement[first], loop.force[first], color=colour, linewidth=0.6)
            label = f"{'' if i else '$A$ = '}{loop.amplitude:.3g}"
            ax.plot(loop.displacement[last], loop.force[last], color=colour, linewidth=1.5, label=label)
        ax.locator_params(axis="x", nbins=6)
        ax.set(xlabel="displacement $x$, quasi-static", ylabel="friction force $R$")
        plots.legend_above(ax, ncols=len(loops), columnspacing=0.8, handlelength=1.0, handletextpad=0.4)
    return ax


def _draw_lag(ax: Axes, sheet: TestSheet) -> None:
    lag, lags = sheet.lag, bool(np.max(np.abs(sheet.lag.width)) > FLAT * sheet.sizes.force)
    rows = zip(lag.force, lag.frequency, (BLUE, ORANGE, VERMILION, GREEN, SKY), strict=False)
    for force, frequency, colour in rows if lags else ():
        ax.plot(lag.velocity, force, color=colour, linewidth=1.4, label=rf"$\omega$ = {frequency:.3g}")
        if np.ptp(force) > FLAT * sheet.sizes.force:
            _arrow(ax, lag.velocity, force, colour)
    if not lags:
        ax.plot(lag.velocity, lag.force[-1], color=BLUE, linewidth=1.8, label="no lag, at any frequency")
    speed = np.linspace(lag.velocity.min(), lag.velocity.max(), 400)
    steady = [float(sheet.law.steady_force(float(v), sheet.load)) for v in speed]
    ax.plot(speed, steady, label="steady", **CURVE)
    if np.ptp(lag.force) <= FLAT * sheet.sizes.force:
        ax.set_ylim(0.0, 1.3 * sheet.sizes.force)
    ax.set(title="Frictional lag", xlabel="velocity $v$", ylabel="friction force $R$")
    plots.legend(ax)


def _arrow(ax: Axes, x: np.ndarray, y: np.ndarray, colour: str) -> None:
    """The direction in which a loop is passed, at an eighth of its way."""
    i = len(x) // 5
    head, tail = (x[i + 8], y[i + 8]), (x[i], y[i])
    ax.annotate("", head, tail, arrowprops={"arrowstyle": "-|>", "color": colour, "linewidth": 1.2})


def _draw_break_away(ax: Axes, sheet: TestSheet) -> None:
    break_away = sheet.break_away
    look: dict[str, Any] = {"color": SKY, "linewidth": 1.0, "marker": "o", "markersize": 3}
    ax.plot(break_away.rate, break_away.applied, **look, label="applied then")
    ax.plot(break_away.rate, break_away.force, color=BLUE, linewidth=1.4, label="largest friction")
    for peaked, face in ((True, BLUE), (False, "white")):
        part = break_away.peaked == peaked
        if part.any():
            text = "" if peaked else "no maximum: friction never falls"
            ax.plot(
                break_away.rate[part], break_away.force[part], "o", color=BLUE, markersize=4.5,
                markerfacecolor=face, label=text or None,
            )  # fmt: skip
    ax.set_xscale("log")
    low, high = float(np.min(break_away.force)), float(np.nanmax([*break_away.applied, *break_away.force]))
    ax.set_ylim(0.0 if low > 0.8 * high else low - 0.15 * (high - low), high + 0.25 * (high - low) + 0.1 * low)
    ax.set(title="Break-away", xlabel="rate of the force", ylabel="force")
    plots.legend(ax)


def _draw_stick_slip(ax: Axes, sheet: TestSheet) -> None:
    stick_slip = sheet.stick_slip
    periodic = stick_slip.regime in ("stick-slip", "oscillation")
    begin = stick_slip.time[-1] - CYCLES_SHOWN * stick_slip.period if periodic else 0.0
    shown = stick_slip.time >= begin
    ax.plot(stick_slip.time[shown], stick_slip.pull[shown], color=BLUE, linewidth=1.5, label="pull of the spring")
    ax.plot(stick_slip.time[shown], stick_slip.friction[shown], color=VERMILION, linewidth=0.9, label="friction")
    if stick_slip.sticks:
        still = shown & (np.abs(stick_slip.velocity) <= stick_slip.still)
        ax.fill_between(
            stick_slip.time, 0.0, 1.0, where=still.tolist(), transform=ax.get_xaxis_transform(), label="sticks",
            **plots.STICK_SHADE,
        )  # fmt: skip
    words = f" of period {stick_slip.period:.4g}" if periodic else ""
    ax.set(title=f"Pulled through a spring: {stick_slip.regime}{words}", xlabel="time", ylabel="force")
    ax.set_xlim(max(begin, stick_slip.time[0]), stick_slip.time[-1])
    plots.legend_below(ax, ax.get_legend_handles_labels()[0], ncols=3)


def _creep_label(sheet: TestSheet) -> str:
    creep = sheet.creep
    words = f"a drift of {creep.drift_per_cycle:.3g} per cycle" if creep.creeps else "no drift"
    if not creep.status.ok:
        words += f" (ended after {len(creep.displacement) - 1} cycles: {creep.status.value})"
    return f"Creep under a force {creep.bias:.3g} + {creep.amplitude:.3g} cos: {words}."


def regularisation_figure(reports: Regularisation | Sequence[Regularisation]) -> Figure:
    """Error of the measure and steps of the integrator against the width, for one system and one or two shapes."""
    shown = [in_si(report) for report in ([reports] if isinstance(reports, Regularisation) else reports)]
    if not shown:
        raise ValueError("reports should hold at least one regularisation, got none")
    rows = 2 if page().narrow else 1
    fig, axes = plots.figure(rows, 2 // rows, size=(page().width_or(9.2), _height(3.6, rows)))
    with plots.style():
        errors, steps = axes.ravel()
        draw_errors(errors, shown)
        draw_steps(steps, shown)
        for ax in (errors, steps):
            for name in "xy":
                plots.logarithmic(ax, name)
            plots.legend(ax)
    return fig


def draw_errors(ax: Axes, reports: Sequence[Regularisation], needed: Sequence[WidthNeeded] = ()) -> None:
    """Relative error against width; errors within the noise of integration are left out.

    needed: widths for wanted errors, drawn as dotted guides
    """
    for report in reports:
        known = np.abs(report.errors) > report.noise
        share = np.abs(report.relative_errors)
        colour = SHAPES[report.shape]
        ax.loglog(report.widths[known], share[known], color=colour, linewidth=1.4)
        for sign, face, words in ((-1.0, colour, "too small"), (1.0, "white", "too large")):
            part = known & (np.sign(report.errors) == sign)
            if part.any():
                ax.loglog(
                    report.widths[part], share[part], "o", color=colour, markersize=4, markerfacecolor=face,
                    label=f"{FORMULAS[report.shape]}: {words}",
                )  # fmt: skip
    for needed_width in needed:
        if needed_width.width is not None:
            share = needed_width.error / abs(needed_width.regularisation.exact.value)
            guide = {"color": "#808080", "linewidth": 0.8, "linestyle": ":", "zorder": 1}
            ax.plot([needed_width.width, needed_width.width], [ax.get_ylim()[0], share], **guide)
            ax.plot([ax.get_xlim()[0], needed_width.width], [share, share], **guide)
    name = reports[0].measure.replace("_", " ")
    ax.set(title=f"Error of the {name}", ylabel="error over the exact value")
    ax.set_xlabel(WIDTH + bracketed(reports[0].unit_of("speed")))


def draw_steps(ax: Axes, reports: Sequence[Regularisation]) -> None:
    """Steps of the integrator against width, and of the run with the contact solved exactly."""
    for report in reports:
        label = f"{FORMULAS[report.shape]}, this package"
        ax.loglog(report.widths, report.steps, "o-", color=SHAPES[report.shape], markersize=4, label=label)
    exact = reports[0].exact.steps
    ax.axhline(exact, color=GREEN, linewidth=2.0, label="exact contact, this package", zorder=1)
    ax.annotate(
        f"{exact:,}", (reports[0].widths.max(), exact), (0, 3), textcoords="offset points", ha="right", va="bottom",
        color=BLACK, fontsize=plots.letters(8),
    )  # fmt: skip
    ax.set(title="Steps for the whole run", xlabel=WIDTH + bracketed(reports[0].unit_of("speed")), ylabel="steps")
