"""vibrocap: vibro-driven capsules and the friction dynamics under them.

A name is imported from where it stands when it is first asked for, so that `import vibrocap` costs little.
"""

import vibrocap.working_folder  # noqa: F401, I001  # before all that a stranger's folder could give
from typing import TYPE_CHECKING, Any

from vibrocap.lazy_imports import lazy as _lazy

if TYPE_CHECKING:  # read by type checkers, and by `_lazy`
    from vibrocap.case.case import Case, CaseError, read_case, save_case
    from vibrocap.case.drive_file import read_drive_table
    from vibrocap.citations.cite import Citations, cite
    from vibrocap.contracts.check_part import PartReport, check_part
    from vibrocap.design.bounds import PerformanceBound, performance_bounds
    from vibrocap.design.calibration.calibration import CalibratedParameter, Calibration, calibrate
    from vibrocap.design.calibration.motion_fit import MotionFit, fit_motion
    from vibrocap.design.front import ParetoFront, pareto_front
    from vibrocap.design.optimise import Optimum, OptimumStatus, optimise
    from vibrocap.design.robustness import Robustness, robustness
    from vibrocap.design.shapes import drive_shape
    from vibrocap.exchange.stepper import InputStepper, Instant, MotionEnded, Stepper, StepperEvent, stepper
    from vibrocap.exchange.stepper_array import StepperArray
    from vibrocap.identification.experiments.comparison import Comparison, Match, compare, match
    from vibrocap.identification.experiments.experiment_design import (
        ExperimentDesign,
        candidate_motions,
        experiment_design,
    )
    from vibrocap.identification.experiments.parameter_samples import Bootstrap, Posterior, bootstrap, posterior
    from vibrocap.identification.experiments.term_choice import TermChoice, choose_terms
    from vibrocap.identification.fit import fit, steady_fit
    from vibrocap.identification.fit_result import Fit
    from vibrocap.identification.spring_fit import spring_fit
    from vibrocap.io.labelled import to_pandas, to_xarray
    from vibrocap.io.motion_file import write_motion
    from vibrocap.io.study_file import write_study
    from vibrocap.laboratory.contact_sizes import ContactSizes, contact_sizes
    from vibrocap.laboratory.driven import Driven, DrivenSet, driven_force, driven_forces
    from vibrocap.laboratory.loops import Creep, FrictionalLag, PreslidingLoop, creep, frictional_lag, presliding_loop
    from vibrocap.laboratory.passivity import Passivity, passivity
    from vibrocap.laboratory.pulled_block import BreakAway, break_away, stick_slip_test
    from vibrocap.laboratory.regularisation import Regularisation, WidthNeeded, regularisation_error, width_for
    from vibrocap.laboratory.stiffness import StiffnessReport, stiffness_report
    from vibrocap.laboratory.test_sheet import TestSheet, test_sheet
    from vibrocap.measures.during_run import measure_table, measured
    from vibrocap.measures.ensemble import ensemble
    from vibrocap.measures.measure import Measure
    from vibrocap.measures.recorded.energy import EnergyBalance, energy_balance
    from vibrocap.measures.recorded.friction_loop import FrictionCurve, FrictionLoop, friction_curve, friction_loop
    from vibrocap.measures.recorded.limits import (
        FrictionalLimits,
        boundary_velocity,
        frictional_limits,
        offset_points,
        steady_friction,
        steady_slope,
    )
    from vibrocap.measures.recorded.settling import ResponseClass, Settling, response_class, settling
    from vibrocap.measures.recorded.sticking import StickPhases, mode_sequence, stick_fraction, stick_phases
    from vibrocap.measures.recorded.travel import MeanVelocity, displacement, drift, mean_velocity, winding
    from vibrocap.motion.certificate import Certificate
    from vibrocap.motion.contact_modes import ContactModes, contact_modes
    from vibrocap.motion.simulate import Start, simulate
    from vibrocap.motion.status import Status
    from vibrocap.motion.trajectory import Event, Phase, Trajectory
    from vibrocap.orbits.attractors.attractors import Attractor, Attractors, attractors
    from vibrocap.orbits.attractors.basins import Basins, basins
    from vibrocap.orbits.attractors.bifurcation_diagram import BifurcationDiagram, bifurcation_diagram
    from vibrocap.orbits.attractors.classification import MotionClass, classify
    from vibrocap.orbits.attractors.lyapunov import LyapunovExponents, ZeroOneTest, lyapunov_exponent, zero_one_test
    from vibrocap.orbits.closing.autonomous_orbit import Section
    from vibrocap.orbits.closing.gradients import Gradients
    from vibrocap.orbits.closing.orbit import Orbit, OrbitStatus, orbit, shoot
    from vibrocap.orbits.continuation.branch import Branch, branch
    from vibrocap.orbits.continuation.branch_diagram import BranchDiagram, branches
    from vibrocap.orbits.continuation.crossing import BranchCrossing, Crossings, crossing
    from vibrocap.orbits.continuation.crossing_bracket import Crossing, CrossingKind
    from vibrocap.orbits.continuation.hopf_cycles import hopf_cycles
    from vibrocap.orbits.equilibria.equilibrium import Equilibria, Equilibrium, equilibria
    from vibrocap.orbits.equilibria.equilibrium_branch import EquilibriumBranch, equilibrium_branch
    from vibrocap.orbits.walk.kinds import BranchEnd, ModeChange, SpecialKind
    from vibrocap.orbits.walk.special_points import SpecialPoint
    from vibrocap.physics.catalogue import register, unregister
    from vibrocap.physics.closed_loop.actuator import Actuator
    from vibrocap.physics.controllers.computed_torque import (
        AngleComputedTorque,
        PositionComputedForce,
        StrokeComputedTorque,
    )
    from vibrocap.physics.controllers.friction_observer import FrictionObserver
    from vibrocap.physics.controllers.pid import (
        AnglePID,
        PositionPID,
        SampledAnglePID,
        SampledPositionPID,
        SampledVelocityPI,
        VelocityPI,
    )
    from vibrocap.physics.controllers.sliding_mode import AngleSlidingMode, PositionSlidingMode
    from vibrocap.physics.dimensions.scales import (
        FreeScales,
        InnerMassScales,
        PendulumScales,
        Scales,
        SIScales,
        WeightScales,
    )
    from vibrocap.physics.drives.breakpoints import OnOff, PulseWidth, Square, Trapezoid, Triangle
    from vibrocap.physics.drives.harmonics import Biharmonic, FourierSeries, Harmonic
    from vibrocap.physics.drives.loadings import Constant, Loading, Ramp
    from vibrocap.physics.drives.phases import Phases, SevenPhase, ThreePhase
    from vibrocap.physics.drives.scheduled import scheduled
    from vibrocap.physics.drives.table import DriveTable
    from vibrocap.physics.environment import Environment
    from vibrocap.physics.friction.bristles import ElastoPlastic, LuGre
    from vibrocap.physics.friction.curves import (
        Coulomb,
        Exponential,
        HyperbolicStribeck,
        SmoothedArctan,
        SmoothedTanh,
        Stribeck,
    )
    from vibrocap.physics.friction.hysteresis import BoucWen, Dahl
    from vibrocap.physics.friction.maxwell_slip import MaxwellSlip
    from vibrocap.physics.friction.rate_and_state import RateAndStateAgeing, RateAndStateSlip
    from vibrocap.physics.friction.wrappers import anisotropic, backlash, viscous
    from vibrocap.physics.machines.linkage_crawler import LinkageCrawler
    from vibrocap.physics.machines.oscillators import ModeCouplingBlock, Oscillator, OscillatorWithStops
    from vibrocap.physics.machines.pendulum_capsules import (
        DoublePendulumCapsule,
        PendulumCapsule,
        PendulumCapsuleWithStops,
        PendulumCrawler,
        RotorCapsule,
        TwoPendulumCapsule,
    )
    from vibrocap.physics.machines.rows import (
        ThreeBlockRow,
        ThreeBodyCrawler,
        ThreeBodyWorm,
        TwoBlockRow,
        TwoBodyCrawler,
        TwoBodyWorm,
        block_row,
        crawler,
        worm,
    )
    from vibrocap.physics.machines.turning_bodies import Clutch, DrillString
    from vibrocap.physics.machines.two_mass_capsules import (
        RigidStopCapsule,
        TwoMassCapsule,
        TwoMassCrawler,
        VibroImpactCapsule,
    )
    from vibrocap.physics.machines.vibrated_bodies import BristleRobot, Feeder
    from vibrocap.physics.parameters import parameter, parameters
    from vibrocap.physics.part_files import PartsError, load_parts
    from vibrocap.physics.system import System
    from vibrocap.plotting.designs import draw_calibration, draw_front
    from vibrocap.plotting.fits import draw_forces
    from vibrocap.plotting.histories import draw_history, draw_load
    from vibrocap.plotting.intervals import draw_intervals
    from vibrocap.plotting.laboratory import draw_presliding, draw_steady_curve
    from vibrocap.plotting.look.style import style
    from vibrocap.plotting.motion import draw_friction_loop, draw_phase_plane
    from vibrocap.plotting.plot import figure, plot, thumbnail
    from vibrocap.plotting.steady.basins import draw_basins
    from vibrocap.plotting.steady.branches import draw_branch, draw_floquet_multipliers
    from vibrocap.plotting.steady.diagrams import draw_bifurcation, draw_equilibria
    from vibrocap.plotting.studies.maps import draw_study
    from vibrocap.records.preparation import prepared
    from vibrocap.records.published import basalt_velocity_step, emps, paper_stick_slip, rotary_damper
    from vibrocap.records.reading.readers import read_records
    from vibrocap.records.record import Record, RecordError, RecordWarning
    from vibrocap.records.stick_slip import StickSlip, regime_diagram, stick_slip, stick_slip_of
    from vibrocap.studies.adaptive import adaptive_map, border
    from vibrocap.studies.dataset import open_study
    from vibrocap.studies.plan.designs import Design
    from vibrocap.studies.store.verification import Verification, verify_study
    from vibrocap.studies.sweep import sweep


