/* FMI 3.0: what both kinds of FMU have in common. */
#include "fmi3.h"
#include "instance.h"

static void tell(void *environment, void *log, const char *name, int status, const char *text) {
  char line[500];
  fmi3LogMessageCallback call;
  memcpy(&call, &log, sizeof call);
  snprintf(line, sizeof line, "%s: %s", name, text);
  call(environment, (fmi3Status)status, status == fmi3Error ? "logStatusError" : "logStatusWarning", line);
}

#define ERROR(...) ((fmi3Status)say(c, fmi3Error, tell, __VA_ARGS__))
#define UNUSED(x) ((void)(x))

static fmi3Status in_phase(instance *c, int one, int other, const char *function) {
  static const char *const names[] = {"before initialization",       "initialization mode", "event mode",
                                      "continuous-time mode",        "step mode",           "after the end"};
  if (c->now.phase == one || c->now.phase == other) return fmi3OK;
  return ERROR("fmi3%s cannot be called now (%s)", function, names[c->now.phase]);
}

/* What each kind of FMU does in its own way. */
static void to_start(data *d);
static void refresh(instance *c);
static void input_changed(data *d);
static int take_tolerance(data *d, double tolerance);
static int take_time(data *d, double time);

EXPORT const char *FMI(GetVersion)(void) { return "3.0"; }

EXPORT fmi3Status FMI(SetDebugLogging)(fmi3Instance i, fmi3Boolean on, size_t n, const fmi3String categories[]) {
  UNUSED(n), UNUSED(categories);
  ((instance *)i)->logging = on;
  return fmi3OK;
}

static fmi3Instance made(
    fmi3String name, fmi3String token, fmi3Boolean logging, fmi3InstanceEnvironment environment,
    fmi3LogMessageCallback log, const char *own, int own_kind) {
  instance *c = calloc(1, sizeof *c);
  if (!c) return NULL;
  memcpy(&c->log, &log, sizeof log);
  c->environment = environment;
  c->logging = logging;
  snprintf(c->name, sizeof c->name, "%s", name ? name : "");
  if (!own_kind) {
    ERROR("this FMU is for %s only", own);
  } else if (!token || strcmp(token, TOKEN) != 0) {
    ERROR("the instantiation token is %s, that of this FMU is %s", token ? token : "missing", TOKEN);
  } else {
    to_start(&c->now);
    return c;
  }
  free(c);
  return NULL;
}

EXPORT void FMI(FreeInstance)(fmi3Instance i) { free(i); }

EXPORT fmi3Status FMI(EnterInitializationMode)(
    fmi3Instance i, fmi3Boolean tolerance_defined, fmi3Float64 tolerance, fmi3Float64 start, fmi3Boolean stop_defined,
    fmi3Float64 stop) {
  instance *c = i;
  UNUSED(stop_defined), UNUSED(stop);
  if (in_phase(c, INSTANTIATED, INSTANTIATED, "EnterInitializationMode")) return fmi3Error;
  if (!isfinite(start)) return ERROR("startTime should be a finite number");
  if (tolerance_defined && !take_tolerance(&c->now, tolerance)) return ERROR("tolerance should be " TOLERANCES ", got %g", tolerance);
  if (!take_time(&c->now, start / TIME_FACTOR)) return ERROR("startTime should be 0, got %g", start);
  c->now.phase = INITIALIZING;
  c->now.stale = 1;
  return fmi3OK;
}

EXPORT fmi3Status FMI(Terminate)(fmi3Instance i) {
  ((instance *)i)->now.phase = TERMINATED;
  return fmi3OK;
}

EXPORT fmi3Status FMI(Reset)(fmi3Instance i) {
  to_start(&((instance *)i)->now);
  return fmi3OK;
}

/* Values. */

