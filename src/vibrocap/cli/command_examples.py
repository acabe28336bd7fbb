"""Examples: of every command, as they stand under its help (tests run them in this order), and the example cases."""

from pathlib import Path

EXAMPLES: dict[str, tuple[str, ...]] = {
    "new": (
        "vibrocap new --out case.toml",
        "vibrocap new --si --out bench.toml",
        "vibrocap new oscillator --law dahl --drive ramp",
    ),
    "examples": ("vibrocap examples", "vibrocap examples --to examples"),
    "simulate": (
        "vibrocap simulate case.toml --initial angle=0.5",
        "vibrocap simulate examples/travels-by-stick-slip.toml --plot run.png",
        "vibrocap simulate examples/bristles-lugre.toml --json --out run.nc",
        "vibrocap simulate run.nc --set machine.mass_ratio=1.5 --periods 20",
    ),
    "convert": (
        "vibrocap convert examples/travels-by-stick-slip.toml --scales pendulum_mass_kg=0.2,pendulum_length_m=0.25",
        "vibrocap convert bench.toml --out bench-without-units.toml",
    ),
    "limits": (
        "vibrocap limits examples/bristles-lugre.toml",
        "vibrocap limits examples/bristles-with-offset-points.toml --json",
    ),
    "measures": ("vibrocap measures", "vibrocap measures examples/bristles-lugre.toml"),
    "sweep": (
        "vibrocap sweep case.toml --over drive.amplitude=1:3:20 --out line",
        "vibrocap sweep case.toml --over machine.mass_ratio=log:0.2:8:20"
        " --over drive.amplitude=1:3:10 --measure mean_velocity,mode_sequence --out map",
        "vibrocap sweep case.toml --over friction.law=lugre,dahl --export laws.csv",
    ),
    "verify": ("vibrocap verify map",),
    "plot": (
        "vibrocap plot map --measure mean_velocity --out map.png",
        "vibrocap plot map --at drive.amplitude=1.8 --out line.pdf --width column --no-header",
    ),
    "orbit": (
        "vibrocap orbit examples/travels-by-stick-slip.toml",
        "vibrocap orbit examples/travels-by-stick-slip.toml --half --json",
        "vibrocap orbit examples/bench-in-si.toml --gradients",
    ),
    "branch": ("vibrocap branch case.toml --over drive.amplitude=1:1.5 --plot branch.png",),
    "basins": ("vibrocap basins case.toml --plane angle,angle_rate --resolution 20",),
    "equilibria": (
        "vibrocap equilibria examples/slides-or-sticks-by-its-start.toml",
        "vibrocap equilibria examples/slides-or-sticks-by-its-start.toml --over machine.belt_speed=0.5:2"
        " --plot hopf.png",
    ),
    "optimise": (
        "vibrocap optimise case.toml --over drive.frequency=0.5:3 --evaluations 200 --out design",
        "vibrocap optimise case.toml --over drive.frequency=0.5:3 --over machine.damping=0.3:3 "
        "--against cost_of_transport --evaluations 400 --out front",
    ),
    "robust": (
        "vibrocap robust examples/travels-by-stick-slip.toml --uncertain machine.damping=0.9:1.1 "
        "--uncertain friction.coulomb_coefficient,friction.static_coefficient=factor:0.8:1.2 --samples 64",
    ),
    "bound": ("vibrocap bound examples/travels-by-stick-slip.toml",),
    "calibrate": (
        "vibrocap calibrate examples/bench-in-si.toml --to examples/bench-in-si-speeds.csv "
        "--over friction.coulomb_coefficient=0.02:0.2 --over machine.damping_N_m_s_per_rad=0.02:0.3 --out calibrated",
    ),
    "crossing": ("vibrocap crossing case.toml --over drive.amplitude=1:3 --points 20",),
    "lab": ("vibrocap lab examples/travels-by-stick-slip.toml --laws exponential --drives harmonic --out lab.html",),
    "export": (
        "vibrocap export examples/travels-by-stick-slip.toml --to c --out capsule",
        "vibrocap export examples/travels-by-stick-slip.toml --to c --input drive --out capsule",
        "vibrocap export examples/travels-by-stick-slip.toml --to mjcf --out capsule.xml",
        "vibrocap export examples/bench-in-si.toml --to fmu --input drive --out capsule.fmu",
    ),
    "friction": ("vibrocap friction test lugre --plot tests.png",),
    "friction list": ("vibrocap friction list",),
    "friction show": (
        "vibrocap friction show lugre --plot lugre.png",
        "vibrocap friction show dahl --set bristle_stiffness=1e3",
    ),
    "friction test": ("vibrocap friction test coulomb --plot tests.png",),
    "machines": (
        "vibrocap machines",
        "vibrocap machines pendulum-capsule",
        "vibrocap machines drill-string --latex",
    ),
    "check": ("vibrocap check lugre --quick", "vibrocap check --parts mylaws.py"),
    "fit": (
        "vibrocap fit damper.csv --law dahl --out fit --plot fit.png",
        "vibrocap fit damper.csv --compare coulomb,dahl --json",
        "vibrocap fit axis.csv --machine axis.toml --predict position --over machine.mass_kg=50:200",
    ),
    "stick-slip": ("vibrocap stick-slip pull.csv --stiffness 168 --speed 42e-6 --plot pull.png",),
    "datasets": ("vibrocap datasets list",),
    "datasets list": ("vibrocap datasets list",),
    "datasets fetch": ("vibrocap datasets fetch rotary-damper --to data",),
    "cite": (
        "vibrocap cite examples/bristles-lugre.toml",
        "vibrocap cite examples/bristles-lugre.toml --analyses orbit,fit --bibtex",
    ),
    "reproduce": ("vibrocap reproduce --out out", "vibrocap reproduce --only fig09"),
    "completion": ("vibrocap completion bash", "vibrocap completion zsh --install"),
}


def examples_of(command: str) -> str:
    """What stands under the help of a command."""
    return "Examples:\n\n" + "".join(f"  {line}\n" for line in EXAMPLES[command])


def examples_folder() -> Path:
    """The example cases: in the package where it was installed from a wheel, else in the folder of the sources."""
    package = Path(__file__).resolve().parents[1]
    inside = package / "examples"
    return inside if inside.is_dir() else package.parents[1] / "examples"


def tables_of(case: Path) -> list[Path]:
    """The measured tables of an example, whose names begin with its own."""
    return sorted(case.parent.glob(f"{case.stem}-*.csv"))


def shows(path: Path) -> str:
    """What an example shows: the first sentence of its head."""
    words = []
    for line in path.read_text(encoding="utf-8").splitlines():
        if not line.removeprefix("#").strip():
            break
        words.append(line.removeprefix("#").strip())
    return " ".join(words).partition(". ")[0].rstrip(".:")