__version__: str

if not TYPE_CHECKING:  # which would let every name pass
    _asked_for = _lazy(__name__, "vibrocap.quantities.opening:opened_in_si")

    def __getattr__(name: str) -> Any:
        if name != "__version__":
            return _asked_for(name)
        from importlib.metadata import version

        globals()[name] = version("vibrocap")
        return globals()[name]


def __dir__() -> list[str]:
    return _FACE.split()


# the paper's system and a motion of it
__all__ = ["Biharmonic", "Certificate", "Event", "Exponential", "Harmonic", "LuGre", "PendulumCapsule", "Phase"]
__all__ += ["Status", "System", "Trajectory", "simulate", "Start"]
# pictures and tables of any result
__all__ += ["plot", "figure", "style", "thumbnail", "to_xarray", "to_pandas"]
# studies
__all__ += ["sweep", "Design", "open_study", "verify_study", "Verification", "write_study", "adaptive_map"]
__all__ += ["write_motion", "border", "ensemble"]
# measures
__all__ += ["Measure", "measure_table", "measured", "displacement", "drift", "mean_velocity", "winding", "MeanVelocity"]
__all__ += ["settling", "Settling", "response_class", "ResponseClass", "energy_balance", "EnergyBalance"]
__all__ += ["stick_fraction", "stick_phases", "StickPhases", "mode_sequence", "friction_loop", "FrictionLoop"]
__all__ += ["friction_curve", "FrictionCurve", "frictional_limits", "FrictionalLimits", "boundary_velocity"]
__all__ += ["offset_points", "steady_friction", "steady_slope"]
# friction laws under test
__all__ += ["driven_force", "driven_forces", "Driven", "DrivenSet", "presliding_loop", "PreslidingLoop"]
__all__ += ["frictional_lag", "FrictionalLag", "break_away", "BreakAway", "stick_slip_test", "creep", "Creep"]
__all__ += ["test_sheet", "TestSheet", "passivity", "Passivity", "stiffness_report", "StiffnessReport"]
__all__ += ["regularisation_error", "Regularisation", "width_for", "WidthNeeded"]
# steady motions
__all__ += ["orbit", "Orbit", "OrbitStatus", "Gradients", "Section", "shoot", "attractors", "Attractors", "Attractor"]
__all__ += ["basins", "Basins", "bifurcation_diagram", "BifurcationDiagram", "classify", "MotionClass"]
__all__ += ["lyapunov_exponent", "LyapunovExponents", "zero_one_test", "ZeroOneTest", "crossing", "Crossing"]
__all__ += ["CrossingKind", "Crossings"]
# equilibria
__all__ += ["equilibria", "Equilibria", "Equilibrium", "equilibrium_branch", "EquilibriumBranch", "hopf_cycles"]
# measured data
__all__ += ["Record", "RecordError", "RecordWarning", "read_records", "prepared", "stick_slip", "stick_slip_of"]
__all__ += ["StickSlip", "regime_diagram", "rotary_damper", "paper_stick_slip", "basalt_velocity_step", "emps"]
# cases and their units
__all__ += ["Case", "CaseError", "read_case", "save_case", "Scales", "PendulumScales", "FreeScales", "SIScales"]
# what surrounds and drives a machine
__all__ += ["Actuator", "Environment"]
# what controls it
__all__ += ["AnglePID", "PositionPID", "SampledAnglePID", "SampledPositionPID", "SampledVelocityPI", "VelocityPI"]
__all__ += ["AngleComputedTorque", "FrictionObserver", "PositionComputedForce", "StrokeComputedTorque"]
__all__ += ["AngleSlidingMode", "PositionSlidingMode"]
# what to cite
__all__ += ["cite", "Citations"]
# machines
__all__ += ["Oscillator", "OscillatorWithStops", "TwoMassCrawler", "PendulumCrawler", "TwoMassCapsule"]
__all__ += ["VibroImpactCapsule", "RigidStopCapsule", "RotorCapsule", "TwoBodyCrawler", "ThreeBodyCrawler", "crawler"]
__all__ += ["LinkageCrawler", "contact_modes", "ContactModes", "TwoBodyWorm", "ThreeBodyWorm", "worm"]
__all__ += ["ModeCouplingBlock", "TwoBlockRow", "ThreeBlockRow", "block_row", "PendulumCapsuleWithStops"]
__all__ += ["InnerMassScales", "WeightScales", "TwoPendulumCapsule", "DoublePendulumCapsule", "DrillString", "Clutch"]
__all__ += ["Feeder", "BristleRobot"]
# drives
__all__ += ["Constant", "Ramp", "Loading", "Square", "Triangle", "Trapezoid", "OnOff", "PulseWidth", "Phases"]
__all__ += ["ThreePhase", "SevenPhase", "FourierSeries", "DriveTable", "read_drive_table", "scheduled"]
# friction laws
__all__ += ["BoucWen", "Coulomb", "Dahl", "ElastoPlastic", "HyperbolicStribeck", "MaxwellSlip", "RateAndStateAgeing"]
__all__ += ["RateAndStateSlip", "SmoothedArctan", "SmoothedTanh", "Stribeck", "anisotropic", "backlash", "viscous"]
__all__ += ["contact_sizes", "ContactSizes"]
# branches
__all__ += ["branch", "Branch", "branches", "BranchDiagram", "BranchEnd", "BranchCrossing", "SpecialPoint"]
__all__ += ["SpecialKind", "ModeChange"]
# design
__all__ += ["optimise", "Optimum", "OptimumStatus", "pareto_front", "ParetoFront", "performance_bounds"]
__all__ += ["PerformanceBound", "robustness", "Robustness", "drive_shape", "calibrate", "Calibration"]
__all__ += ["CalibratedParameter", "fit_motion", "MotionFit"]
# a motion that is moved on from outside
__all__ += ["stepper", "Stepper", "InputStepper", "StepperArray", "StepperEvent", "Instant", "MotionEnded"]
# identification
__all__ += ["fit", "Fit", "steady_fit", "spring_fit", "bootstrap", "Bootstrap", "compare", "Comparison", "posterior"]
__all__ += ["Posterior", "choose_terms", "TermChoice", "match", "Match", "experiment_design", "ExperimentDesign"]
__all__ += ["candidate_motions"]
# pictures into axes that are given
__all__ += ["draw_history", "draw_phase_plane", "draw_friction_loop", "draw_load", "draw_study", "draw_branch"]
__all__ += ["draw_floquet_multipliers", "draw_forces", "draw_intervals", "draw_basins", "draw_steady_curve"]
__all__ += ["draw_presliding", "draw_equilibria", "draw_bifurcation", "draw_front", "draw_calibration"]
# parts of one's own
__all__ += ["register", "unregister", "load_parts", "parameter", "parameters", "check_part", "PartReport", "PartsError"]