EXPORT fmi3Status FMI(GetFloat64)(
    fmi3Instance i, const fmi3ValueReference references[], size_t n, fmi3Float64 values[], size_t count) {
  instance *c = i;
  size_t k;
  if (n != count) return ERROR("%zu value references for %zu values", n, count);
  refresh(c);
  for (k = 0; k < n; k++) {
    const variable *v = variable_of(references[k], REAL);
    if (!v) return ERROR("there is no Float64 variable with the value reference %u", (unsigned)references[k]);
    values[k] = c->now.values[v->place] * v->factor;
  }
  return fmi3OK;
}

EXPORT fmi3Status FMI(SetFloat64)(
    fmi3Instance i, const fmi3ValueReference references[], size_t n, const fmi3Float64 values[], size_t count) {
  instance *c = i;
  size_t k;
  if (n != count) return ERROR("%zu value references for %zu values", n, count);
  for (k = 0; k < n; k++) { /* all are checked before any is set */
    const variable *v = variable_of(references[k], REAL);
    const char *why;
    if (!v) return ERROR("there is no Float64 variable with the value reference %u", (unsigned)references[k]);
    if ((why = not_settable(c, v))) return ERROR("%s %s", v->name, why);
    if ((why = not_allowed(v, values[k]))) return ERROR("%s %s, got %g", v->name, why, values[k]);
  }
  for (k = 0; k < n; k++) {
    const variable *v = &variables[references[k]];
    c->now.values[v->place] = values[k] / v->factor;
    c->now.stale = 1;
    if (v->causality == INPUT) input_changed(&c->now);
  }
  return fmi3OK;
}

EXPORT fmi3Status FMI(GetInt64)(
    fmi3Instance i, const fmi3ValueReference references[], size_t n, fmi3Int64 values[], size_t count) {
  instance *c = i;
  size_t k;
  if (n != count) return ERROR("%zu value references for %zu values", n, count);
  refresh(c);
  for (k = 0; k < n; k++) {
    const variable *v = variable_of(references[k], WHOLE);
    if (!v) return ERROR("there is no Int64 or Enumeration variable with the value reference %u", (unsigned)references[k]);
    values[k] = c->now.counts[v->place];
  }
  return fmi3OK;
}

EXPORT fmi3Status FMI(GetString)(
    fmi3Instance i, const fmi3ValueReference references[], size_t n, fmi3String values[], size_t count) {
  instance *c = i;
  size_t k;
  if (n != count) return ERROR("%zu value references for %zu values", n, count);
  for (k = 0; k < n; k++) {
    if (!variable_of(references[k], TEXT))
      return ERROR("there is no String variable with the value reference %u", (unsigned)references[k]);
    values[k] = status_text(c->now.status);
  }
  return fmi3OK;
}

