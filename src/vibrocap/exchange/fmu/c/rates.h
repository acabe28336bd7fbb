/* Rates with the side of the contact as a discrete state, guards, and what happens where a guard has fallen to zero: the
   velocity of the contact becomes zero, and the force that would hold it decides whether it rests. Whoever uses it
   integrates and locates the events.

   v: the memory, places as said by names in capitals; counts: the side, then how often each kind of event occurred */
#ifndef RATES_H
#define RATES_H

/* Below so much of its natural size a velocity counts as zero; so a guard never starts from zero. */
#define STILL 1e-12
/* By so much of its period a time may fall short of a corner of the drive that was told. */
#define NEAR_CORNER 1e-14
#define MOST_SWITCHES 100 /* at one instant */

enum { GOES_ON, SIDE_DECIDED, STOPPED, BRANCHED, ENDS };

/* Rates, observables and guards at the present time, states and side. */
static void evaluate(double *v, int64_t *counts) {
  double *guard = v + INDICATOR;
  int k;
#if !SEGMENTS
  v[ORIGIN] = floor(v[TIME] / v[PERIOD]) * v[PERIOD];
#endif
  EQUATIONS(v);
  guard[0] = v[SIDE] == 0.0 ? v[LIMIT] - v[HOLD] : v[SIDE] * v[VELOCITY] + STILL * v[SCALE + CONTACT];
  guard[1] = v[SIDE] == 0.0 ? v[LIMIT] + v[HOLD] : 1.0;
  for (k = 0; k < BOUNDS; k++) guard[2 + k] = v[BOUND + k];
  for (k = 0; k < SWITCHES; k++) guard[2 + BOUNDS + k] = v[SWITCH + k] + STILL;
  counts[0] = (int64_t)v[SIDE];
}

/* The side of a contact at rest. At the limit it slides: an integrator that stops exactly there would find no event
   after it, and a contact that slides and should rest comes to rest at once. */
static double decided(double *v) {
  v[SIDE] = 0.0;
  EQUATIONS(v);
  return fabs(v[HOLD]) < v[LIMIT] ? 0.0 : v[HOLD] > 0.0 ? 1.0 : -1.0;
}

/* Count what has become of the side. */
static void turned(const double *v, int64_t *counts, double before) {
  double now = v[SIDE];
  if (now != before) counts[now == 0.0 ? 1 : before != 0.0 ? 4 : now > 0.0 ? 2 : 3]++;
}

/* The next branch of law or machine, after a guard has fallen; a velocity may jump. */
static void switched(double *v, int64_t *counts, int guard) {
  double before = v[SIDE], velocity = v[VELOCITY];
  AFTER(v, guard);
  memcpy(v + STATE, v + NEXT, STATES * sizeof *v);
  counts[count_of_switch[guard]]++;
  EQUATIONS(v);
  if (v[VELOCITY] != velocity) v[SIDE] = v[VELOCITY] > 0.0 ? 1.0 : -1.0;
  if (fabs(v[VELOCITY]) <= STILL * v[SCALE + CONTACT]) {
    v[STATE + CONTACT] -= v[VELOCITY];
    v[SIDE] = decided(v);
  }
  turned(v, counts, before);
}

/* What happens now, where a guard has fallen or the drive has jumped; bound: which of the equations' has fallen. */
static int event(double *v, int64_t *counts, int *bound) {
  double before;
  int k;
  evaluate(v, counts);
  for (k = 0; k < BOUNDS; k++)
    if (!(v[BOUND + k] > 0.0)) return *bound = k, ENDS;
  for (k = 0; k < SWITCHES; k++)
    if (!(v[INDICATOR + 2 + BOUNDS + k] > 0.0)) return switched(v, counts, k), BRANCHED;
  before = v[SIDE];
  if (before != 0.0 && v[INDICATOR] > 0.0) return GOES_ON;
  if (before != 0.0) v[STATE + CONTACT] -= v[VELOCITY];
  v[SIDE] = decided(v);
  turned(v, counts, before);
  return before != 0.0 ? STOPPED : SIDE_DECIDED;
}

/* The segment of the drive that holds from now on; the time at which it ends, where there are corners. */
static double take_segment(double *v) {
  double end = 0.0;
#if SEGMENTS
  const double *row = v + TABLE;
  double periods = floor(v[TIME] / v[PERIOD] + NEAR_CORNER * (1.0 + fabs(v[TIME] / v[PERIOD]))), power = 1.0;
  double now = v[TIME] / v[PERIOD] - periods + NEAR_CORNER * (1.0 + fabs(periods)), part = 0.0, start;
  int number, k;
#if PARTS > 1
  double time = v[TIME];
  part = floor(now * PARTS) < PARTS ? floor(now * PARTS) : PARTS - 1.0;
  v[ORIGIN] = 0.0, v[TIME] = part * (v[PERIOD] / PARTS);
  DRIVE(v);
  v[TIME] = time;
#endif
  start = part / PARTS;
  end = start + row[0];
  for (number = 0; number < SEGMENTS - 1 && end <= now; number++) {
    start = end;
    row += 1 + COEFFICIENTS;
    end += row[0];
  }
  v[ORIGIN] = periods * v[PERIOD];
  v[SEGMENT] = v[PERIOD];
  v[SEGMENT + 1] = start * v[PERIOD];
  for (k = 0; k < COEFFICIENTS; k++, power *= v[PERIOD]) v[SEGMENT + 2 + k] = row[1 + k] / power;
  if (number == SEGMENTS - 1) end = (part + 1.0) / PARTS;
  end = (periods + end) * v[PERIOD];
#else
  (void)v;
#endif
  return end;
}

/* The drive and the side at the start. */
static void begin_rates(double *v) {
  DRIVE(v);
  take_segment(v);
  v[SIDE] = decided(v);
  if (fabs(v[VELOCITY]) > STILL * v[SCALE + CONTACT]) v[SIDE] = v[VELOCITY] > 0.0 ? 1.0 : -1.0;
  else v[STATE + CONTACT] -= v[VELOCITY];
}

#endif
