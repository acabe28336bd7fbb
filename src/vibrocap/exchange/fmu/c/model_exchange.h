/* Model exchange: rates, and guards as event indicators. The importer integrates and locates the events. */
#include "rates.h"

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
  if (!d->stale) return;
  if (d->phase <= INITIALIZING) begin_rates(d->values);
  d->stale = 0;
  evaluate(d->values, d->counts);
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
  double now = d->values[TIME];
  int bound;
  if (in_phase(c, EVENTS, EVENTS, "fmi3UpdateDiscreteStates")) return fmi3Error;
  *again = *terminate = *nominals = *states = false;
  *time_defined = SEGMENTS > 0;
  *time = take_segment(d->values) * TIME_FACTOR;
  d->stale = 1;
  switch (event(d->values, d->counts, &bound)) {
    case ENDS:
      d->status = bound_status[bound];
      *terminate = true;
      say(c, WARNING, "the motion ends at %.9g: %s", now * TIME_FACTOR, status_text(d->status));
      break;
    case BRANCHED:
      if (now != d->own.instant) d->own.instant = now, d->own.switches = 0;
      if (++d->own.switches > MOST_SWITCHES)
        return STATUS(WRONG("branches follow one another without end at %.9g", now * TIME_FACTOR));
      *states = *again = true;
      break;
    case STOPPED: *states = true; break;
    default: break;
  }
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
