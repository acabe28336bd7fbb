/* FMI 3.0, co-simulation: event mode and early return at every event. */
#include "fmi3.h"
#include "stepping.h"

static void tell(instance *c, int status, const char *text) {
  char line[500];
  snprintf(line, sizeof line, "%s: %s", c->name, text);
  ((fmi3LogMessageCallback)c->log)(
      c->environment, (fmi3Status)status, status == ERROR ? "logStatusError" : "logStatusWarning", line);
}

#define VERSION "3.0"
#define PREFIX "fmi3"
#define OF(name) fmi3##name
#define FMU_STATE(before, behind) FMI(before##FMUState##behind)
#define DESERIALIZE FMI(DeserializeFMUState)
#include "shared.h"

#define SIZED(n, count) \
  if (n != count) return STATUS(WRONG("%zu value references for %zu values", n, count))

EXPORT fmi3Status FMI(EnterInitializationMode)(
    fmi3Instance i, fmi3Boolean tolerance_defined, fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean stop_defined,
    fmi3Float64 stop) {
  instance *c = i;
  UNUSED(stop_defined), UNUSED(stop);
  if (in_phase(c, INSTANTIATED, "fmi3EnterInitializationMode")) return fmi3Error;
  return STATUS(set_up(c, tolerance_defined, tolerance, start) || enter(c, INITIALIZING) ? ERROR : DONE);
}

/* Values. */

EXPORT fmi3Status FMI(GetFloat64)(
    fmi3Instance i, const fmi3ValueReference references[], size_t n, fmi3Float64 values[], size_t count) {
  instance *c = i;
  SIZED(n, count);
  return STATUS(get_real(c, references, n, values));
}

EXPORT fmi3Status FMI(SetFloat64)(
    fmi3Instance i, const fmi3ValueReference references[], size_t n, const fmi3Float64 values[], size_t count) {
  instance *c = i;
  SIZED(n, count);
  return STATUS(set_real(c, references, n, values));
}

EXPORT fmi3Status FMI(GetInt64)(
    fmi3Instance i, const fmi3ValueReference references[], size_t n, fmi3Int64 values[], size_t count) {
  instance *c = i;
  size_t k;
  SIZED(n, count);
  for (k = 0; k < n; k++)
    if (get_whole(c, references[k], &values[k])) return fmi3Error;
  return fmi3OK;
}

EXPORT fmi3Status FMI(GetString)(
    fmi3Instance i, const fmi3ValueReference references[], size_t n, fmi3String values[], size_t count) {
  instance *c = i;
  size_t k;
  SIZED(n, count);
  for (k = 0; k < n; k++)
    if (get_text(c, references[k], &values[k])) return fmi3Error;
  return fmi3OK;
}

/* Of the other types there are no variables. */
#define NO_GET(Type)                                                                                                  \
  EXPORT fmi3Status FMI(Get##Type)(                                                                                   \
      fmi3Instance i, const fmi3ValueReference references[], size_t n, fmi3##Type values[], size_t count) {           \
    instance *c = i;                                                                                                  \
    UNUSED(references), UNUSED(values), UNUSED(count);                                                                \
    return n ? STATUS(WRONG("there are no variables of the type " #Type)) : fmi3OK;                                   \
  }
#define NO_SET(Type)                                                                                                  \
  EXPORT fmi3Status FMI(Set##Type)(                                                                                   \
      fmi3Instance i, const fmi3ValueReference references[], size_t n, const fmi3##Type values[], size_t count) {     \
    instance *c = i;                                                                                                  \
    UNUSED(references), UNUSED(values), UNUSED(count);                                                                \
    return n ? STATUS(WRONG("there are no variables of the type " #Type " that can be set")) : fmi3OK;                \
  }
NO_GET(Float32) NO_GET(Int8) NO_GET(UInt8) NO_GET(Int16) NO_GET(UInt16) NO_GET(Int32) NO_GET(UInt32) NO_GET(UInt64)
NO_GET(Boolean)
NO_SET(Float32) NO_SET(Int8) NO_SET(UInt8) NO_SET(Int16) NO_SET(UInt16) NO_SET(Int32) NO_SET(UInt32) NO_SET(Int64)
NO_SET(UInt64) NO_SET(Boolean) NO_SET(String)

/* Steps. */

EXPORT fmi3Status FMI(ExitInitializationMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, INITIALIZING, "fmi3ExitInitializationMode") || begin(c)) return fmi3Error;
  return STATUS(enter(c, c->event_mode ? EVENTS : STEPPING));
}

EXPORT fmi3Status FMI(EnterEventMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, STEPPING, "fmi3EnterEventMode")) return fmi3Error;
  c->now.phase = EVENTS;
  return fmi3OK;
}

EXPORT fmi3Status FMI(UpdateDiscreteStates)(
    fmi3Instance i, fmi3Boolean *again, fmi3Boolean *terminate, fmi3Boolean *nominals, fmi3Boolean *states,
    fmi3Boolean *time_defined, fmi3Float64 *time) {
  instance *c = i;
  if (in_phase(c, EVENTS, "fmi3UpdateDiscreteStates")) return fmi3Error;
  UNUSED(time);
  *again = *terminate = *nominals = *states = *time_defined = false;
  return fmi3OK;
}