# What completion offers, for every day; `vibrocap` has all other names above, too.
_FACE: str = """
System Environment Actuator Case read_case save_case Start Section Measure Record Design
simulate sweep adaptive_map ensemble open_study stepper write_motion write_study to_pandas to_xarray
orbit branch basins attractors bifurcation_diagram lyapunov_exponent crossing equilibria equilibrium_branch hopf_cycles
classify settling optimise pareto_front robustness performance_bounds calibrate
fit steady_fit fit_motion compare match read_records read_drive_table plot figure style
mean_velocity stick_fraction mode_sequence energy_balance friction_loop frictional_limits contact_modes measure_table
cite load_parts register check_part
PendulumCapsule PendulumCapsuleWithStops TwoPendulumCapsule DoublePendulumCapsule TwoMassCapsule VibroImpactCapsule
RigidStopCapsule RotorCapsule TwoMassCrawler PendulumCrawler LinkageCrawler crawler worm block_row Oscillator
OscillatorWithStops ModeCouplingBlock DrillString Clutch Feeder BristleRobot
Exponential LuGre Coulomb Stribeck HyperbolicStribeck Dahl ElastoPlastic MaxwellSlip BoucWen SmoothedTanh
RateAndStateAgeing RateAndStateSlip
Harmonic Biharmonic Square Triangle PulseWidth OnOff Phases FourierSeries DriveTable Constant Ramp
PositionPID AnglePID VelocityPI
"""
