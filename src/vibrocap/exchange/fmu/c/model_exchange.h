/* Model exchange: rates with the side of the contact as a discrete state, and guards as event indicators. The importer
   integrates and locates the events; at an event this file sets the velocity of the contact to zero, and the force
   that would hold it decides whether it rests. */

/* Below so much of its natural size a velocity counts as zero; so an indicator never starts from zero. */
#define STILL 1e-12
/* By so much of its period a time of the importer may fall short of a corner of the drive that it was told. */
#define NEAR_CORNER 1e-14

#define MOST_SWITCHES 100 /* at one instant */

static void begin(instance *c);

static void to_start(data *d) {
  memset(d, 0, sizeof *d);
  start_values(d->values);
  d->stale = 1;
}

static void input_changed(data *d) { UNUSED(d); }

/* The importer integrates, to its own tolerance. */
static int take_tolerance(data *d, double tolerance) {
  UNUSED(d);
  return tolerance > 0.0;
}

static int take_time(data *d, double time) {
  d->values[TIME] = time;
  return isfinite(time);
}

static void refresh(instance *c) {
  data *d = &c->now;
  double *v = d->values, *indicator = v + INDICATOR;
  int k;
  if (!d->stale) return;
  if (d->phase <= INITIALIZING) begin(c);
  d->stale = 0;
#if !SEGMENTS
  v[ORIGIN] = floor(v[TIME] / v[PERIOD]) * v[PERIOD];
#endif
  EQUATIONS(v);
  indicator[0] = v[SIDE] == 0.0 ? v[LIMIT] - v[HOLD] : v[SIDE] * v[VELOCITY] + STILL * v[SCALE + CONTACT];
  indicator[1] = v[SIDE] == 0.0 ? v[LIMIT] + v[HOLD] : 1.0;
  for (k = 0; k < BOUNDS; k++) indicator[2 + k] = v[BOUND + k];
  for (k = 0; k < SWITCHES; k++) indicator[2 + BOUNDS + k] = v[SWITCH + k] + STILL;
  d->counts[0] = (int64_t)v[SIDE];
}

/* The side of a contact at rest. At the limit it slides: an importer that stops exactly there would find no event
   after it, and a contact that slides and should rest comes to rest at once. */
static double decided(instance *c) {
  double *v = c->now.values;
  v[SIDE] = 0.0;
  EQUATIONS(v);
  return fabs(v[HOLD]) < v[LIMIT] ? 0.0 : v[HOLD] > 0.0 ? 1.0 : -1.0;
}

/* Count what has become of the side. */
static void turned(data *d, double before) {
  double now = d->values[SIDE];
  if (now != before) d->counts[now == 0.0 ? 1 : before != 0.0 ? 4 : now > 0.0 ? 2 : 3]++;
  d->stale = 1;
}

/* The next branch of law or machine, after a guard has fallen; a velocity may jump. */
static void switched(instance *c, int guard) {
  data *d = &c->now;
  double *v = d->values, before = v[SIDE], velocity = v[VELOCITY];
  AFTER(v, guard);
  memcpy(v + STATE, v + NEXT, STATES * sizeof *v);
  d->counts[count_of_switch[guard]]++;
  EQUATIONS(v);
  if (v[VELOCITY] != velocity) v[SIDE] = v[VELOCITY] > 0.0 ? 1.0 : -1.0;
  if (fabs(v[VELOCITY]) <= STILL * v[SCALE + CONTACT]) {
    v[STATE + CONTACT] -= v[VELOCITY];
    v[SIDE] = decided(c);
  }
  turned(d, before);
}

/* The segment of the drive that holds from now on; the time at which it ends, none where there are no corners. */
static double take_segment(data *d) {
  double *v = d->values, end = 0.0;
#if SEGMENTS
  const double *row = v + TABLE;
  double periods = floor(v[TIME] / v[PERIOD] + NEAR_CORNER * (1.0 + fabs(v[TIME] / v[PERIOD]))), start = 0.0, power = 1.0;
  double now = v[TIME] / v[PERIOD] - periods + NEAR_CORNER * (1.0 + fabs(periods));
  int number, k;
  end = row[0];
  for (number = 0; number < SEGMENTS - 1 && end <= now; number++) {
    start = end;
    row += 1 + COEFFICIENTS;
    end += row[0];
  }
  v[ORIGIN] = periods * v[PERIOD];
  v[SEGMENT] = v[PERIOD];
  v[SEGMENT + 1] = start * v[PERIOD];
  for (k = 0; k < COEFFICIENTS; k++, power *= v[PERIOD]) v[SEGMENT + 2 + k] = row[1 + k] / power;
  end = number == SEGMENTS - 1 ? (periods + 1.0) * v[PERIOD] : (periods + end) * v[PERIOD];
#else
  UNUSED(v);
#endif
  d->stale = 1;
  return end;
}

/* The drive and the side at the start. */
static void begin(instance *c) {
  double *v = c->now.values, velocity, side;
  DRIVE(v);
  take_segment(&c->now);
  side = decided(c);
  velocity = v[VELOCITY];
  v[SIDE] = velocity > 0.0 ? 1.0 : velocity < 0.0 ? -1.0 : side;
}

EXPORT fmi3Status FMI(ExitInitializationMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, INITIALIZING, INITIALIZING, "fmi3ExitInitializationMode")) return fmi3Error;
  refresh(c);
  c->now.phase = EVENTS;
  return fmi3OK;
}

