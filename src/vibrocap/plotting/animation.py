"""Motion pictures: a machine on a ground with ticks, its contact coloured by stick and slip.

An arrow from below is what the ground gives, the true normal load; downwards where it would have to pull.
"""

import contextlib
import math
import shutil
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.animation import FFMpegWriter, PillowWriter
from matplotlib.axes import Axes
from matplotlib.patches import BoxStyle, Circle, FancyArrowPatch, FancyBboxPatch
from matplotlib.patheffects import Normal, Stroke
from matplotlib.transforms import Affine2D, Transform

from vibrocap.files import replacing
from vibrocap.motion.recording.equations import equations
from vibrocap.motion.recording.recorded_machine import drawn_length
from vibrocap.motion.shapes import MovingShape, moving_shapes
from vibrocap.motion.trajectory import BACK, FORWARD, STUCK, Trajectory
from vibrocap.physics.names import number_in, numbered
from vibrocap.plotting.histories import contacts_of, loads_of
from vibrocap.plotting.look.labels import scale
from vibrocap.plotting.look.style import BLUE, GREEN, ORANGE, PURPLE, STYLE, VERMILION, blank_figure

PERIODS = 5  # the last ones are filmed
FRAMES_PER_SECOND = 25
SECONDS_PER_PERIOD = 2.0
MOST_FRAMES = 750  # a longer film runs faster instead

# side of the contact: (colour, words); the words too, so that nothing rests on colour alone
CONTACT = {STUCK: ("#7A7A7A", "sticks"), FORWARD: (GREEN, "slips forward"), BACK: (VERMILION, "slips back")}
MOST_NAMED = 3  # contacts whose modes are said in words
WIDTH_OVER_HEIGHT = 16 / 9
LOWER = 0.4  # share of the room left over that lies below the shapes
MOST_MARKS = 20  # numbers on the ground, roughly, on either side of the middle
BELOW, ABOVE, BESIDE = 0.4, 0.35, 0.5  # room around the shapes: for the ground and its numbers, for words
USUAL = 4.0  # half of the width that is seen; where it is more, room, ticks and arrows are so many times larger
EDGE = 0.94  # of that half: beyond, a number of the ground would be cut off
OUTLINE = "#303030"
COILS, WINDING = 8, 0.09  # of a drawn spring, and half of its width
ARROW, SHORT, HEAD = 0.62, 0.15, 14.0  # length of the largest load; below SHORT the head of the arrow shrinks, too
LOADED = -0.95  # how deep the picture reaches below the ground, where it shows the load
DPI = {".mp4": 160, ".gif": 70}  # of a picture of 8 inches: 1280 x 720, and what a page can load
BARE = 0.12  # on either side of the arrow of the load, where no number of the ground stands
HELD_SECONDS = 1.5  # for which the end of a run that did not go to its end is held