/* Of the other types there are no variables. */
#define NO_GET(Type)                                                                                                  \
  EXPORT fmi3Status FMI(Get##Type)(                                                                                   \
      fmi3Instance i, const fmi3ValueReference references[], size_t n, fmi3##Type values[], size_t count) {           \
    instance *c = i;                                                                                                  \
    UNUSED(references), UNUSED(values), UNUSED(count);                                                                \
    return n ? ERROR("there are no variables of the type " #Type) : fmi3OK;                                           \
  }
#define NO_SET(Type)                                                                                                  \
  EXPORT fmi3Status FMI(Set##Type)(                                                                                   \
      fmi3Instance i, const fmi3ValueReference references[], size_t n, const fmi3##Type values[], size_t count) {     \
    instance *c = i;                                                                                                  \
    UNUSED(references), UNUSED(values), UNUSED(count);                                                                \
    return n ? ERROR("there are no variables of the type " #Type " that can be set") : fmi3OK;                        \
  }
NO_GET(Float32) NO_GET(Int8) NO_GET(UInt8) NO_GET(Int16) NO_GET(UInt16) NO_GET(Int32) NO_GET(UInt32) NO_GET(UInt64)
NO_GET(Boolean)
NO_SET(Float32) NO_SET(Int8) NO_SET(UInt8) NO_SET(Int16) NO_SET(UInt16) NO_SET(Int32) NO_SET(UInt32) NO_SET(Int64)
NO_SET(UInt64) NO_SET(Boolean) NO_SET(String)

/* The state: a flat copy. */

EXPORT fmi3Status FMI(GetFMUState)(fmi3Instance i, fmi3FMUState *state) {
  instance *c = i;
  if (!*state && !(*state = malloc(sizeof(data)))) return ERROR("there is no memory for a copy of the state");
  memcpy(*state, &c->now, sizeof(data));
  return fmi3OK;
}

EXPORT fmi3Status FMI(SetFMUState)(fmi3Instance i, fmi3FMUState state) {
  instance *c = i;
  if (!state) return ERROR("there is no state to be set");
  memcpy(&c->now, state, sizeof(data));
  return fmi3OK;
}

EXPORT fmi3Status FMI(FreeFMUState)(fmi3Instance i, fmi3FMUState *state) {
  UNUSED(i);
  free(*state);
  *state = NULL;
  return fmi3OK;
}

EXPORT fmi3Status FMI(SerializedFMUStateSize)(fmi3Instance i, fmi3FMUState state, size_t *size) {
  UNUSED(i), UNUSED(state);
  *size = SERIALIZED;
  return fmi3OK;
}

EXPORT fmi3Status FMI(SerializeFMUState)(fmi3Instance i, fmi3FMUState state, fmi3Byte bytes[], size_t size) {
  instance *c = i;
  if (size != SERIALIZED) return ERROR("a serialized state has %zu bytes, got %zu", SERIALIZED, size);
  memcpy(bytes, TOKEN, sizeof TOKEN);
  memcpy(bytes + sizeof TOKEN, state, sizeof(data));
  return fmi3OK;
}

EXPORT fmi3Status FMI(DeserializeFMUState)(fmi3Instance i, const fmi3Byte bytes[], size_t size, fmi3FMUState *state) {
  instance *c = i;
  if (size != SERIALIZED) return ERROR("a serialized state has %zu bytes, got %zu", SERIALIZED, size);
  if (memcmp(bytes, TOKEN, sizeof TOKEN)) return ERROR("the serialized state is that of another FMU");
  if (!*state && !(*state = malloc(sizeof(data)))) return ERROR("there is no memory for a copy of the state");
  memcpy(*state, bytes + sizeof TOKEN, sizeof(data));
  return fmi3OK;
}

/* What this FMU does not offer. */
#define ABSENT(Name, ...)                                                                                             \
  EXPORT fmi3Status FMI(Name)(fmi3Instance i, __VA_ARGS__) {                                                          \
    instance *c = i;                                                                                                  \
    return ERROR("fmi3" #Name " is not offered by this FMU");                                                         \
  }
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

#define ABSENT_ALONE(Name)                                                                                            \
  EXPORT fmi3Status FMI(Name)(fmi3Instance i) {                                                                       \
    instance *c = i;                                                                                                  \
    return ERROR("fmi3" #Name " is not offered by this FMU");                                                         \
  }
ABSENT_ALONE(EnterConfigurationMode)
ABSENT_ALONE(ExitConfigurationMode)
ABSENT_ALONE(EvaluateDiscreteStates)

EXPORT fmi3Instance FMI(InstantiateScheduledExecution)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3ClockUpdateCallback update,
    fmi3PreemptionCallback lock, fmi3PreemptionCallback unlock) {
  return made(name, token, logging, environment, log, KIND_OF_FMU, 0);
}

EXPORT fmi3Instance FMI(InstantiateModelExchange)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log) {
  return made(name, token, logging, environment, log, KIND_OF_FMU, MODEL_EXCHANGE);
}

EXPORT fmi3Instance FMI(InstantiateCoSimulation)(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean event_mode, fmi3Boolean early_return, const fmi3ValueReference required[], size_t required_count,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback log, fmi3IntermediateUpdateCallback intermediate) {
  instance *c = made(name, token, logging, environment, log, KIND_OF_FMU, !MODEL_EXCHANGE);
  if (c) c->events_shown = event_mode, c->early = early_return;
  return c;
}

#include KIND_FILE
