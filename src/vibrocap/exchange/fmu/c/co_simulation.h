/* FMI 3.0, co-simulation: event mode and early return at every event. */
#include "stepping.h"

EXPORT fmi3Status FMI(ExitInitializationMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, INITIALIZING, INITIALIZING, "fmi3ExitInitializationMode") || begin(c)) return fmi3Error;
  c->now.phase = c->event_mode ? EVENTS : STEPPING;
  c->now.stale = 1;
  return fmi3OK;
}

EXPORT fmi3Status FMI(EnterEventMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, STEPPING, STEPPING, "fmi3EnterEventMode")) return fmi3Error;
  c->now.phase = EVENTS;
  return fmi3OK;
}

EXPORT fmi3Status FMI(UpdateDiscreteStates)(
    fmi3Instance i, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals, fmi3Boolean *states,
    fmi3Boolean *time_defined, fmi3Float64 *time) {
  instance *c = i;
  if (in_phase(c, EVENTS, EVENTS, "fmi3UpdateDiscreteStates")) return fmi3Error;
  UNUSED(time);
  *again = *terminate = *nominals = *states = *time_defined = false;
  return fmi3OK;
}

EXPORT fmi3Status FMI(EnterStepMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, EVENTS, EVENTS, "fmi3EnterStepMode")) return fmi3Error;
  c->now.phase = STEPPING;
  return fmi3OK;
}

EXPORT fmi3Status FMI(DoStep)(
    fmi3Instance i, fmi3Float64 time, fmi3Float64 length, fmi3Boolean no_state_before, fmi3Boolean *events,
    fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
  instance *c = i;
  int event, status;
  *events = *terminate = *early = false;
  if (in_phase(c, STEPPING, STEPPING, "fmi3DoStep")) return fmi3Error;
  status = go_on(c, time, length, c->event_mode && c->early_return, &event);
  *last = event || status ? time_now(&c->now) * TIME_FACTOR : time + length;
  *events = event;
  *early = event && *last < time + length;
  *terminate = status == DISCARD;
  return STATUS(status);
}

/* Of model exchange only. */
ABSENT_ALONE(EnterContinuousTimeMode)
ABSENT(CompletedIntegratorStep, fmi3Boolean no_state_before, fmi3Boolean *event_mode, fmi3Boolean *terminate)
ABSENT(SetTime, fmi3Float64 time)
ABSENT(SetContinuousStates, const fmi3Float64 states[], size_t n)
ABSENT(GetContinuousStates, fmi3Float64 states[], size_t n)
ABSENT(GetContinuousStateDerivatives, fmi3Float64 rates[], size_t n)
ABSENT(GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t n)
ABSENT(GetEventIndicators, fmi3Float64 indicators[], size_t n)
ABSENT(GetNumberOfEventIndicators, size_t *n)
ABSENT(GetNumberOfContinuousStates, size_t *n)