def animate_motion(
    motion: Trajectory, path: str | Path, periods: float = PERIODS, progress: Callable[[float], Any] | None = None
) -> Path:
    """Film the last periods of a motion to an .mp4 (by ffmpeg) or .gif file.

    Drawn is the scene of the machine, `Machine.scene`, on ground as steep as it is. The camera follows the mean travel,
    which the ticks of the ground and a triangle where the film starts show. The arrow at the contact is the true normal
    load. The last frame of a run that did not go to its end is held, with its status. An .mp4 film has 1280 x 720
    points, 25 frames a second. Raises ValueError for .mp4 without ffmpeg, and for
    another ending; WriteError where the film cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in (".mp4", ".gif"):
        raise ValueError(f"a film should end in .mp4 or .gif, got {str(path)!r}")
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        raise ValueError("an .mp4 film needs ffmpeg, which is not found; install it, or give a name in .gif")
    if not len(motion.piece_start):
        words = f"the run ended where it began, with the status {motion.status.value!r}"
        raise ValueError(f"there is nothing to film: {words}")
    start = max(0.0, motion.end - periods * motion.period)
    shown = max((motion.end - start) / motion.period, 1e-9)
    frames = min(MOST_FRAMES, max(2, round(shown * SECONDS_PER_PERIOD * FRAMES_PER_SECOND)))
    # The end itself is left out, so that a repeated film of whole periods goes on smoothly.
    times = np.linspace(start, motion.end, frames, endpoint=False)
    if not motion.run_status.ok:
        times = np.append(times, np.full(round(HELD_SECONDS * FRAMES_PER_SECOND), motion.end))
    with matplotlib.rc_context(STYLE):
        scene = Scene(motion, times)
        writer, dpi = FFMpegWriter if path.suffix.lower() == ".mp4" else PillowWriter, DPI[path.suffix.lower()]
        writer = writer(fps=FRAMES_PER_SECOND)
        with replacing(path) as temporary, _ended_well(), writer.saving(scene.figure, str(temporary), dpi):
            for number in range(len(times)):
                scene.show(number)
                writer.grab_frame()
                if progress is not None:
                    progress((number + 1) / len(times))
    return path


@contextlib.contextmanager
def _ended_well() -> Iterator[None]:
    """Where ffmpeg fails, an OSError with its last words; where it was interrupted along with us, the interrupt."""
    try:
        yield
    except subprocess.CalledProcessError as error:
        if isinstance(error.__context__, KeyboardInterrupt):
            raise error.__context__ from None
        words = str(error.stderr or "").strip().splitlines()
        raise OSError(f"ffmpeg failed: {words[-1] if words else f'it ended with {error.returncode}'}") from None


class Scene:
    """The drawing of one frame, changed from frame to frame. The camera moves with the mean travel."""

    def __init__(self, motion: Trajectory, times: np.ndarray):
        self.motion = motion
        self.times = times
        machine = motion.system.machine
        self.place = machine.place or machine.cyclic
        self.turns = machine.state_units.get(self.place) == "rad"
        self.length = drawn_length(motion.system)
        self.position = motion.at(times, self.place) / self.length
        self.sides = [_shown_side(motion, times, contact) for contact in contacts_of(motion)]
        self.loads = {number_in(name, "reaction"): motion.at(times, name) for name in loads_of(motion)}
        self.shapes = moving_shapes(motion, times)
        self.soles = [shape.points[0, 0] for shape in self.shapes if shape.shape.kind == "contact"] or [self.position]
        self.camera = np.polyval(np.polyfit(times, self.soles[0], 1), times)
        environment = motion.system.environment
        self.slope = 0.0 if environment is None else float(environment.inclination)
        self._frame()
        self.figure = blank_figure((8.0, 8.0 / WIDTH_OVER_HEIGHT))
        self.figure.set_layout_engine("none")
        self.axes: Axes = self.figure.add_axes((0.0, 0.0, 1.0, 1.0))
        self.axes.set_axis_off()
        self.axes.set(xlim=(-self.half, self.half), ylim=(self.low, self.high))
        self.inclined = Affine2D().rotate(self.slope) + self.axes.transData  # along the ground, and upright on it
        self._ground()
        self.movers = [_drawn(shape, self.axes, self.inclined) for shape in self.shapes]
        if self.loads:
            self._arrows()
        self._words()

    def _frame(self) -> None:
        """How far is to be seen: all shapes in all frames, as far to the left as to the right."""
        low, high, half = 0.0, 0.0, 0.0
        places = [shape.points[:, 0] - self.camera for shape in self.shapes]
        self.camera += 0.5 * (min(place.min() for place in places) + max(place.max() for place in places))
        for shape in self.shapes:
            wide, tall = shape.shape.size[0] / 2, shape.shape.size[1] / 2
            half = max(half, float(np.abs(shape.points[:, 0] - self.camera).max()) + wide)
            low = min(low, float(shape.points[:, 1].min()) - tall)
            high = max(high, float(shape.points[:, 1].max()) + tall)
        self.size = max(1.0, half / USUAL)
        low, high = low - BELOW * self.size, high + ABOVE * self.size
        low = low if not self.loads else min(low, LOADED * self.size)
        turned = Affine2D().rotate(self.slope).transform([(x, y) for x in (-half, half) for y in (low, high)])
        (_, self.low), (right, high) = turned.min(axis=0), turned.max(axis=0)
        self.half = max(right + BESIDE * self.size, (high - self.low) * WIDTH_OVER_HEIGHT / 2)
        tall = 2 * self.half / WIDTH_OVER_HEIGHT
        self.low -= LOWER * (tall - (high - self.low))
        self.high = self.low + tall
        self.reach = math.hypot(self.half, max(self.high, -self.low))  # how far ground is to be seen

    def _ground(self) -> None:
        """A line with a long tick every length (or ten, a hundred, ... where so many are to be seen), short ones
        between, and a flag where the film starts. What is drawn does not grow with the travel.
        """
        grey = "#404040"
        along: dict[str, Any] = {"transform": self.inclined}
        self.axes.plot([-self.reach, self.reach], [0, 0], color=grey, linewidth=1.2, **along)
        self.step = 10.0 ** max(0, math.ceil(math.log10(self.reach / MOST_MARKS)))
        whole = np.arange(math.ceil(2 * self.reach / self.step) + 2)  # one more on either side than is seen
        self.marks = np.arange(4 * len(whole)) / 4
        lengths = self.size * np.where(self.marks % 1 == 0, 0.08, 0.04)
        depths = np.column_stack((np.zeros(len(lengths)), -lengths, np.full(len(lengths), np.nan)))
        self.ticks = self.axes.plot(np.repeat(self.marks, 3), depths.ravel(), color=grey, linewidth=1.0, **along)[0]
        look: dict[str, Any] = {"ha": "center", "va": "top", "fontsize": 8, "color": grey, "clip_on": True, **along}
        self.numbers = [self.axes.text(0, -0.1 * self.size, "", **look) for _ in whole]
        along |= {"marker": "^", "markersize": 9, "color": ORANGE, "linestyle": "none"}
        self.flag = self.axes.plot([0], [-0.05 * self.size], **along)[0]

    def _arrows(self) -> None:
        """The arrow of each load, on the ground, and what is said of them, below."""
        largest = max(*(float(np.abs(load).max()) for load in self.loads.values()), 1e-300)
        self.load_size = ARROW * self.size / largest
        self.load_words = self.axes.text(-0.97 * self.half, self.low + 0.03 * self.half, "", va="bottom", fontsize=10)
        look: dict[str, Any] = {"arrowstyle": "-|>", "linewidth": 2.4, "shrinkA": 0, "shrinkB": 0, "zorder": 7}
        self.arrows = {contact: FancyArrowPatch((0, 0), (0, 0), **look) for contact in self.loads}
        for arrow in self.arrows.values():
            arrow.set_transform(self.inclined)
            arrow.set_path_effects([Stroke(linewidth=5.0, foreground="white"), Normal()])
            self.axes.add_patch(arrow)

    def _words(self) -> None:
        top, side = self.high - 0.03 * (self.high - self.low), 0.97 * self.half
        self.clock = self.axes.text(-side, top, "", va="top", fontsize=10)
        self.state = self.axes.text(side, top, "", va="top", ha="right", fontsize=11, weight="bold")
        system = self.motion.system
        own = "the units of the parameters" if type(system.machine).gravity is None else "$l$"
        ground = f"lengths in {own if system.units is None else 'm'}" if not self.turns else "angles in rad"
        slope = f"; ground inclined by {math.degrees(self.slope):.3g}°" if self.slope else ""
        words = f"{ground}; triangle: start of the film{slope}"
        self.small_print = self.axes.text(side, self.low + 0.01 * self.half, words, ha="right", va="bottom")
        self.small_print.set(fontsize=7.5, color="#555555")

    def show(self, number: int) -> None:
        """Draw a frame."""
        camera, time, position = self.camera[number], self.times[number], self.position[number]
        modes = [CONTACT[int(side[number])] for side in self.sides]
        colour, words = modes[0]
        if len(modes) > 1:
            colour, words = (
                OUTLINE,
                ", ".join(f"{i} {loads}" for i, (_, loads) in enumerate(modes[:MOST_NAMED], start=1)),
            )
        contact = 0
        for shape, move in zip(self.shapes, self.movers, strict=True):
            x, y = shape.points[:, 0, number] - camera, shape.points[:, 1, number]
            move(x, y, modes[min(contact, len(modes) - 1)][0])
            contact += shape.shape.kind == "contact"
        size = scale(self.place, self.motion.system) * self.length
        unit = " rad" if self.turns else "" if self.motion.system.units is None else " m"
        first = self.step * math.floor((camera - self.reach) / self.step)
        self.ticks.set_xdata(np.repeat(first + self.step * self.marks - camera, 3))
        feet = {contact: float(self.soles[min(contact, len(self.soles)) - 1][number]) for contact in self.loads}
        under = BARE * self.half if self.loads else -1.0
        for i, label in enumerate(self.numbers):
            mark = first + self.step * i
            free = abs(mark - camera) < EDGE * self.half and all(abs(mark - x) > under for x in feet.values())
            label.set(x=mark - camera, text=f"{mark * size:.4g}", visible=free)
        self.flag.set_xdata([self.soles[0][0] - camera])
        earlier = time - self.motion.period
        clock = rf"time $\tau/T$ = {time / self.motion.period:.2f}"
        if not equations(self.motion.system).timed:
            clock = rf"time $\tau$ = {time:.2f}"
        if self.motion.system.units is not None:
            seconds = scale("time", self.motion.system)
            clock = f"time $t$ = {time * seconds:.{_decimals(self.motion.period * seconds, 2)}f} s"
        decimals = _decimals(float(np.ptp(self.position)) * size, 3)
        lines = [clock, f"{'angle' if self.turns else 'position $X$'} = {position * size:+.{decimals}f}{unit}"]
        if earlier >= 0.0 and self.motion.system.cyclic is not None:
            drift = position - self.motion.at(earlier, self.place)[0] / self.length
            lines.append(f"drift over the last period = {drift * size:+.{decimals + 1}f}{unit}")
        loads = [self._shown_load(i, float(load[number]), feet[i] - camera) for i, load in self.loads.items()]
        if loads:
            self.load_words.set_text("\n".join(loads[:MOST_NAMED]))
        self.clock.set_text("\n".join(lines))
        stopped = not self.motion.run_status.ok and time == self.motion.end
        self.state.set_text(f"ends: {self.motion.run_status.value}" if stopped else words)
        self.state.set_color(VERMILION if stopped else colour)

    def _shown_load(self, contact: int, load: float, x: float) -> str:
        """The true load of a contact in words, which is drawn as an arrow."""
        length, colour = abs(load) * self.load_size, PURPLE if load >= 0.0 else VERMILION
        ends = ((x, -length), (x, 0.0)) if load >= 0.0 else ((x, 0.0), (x, -length))
        arrow = self.arrows[contact]
        arrow.set_positions(*ends)
        arrow.set_color(colour)
        arrow.set_mutation_scale(HEAD * min(1.0, length / (SHORT * self.size)))
        arrow.set_visible(length > 1e-3)
        system = self.motion.system
        size, unit = scale("reaction", system), "" if system.units is None else " N"
        shown = round(load * size, 3) + 0.0  # no minus before a zero
        below = f"_{contact}" * (len(self.sides) > 1)
        words = rf"normal load $N{below}$ = {shown:.3f}{unit}"
        if not system.machine.follows_load:
            words = f"true {words}, taken as {float(system.placed.loads()[contact - 1]) * size:.4g}{unit}"
        return words + ("\nthe ground would have to pull" if shown < 0.0 else "")


def _decimals(range_: float, least: int) -> int:
    """How many decimals show a thousandth of a range, at least so many; of picometres and less that is rounding."""
    return max(least, 3 - math.floor(math.log10(range_))) if range_ > 1e-12 else least


Mover = Callable[[np.ndarray, np.ndarray, str], Any]  # x and y of the points of a shape, colour of the contact


def _drawn(moving: MovingShape, axes: Axes, inclined: Transform) -> Mover:
    """Draw a shape on axes, on inclined ground; returns what moves it to its place in a frame."""
    shape = moving.shape
    along: dict[str, Any] = {"transform": inclined}
    wide, tall = shape.size
    if shape.kind == "box":
        style = BoxStyle("round", pad=0, rounding_size=0.25 * min(wide, tall))
        box = FancyBboxPatch((0, 0), wide, tall, boxstyle=style, facecolor="#DCE6EF", edgecolor=OUTLINE, zorder=2)
        box.set_transform(inclined)
        axes.add_patch(box)
        return lambda x, y, colour: (box.set_x(x[0] - wide / 2), box.set_y(y[0] - tall / 2))
    if shape.kind == "disc":
        disc = Circle((0, 0), wide / 2, facecolor=BLUE, edgecolor=OUTLINE, zorder=5, **along)
        axes.add_patch(disc)
        return lambda x, y, colour: disc.set_center((x[0], y[0]))
    if shape.kind == "contact":
        line = axes.plot([], [], linewidth=6, solid_capstyle="butt", zorder=3, **along)[0]
        return lambda x, y, colour: line.set(xdata=[x[0] - wide / 2, x[0] + wide / 2], ydata=[y[0]] * 2, color=colour)
    if shape.kind == "hinge":
        along |= {"marker": "o", "markersize": 6, "color": "white", "markeredgecolor": OUTLINE, "zorder": 6}
        (hinge,) = axes.plot([], [], **along)
        return lambda x, y, colour: hinge.set_data(x, y)
    width = 2.2 if shape.kind == "rod" else 1.2
    path = axes.plot([], [], color=OUTLINE, linewidth=width, zorder=4, **along)[0]
    shown = _coils if shape.kind == "spring" else lambda x, y: (x, y)
    return lambda x, y, colour: path.set_data(*shown(x, y))


def _coils(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A zigzag from one point to the other."""
    along = np.array([x[1] - x[0], y[1] - y[0]])
    normal = np.array([-along[1], along[0]]) / max(float(np.hypot(*along)), 1e-12)
    share = np.concatenate(([0.0, 0.1], 0.1 + 0.8 * (np.arange(2 * COILS) + 0.5) / (2 * COILS), [0.9, 1.0]))
    aside = np.concatenate(([0.0, 0.0], WINDING * (-1.0) ** np.arange(2 * COILS), [0.0, 0.0]))
    return x[0] + share * along[0] + aside * normal[0], y[0] + share * along[1] + aside * normal[1]


def _shown_side(motion: Trajectory, times: np.ndarray, contact: int) -> np.ndarray:
    """The side of a contact; a stick shorter than the time between two frames is shown in one frame still."""
    if motion.system.laws[contact - 1].kind != "set-valued":
        return np.sign(motion.at(times, numbered("contact_velocity", contact))).astype(int)
    side = motion.at(times, numbered("side", contact)).astype(int)
    for phase in motion.phases_of(contact):
        if phase.side == STUCK and phase.end > times[0]:
            side[min(int(np.searchsorted(times, phase.start)), len(times) - 1)] = STUCK
    return side
