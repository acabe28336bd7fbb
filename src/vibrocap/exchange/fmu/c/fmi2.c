/* FMI 2.0, co-simulation. */
#include "fmi2.h"
#include "stepping.h"

typedef void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);

static void tell(instance *c, int status, const char *text) {
  const char *category = status == ERROR ? "logStatusError" : "logStatusWarning";
  ((logger)c->log)(c->environment, c->name, (fmi2Status)status, category, "%s", text);
}

#define VERSION "2.0"
#define PREFIX "fmi2"
#define OF(name) fmi2##name
#define FMU_STATE(before, behind) FMI(before##FMUstate##behind)
#define DESERIALIZE FMI(DeSerializeFMUstate)
#include "shared.h"

EXPORT const char *FMI(GetTypesPlatform)(void) { return "default"; }

EXPORT fmi2Component FMI(Instantiate)(
    fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources, const fmi2CallbackFunctions *functions,
    fmi2Boolean visible, fmi2Boolean logging) {
  UNUSED(resources), UNUSED(visible), UNUSED(logging);
  return made(name, guid, functions ? functions->componentEnvironment : NULL,
              functions ? (void (*)(void))functions->logger : NULL, type == fmi2CoSimulation);
}

EXPORT fmi2Status FMI(SetupExperiment)(
    fmi2Component i, fmi2Boolean tolerance_defined, fmi2Real tolerance, fmi2Real start, fmi2Boolean stop_defined,
    fmi2Real stop) {
  instance *c = i;
  UNUSED(stop_defined), UNUSED(stop);
  if (in_phase(c, INSTANTIATED, "fmi2SetupExperiment")) return fmi2Error;
  return STATUS(set_up(c, tolerance_defined, tolerance, start));
}

EXPORT fmi2Status FMI(EnterInitializationMode)(fmi2Component i) {
  instance *c = i;
  if (in_phase(c, INSTANTIATED, "fmi2EnterInitializationMode")) return fmi2Error;
  return STATUS(enter(c, INITIALIZING));
}

EXPORT fmi2Status FMI(ExitInitializationMode)(fmi2Component i) {
  instance *c = i;
  if (in_phase(c, INITIALIZING, "fmi2ExitInitializationMode") || begin(c)) return fmi2Error;
  return STATUS(enter(c, STEPPING));
}

/* Values. */

EXPORT fmi2Status FMI(GetReal)(fmi2Component i, const fmi2ValueReference references[], size_t n, fmi2Real values[]) {
  return STATUS(get_real(i, references, n, values));
}

EXPORT fmi2Status FMI(SetReal)(
    fmi2Component i, const fmi2ValueReference references[], size_t n, const fmi2Real values[]) {
  return STATUS(set_real(i, references, n, values));
}

EXPORT fmi2Status FMI(GetInteger)(
    fmi2Component i, const fmi2ValueReference references[], size_t n, fmi2Integer values[]) {
  int64_t value;
  size_t k;
  for (k = 0; k < n; k++) {
    if (get_whole(i, references[k], &value)) return fmi2Error;
    values[k] = value > INT32_MAX ? INT32_MAX : (fmi2Integer)value;
  }
  return fmi2OK;
}

EXPORT fmi2Status FMI(GetString)(
    fmi2Component i, const fmi2ValueReference references[], size_t n, fmi2String values[]) {
  size_t k;
  for (k = 0; k < n; k++)
    if (get_text(i, references[k], &values[k])) return fmi2Error;
  return fmi2OK;
}

/* Of the other types there are no variables. */
#define NONE_OF(Name, Type)                                                                                           \
  EXPORT fmi2Status FMI(Name)(fmi2Component i, const fmi2ValueReference references[], size_t n, Type values[]) {      \
    instance *c = i;                                                                                                  \
    UNUSED(references), UNUSED(values);                                                                               \
    return n ? STATUS(WRONG("fmi2" #Name ": there are no such variables")) : fmi2OK;                                  \
  }
NONE_OF(GetBoolean, fmi2Boolean)
NONE_OF(SetBoolean, const fmi2Boolean)
NONE_OF(SetInteger, const fmi2Integer)
NONE_OF(SetString, const fmi2String)

/* Steps. */

EXPORT fmi2Status FMI(DoStep)(fmi2Component i, fmi2Real time, fmi2Real length, fmi2Boolean no_state_before) {
  instance *c = i;
  int event;
  UNUSED(no_state_before);
  if (in_phase(c, STEPPING, "fmi2DoStep")) return fmi2Error;
  return STATUS(go_on(c, time, length, 0, &event));
}

EXPORT fmi2Status FMI(CancelStep)(fmi2Component i) {
  instance *c = i;
  return STATUS(WRONG("fmi2CancelStep: a step ends before fmi2DoStep returns"));
}

EXPORT fmi2Status FMI(GetRealStatus)(fmi2Component i, const fmi2StatusKind kind, fmi2Real *value) {
  instance *c = i;
  if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
  *value = time_now(&c->now);
  return fmi2OK;
}

EXPORT fmi2Status FMI(GetBooleanStatus)(fmi2Component i, const fmi2StatusKind kind, fmi2Boolean *value) {
  instance *c = i;
  if (kind != fmi2Terminated) return fmi2Discard;
  *value = c->now.status != 0;
  return fmi2OK;
}

#define NO_STATUS(Name, Type)                                                                                         \
  EXPORT fmi2Status FMI(Name)(fmi2Component i, const fmi2StatusKind kind, Type * value) {                             \
    UNUSED(i), UNUSED(kind), UNUSED(value);                                                                           \
    return fmi2Discard;                                                                                               \
  }
NO_STATUS(GetStatus, fmi2Status)
NO_STATUS(GetIntegerStatus, fmi2Integer)
NO_STATUS(GetStringStatus, fmi2String)

/* What this FMU does not offer. */
#if defined(__GNUC__)
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif
ABSENT(SetRealInputDerivatives, const fmi2ValueReference *r, size_t n, const fmi2Integer *orders, const fmi2Real *values)
ABSENT(GetRealOutputDerivatives, const fmi2ValueReference *r, size_t n, const fmi2Integer *orders, fmi2Real *values)
ABSENT(GetDirectionalDerivative, const fmi2ValueReference *r, size_t n, const fmi2ValueReference *knowns, size_t count,
       const fmi2Real *seeds, fmi2Real *found)