EXPORT fmi3Status FMI(EnterStepMode)(fmi3Instance i) {
  instance *c = i;
  if (in_phase(c, EVENTS, "fmi3EnterStepMode")) return fmi3Error;
  c->now.phase = STEPPING;
  return fmi3OK;
}

EXPORT fmi3Status FMI(DoStep)(
    fmi3Instance i, fmi3Float64 time, fmi3Float64 length, fmi3Boolean no_state_before, fmi3Boolean *events,
    fmi3Boolean *terminate, fmi3Boolean *early, fmi3Float64 *last) {
  instance *c = i;
  int event, status;
  UNUSED(no_state_before);
  *events = *terminate = *early = false;
  if (in_phase(c, STEPPING, "fmi3DoStep")) return fmi3Error;
  status = go_on(c, time, length, c->event_mode && c->early_return, &event);
  *last = event || status ? time_now(&c->now) : time + length;
  *events = event;
  *early = event && *last < time + length;
  *terminate = status == DISCARD;
  return STATUS(status);
}

/* What this FMU does not offer. */
#define REFERENCES const fmi3ValueReference *r, size_t n

#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
ABSENT(GetBinary, REFERENCES, size_t *sizes, fmi3Binary *values, size_t count)
ABSENT(SetBinary, REFERENCES, const size_t *sizes, const fmi3Binary *values, size_t count)
ABSENT(GetClock, REFERENCES, fmi3Clock *values)
ABSENT(SetClock, REFERENCES, const fmi3Clock *values)
ABSENT(GetNumberOfVariableDependencies, fmi3ValueReference r, size_t *n)
ABSENT(GetVariableDependencies, fmi3ValueReference r, size_t *places, fmi3ValueReference *independents,
       size_t *their_places, fmi3DependencyKind *kinds, size_t n)
ABSENT(GetDirectionalDerivative, REFERENCES, const fmi3ValueReference *knowns, size_t known, const fmi3Float64 *seed,
       size_t seeds, fmi3Float64 *found, size_t count)
ABSENT(GetAdjointDerivative, REFERENCES, const fmi3ValueReference *knowns, size_t known, const fmi3Float64 *seed,
       size_t seeds, fmi3Float64 *found, size_t count)
ABSENT(GetIntervalDecimal, REFERENCES, fmi3Float64 *intervals, fmi3IntervalQualifier *qualifiers)
ABSENT(GetIntervalFraction, REFERENCES, fmi3UInt64 *counters, fmi3UInt64 *resolutions, fmi3IntervalQualifier *q)
ABSENT(GetShiftDecimal, REFERENCES, fmi3Float64 *shifts)
ABSENT(GetShiftFraction, REFERENCES, fmi3UInt64 *counters, fmi3UInt64 *resolutions)
ABSENT(SetIntervalDecimal, REFERENCES, const fmi3Float64 *intervals)
ABSENT(SetIntervalFraction, REFERENCES, const fmi3UInt64 *counters, const fmi3UInt64 *resolutions)
ABSENT(SetShiftDecimal, REFERENCES, const fmi3Float64 *shifts)
ABSENT(SetShiftFraction, REFERENCES, const fmi3UInt64 *counters, const fmi3UInt64 *resolutions)
ABSENT(ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 time)
ABSENT(GetOutputDerivatives, REFERENCES, const fmi3Int32 *orders, fmi3Float64 *values, size_t count)
ABSENT(CompletedIntegratorStep, fmi3Boolean no_state_before, fmi3Boolean *event_mode, fmi3Boolean *terminate)
ABSENT(SetTime, fmi3Float64 time)
ABSENT(SetContinuousStates, const fmi3Float64 states[], size_t n)
ABSENT(GetContinuousStates, fmi3Float64 states[], size_t n)
ABSENT(GetContinuousStateDerivatives, fmi3Float64 rates[], size_t n)
ABSENT(GetNominalsOfContinuousStates, fmi3Float64 nominals[], size_t n)
ABSENT(GetEventIndicators, fmi3Float64 indicators[], size_t n)
ABSENT(GetNumberOfEventIndicators, size_t *n)
ABSENT(GetNumberOfContinuousStates, size_t *n)

#define ABSENT_ALONE(Name) \
  EXPORT fmi3Status FMI(Name)(fmi3Instance c) { return STATUS(WRONG("fmi3" #Name " is not offered by this FMU")); }
ABSENT_ALONE(EnterConfigurationMode)
ABSENT_ALONE(ExitConfigurationMode)
ABSENT_ALONE(EvaluateDiscreteStates)
ABSENT_ALONE(EnterContinuousTimeMode)

EXPORT fmi3Instance FMI(InstantiateScheduledExecution)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
    fmi3PreemptionCallback lock, fmi3PreemptionCallback unlock) {
  return made(name, token, environment, (void (*)(void))log, 0);
}

EXPORT fmi3Instance FMI(InstantiateModelExchange)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
  return made(name, token, environment, (void (*)(void))log, 0);
}

EXPORT fmi3Instance FMI(InstantiateCoSimulation)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference required[], size_t required_count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback intermediate) {
  instance *c = made(name, token, environment, (void (*)(void))log, 1);
  if (c) c->event_mode = event_mode, c->early_return = early_return;
  return c;
}
