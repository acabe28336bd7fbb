"""The errata of the paper, as data: what it prints, what is right, and the claims that show it."""

import dataclasses


@dataclasses.dataclass(frozen=True)
class Erratum:
    """Where the paper errs. claims: keys of the claims whose verdicts show it with numbers."""

    number: int
    title: str
    where: str
    printed: str
    right: str
    claims: tuple[str, ...]


_ERRATA = (  # title, where, printed, right, claims
    (
        "The normal load is counted twice, and 1 is not the weight",
        "(5), (8), (9), (10); section 3",
        "The friction force is N f, and f of (8) and g of (10) already contain N. N = 1 is used for a capsule of mass"
        " ratio 2.5.",
        "The friction force contains N once; at N = 1 the two readings agree. N is scaled by m g, so that N = 1 is "
        "the weight of the pendulum alone: the static weight is N = lambda + 1, and with the vertical motion of the "
        "pendulum N(tau) = lambda + 1 - (theta'' sin(theta) + theta'^2 cos(theta)). In Figs 5-8 that load swings "
        "between about 0.52 and 5.15, so the contact would not lift off.",
        "load-counted-twice load-is-the-weight",
    ),
    (
        "alpha names two things",
        "(7), (8), (9)",
        "alpha is the exponent of the Stribeck term of LM (2) and, in (8), the rate of EM.",
        "(9) calls that rate a, and a = 10 is its value. With the rate 2 the friction at X' = 0.1 would be 0.396 "
        "instead of 0.260.",
        "one-alpha",
    ),
    (
        "Breakaway is not a point, and (11) lacks a sign",
        "(7), (10), (11)",
        "Bristles break away, and xi changes sign, where xi = g(X'); (10) is derived as the condition for it. (11) is"
        " given for either direction.",
        "(10) is the definition of g. At constant g the deflection approaches it exponentially in displacement, xi/g "
        "= 1 - exp(-x/g): 63 % after one g, 99.3 % after five. xi changes sign at xi = 0. (11) needs sgn(X') at its "
        "first term, and (X'/v_s)^alpha should read |X'/v_s|^alpha.",
        "breakaway-point steady-sliding stribeck-term presliding-is-linear",
    ),
    (
        "The offset points (14), (15) do not exist at the printed parameters",
        "(13)-(15); section 3",
        "Two offset points are given by (14) and by the recursion (15); delta2 = 0 is used.",
        "At delta2 = 0 steady friction falls at every speed: X'_l = 0 and X'_h is infinite. With C = alpha N (eta_s -"
        " eta_c)/(delta2 v_s) and alpha = 2 the points are exactly v_s sqrt(-W(-2/C^2)/2) with the two real branches "
        "of Lambert's W, and exist if and only if C >= sqrt(2 e), that is delta2 <= 2.5733 for the paper's values. At"
        " delta2 = 0.4 they are 0.006696630374612 and 0.181821489161179; (14) gives 0.0066667. (15) is right for "
        "alpha = 2 only; in general x_(n+1) = {ln[C x_n^(alpha-1)]}^(1/alpha).",
        "offset-points-exist monotone-between-offsets lower-offset upper-offset upper-offset-near-stribeck",
    ),
    (
        "A negative slope does not stabilise",
        "section 3.1",
        "The negative slope of the friction curve guarantees the stability of the system.",
        "It is the other way round. Where friction falls with speed, a small gain in speed lowers the resistance and "
        "grows: for a capsule of mass lambda + 1 that slides steadily at X' = 0.1, at a rate of 0.32 with EM and 0.66"
        " with LM. The motion stays bounded because of the damper of the pendulum and the Coulomb level.",
        "negative-slope-stabilises",
    ),
    (
        "The motion of Fig. 7 is not quasi-periodic",
        "section 3.1, Fig. 7",
        "The ends of the cycle do not overlap; the motion is quasi-periodic because of the hysteresis of friction.",
        "Modulo X the motion has exactly the period of the drive. The gap is the drift of one period, 0.1072 with LM "
        "and 0.1643 with EM, which has no hysteresis.",
        "not-strictly-periodic quasi-periodic gap-from-hysteresis bounded",
    ),
    (
        "The loops of Fig. 8 run the other way at the printed delta1",
        "section 3.1, Figs 3 and 8",
        "In pure sliding friction is larger while accelerating; the largest force is lower with LM than with EM.",
        "To first order R - R_steady = (delta1 - delta0 g/v) g'(v) v'. At the speed v* where delta1 v* = R_steady(v*)"
        " the force does not depend on xi at all; below it friction is larger while accelerating, above it while "
        "decelerating. At the printed delta1 = 10, v* = 0.0405, so that almost all of pure sliding runs opposite to "
        "the text, and the largest |R| is 0.459, more than N eta_s = 0.45. The text describes a delta1 of about 1 or "
        "less; 10 is probably a misprint.",
        "loop-of-imposed-sliding forward-loop-in-sliding backward-loop-in-sliding order-reverses-at-m1 "
        "decline-beyond-m1 lower-peak-with-lm",
    ),
    (
        "Fig. 9 shows no steady state",
        "section 3.2, Figs 9-11; section 4",
        "The average velocity falls monotonically with lambda and is zero at 4.0 (LM) and 2.2 (EM); the curves of LM "
        "and EM cross at 1.18 and 4.36.",
        "At the printed parameters every settled motion found is its own mirror image under the half-period "
        "symmetry, so that its mean velocity is exactly zero for every lambda, with both laws. Only the transient "
        "moves the capsule, and an average over it depends on its window; no window tried, from 1 to 100 periods, "
        "gives any of the four printed points. A curve of the printed shape appears as a steady state for a softer "
        "spring, rho of about 0.55 to 0.62, for which the upright pendulum buckles: at rho = 0.58 the drift vanishes "
        "at lambda = 4.2153 (LM) and 3.4562 (EM), and both drift alike at 0.7749 and 5.4894. A velocity means "
        "something only together with its window.",
        "steady-progress monotone-lm monotone-em control-point-o1 control-point-o2 boundary-point-p1 "
        "boundary-point-p2 control-by-mass-ratio",
    ),
)
ERRATA = tuple(
    Erratum(number, title, where, printed, right, tuple(claims.split()))
    for number, (title, where, printed, right, claims) in enumerate(_ERRATA, 1)
)


def errata_page() -> str:
    """The page of errata, in Markdown: `python -m vibrocap.paper.errata` prints it, and the site holds it."""
    head = """# Errata of the paper

P. Liu, H. Yu and S. Cang, *Modelling and analysis of dynamic frictional interactions of vibro-driven
capsule systems with viscoelastic property*: differences between the paper and this software, with reasons.
Each erratum names the claims that show it with numbers: `vibrocap reproduce` computes them,
`tests/test_paper.py` keeps them.
"""
    return head + "".join(
        f"\n## {erratum.number}. {erratum.title}\n\n*{erratum.where}*\n\n**Printed.** {erratum.printed}\n\n"
        f"**Right.** {erratum.right}\n\nClaims: {', '.join(f'`{key}`' for key in erratum.claims)}.\n"
        for erratum in ERRATA
    )


if __name__ == "__main__":
    print(errata_page(), end="")