EXPORT fmi3Status FMI(EnterEventMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, CONTINUOUS, EVENTS, "fmi3EnterEventMode")) return fmi3Error;
  c->now.phase = EVENTS;
  return fmi3OK;
}

EXPORT fmi3Status FMI(UpdateDiscreteStates)(
    fmi3Instance i, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals, fmi3Boolean *states,
    fmi3Boolean *time_defined, fmi3Float64 *time) {
  instance *c = i;
  data *d = &c->now;
  double *v = d->values, before;
  int k;
  if (in_phase(c, EVENTS, EVENTS, "fmi3UpdateDiscreteStates")) return fmi3Error;
  *again = *terminate = *nominals = *states = false;
  *time_defined = SEGMENTS > 0;
  *time = take_segment(d) * TIME_FACTOR;
  refresh(c);
  for (k = 0; k < BOUNDS; k++) {
    if (v[BOUND + k] > 0.0) continue;
    d->status = bound_status[k];
    *terminate = true;
    say(c, WARNING, "the motion ends at %.9g: %s", v[TIME] * TIME_FACTOR, status_text(d->status));
    return fmi3OK;
  }
  for (k = 0; k < SWITCHES; k++) {
    if (v[INDICATOR + 2 + BOUNDS + k] > 0.0) continue;
    if (v[TIME] != d->own.instant) d->own.instant = v[TIME], d->own.switches = 0;
    if (++d->own.switches > MOST_SWITCHES)
      return STATUS(WRONG("branches follow one another without end at %.9g", v[TIME] * TIME_FACTOR));
    switched(c, k);
    *states = *again = true;
    return fmi3OK;
  }
  before = v[SIDE];
  if (before != 0.0 && v[INDICATOR] > 0.0) return fmi3OK;
  if (before != 0.0) {
    v[STATE + CONTACT] -= v[VELOCITY];
    *states = true;
  }
  v[SIDE] = decided(c);
  turned(d, before);
  return fmi3OK;
}

EXPORT fmi3Status FMI(EnterContinuousTimeMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, EVENTS, EVENTS, "fmi3EnterContinuousTimeMode")) return fmi3Error;
  c->now.phase = CONTINUOUS;
  return fmi3OK;
}

EXPORT fmi3Status FMI(CompletedIntegratorStep)(
    fmi3Instance i, fmi3Boolean no_state_before, fmi3Boolean *event_mode, fmi3Boolean *terminate) {
  UNUSED(i), UNUSED(no_state_before);
  *event_mode = *terminate = false;
  return fmi3OK;
}

EXPORT fmi3Status FMI(SetTime)(fmi3Instance i, fmi3Float64 time) {
  instance *c = i;
  if (!take_time(&c->now, time / TIME_FACTOR)) return STATUS(WRONG("time should be " STARTS ", got %g", time));
  c->now.stale = 1;
  return fmi3OK;
}

static int of_size(instance *c, size_t given, size_t right, const char *what) {
  return given == right ? DONE : WRONG("there are %zu %s, got room for %zu", right, what, given);
}

EXPORT fmi3Status FMI(SetContinuousStates)(fmi3Instance i, const fmi3Float64 states[], size_t n) {
  instance *c = i;
  size_t k;
  if (of_size(c, n, STATES, "states")) return fmi3Error;
  for (k = 0; k < n; k++)
    if (!isfinite(states[k]))
      return STATUS(WRONG("%s should be a finite number, got %g", variables[STATE_VARIABLE + k].name, states[k]));
  for (k = 0; k < n; k++) c->now.values[STATE + k] = states[k] / variables[STATE_VARIABLE + k].factor;
  c->now.stale = 1;
  return fmi3OK;
}

static fmi3Status given_out(instance *c, int from, int place, double out[], size_t n, size_t right, const char *what) {
  size_t k;
  if (of_size(c, n, right, what)) return fmi3Error;
  refresh(c);
  for (k = 0; k < n; k++) out[k] = c->now.values[place + k] * (from < 0 ? 1.0 : variables[from + k].factor);
  return fmi3OK;
}

EXPORT fmi3Status FMI(GetContinuousStates)(fmi3Instance i, fmi3Float64 states[], size_t n) {
  return given_out(i, STATE_VARIABLE, STATE, states, n, STATES, "states");
}

EXPORT fmi3Status FMI(GetContinuousStateDerivatives)(fmi3Instance i, fmi3Float64 rates[], size_t n) {
  return given_out(i, RATE_VARIABLE, RATE, rates, n, STATES, "states");
}

EXPORT fmi3Status FMI(GetNominalsOfContinuousStates)(fmi3Instance i, fmi3Float64 nominals[], size_t n) {
  return given_out(i, STATE_VARIABLE, SCALE, nominals, n, STATES, "states");
}

EXPORT fmi3Status FMI(GetEventIndicators)(fmi3Instance i, fmi3Float64 indicators[], size_t n) {
  return given_out(i, -1, INDICATOR, indicators, n, 2 + BOUNDS + SWITCHES, "event indicators");
}

EXPORT fmi3Status FMI(GetNumberOfEventIndicators)(fmi3Instance i, size_t *n) {
  UNUSED(i);
  *n = 2 + BOUNDS + SWITCHES;
  return fmi3OK;
}

EXPORT fmi3Status FMI(GetNumberOfContinuousStates)(fmi3Instance i, size_t *n) {
  UNUSED(i);
  *n = STATES;
  return fmi3OK;
}

ABSENT_ALONE(EnterStepMode)
ABSENT(DoStep, fmi3Float64 time, fmi3Float64 length, fmi3Boolean no_state_before, fmi3Boolean *events,
       fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last)
