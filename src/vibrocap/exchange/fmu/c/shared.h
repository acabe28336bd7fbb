/* What both versions of FMI have alike, in the types and names of each: OF(Status) is fmi2Status or fmi3Status. */
#ifndef SHARED_H
#define SHARED_H

#define STATUS(status) ((OF(Status))(status))

EXPORT const char *FMI(GetVersion)(void) { return VERSION; }

EXPORT OF(Status) FMI(SetDebugLogging)(void *i, OF(Boolean) on, size_t n, const OF(String) categories[]) {
  UNUSED(i), UNUSED(on), UNUSED(n), UNUSED(categories);
  return OF(OK);
}

EXPORT void FMI(FreeInstance)(void *i) { free(i); }

/* What the importer says of tolerance and time before the motion begins. */
static int set_up(instance *c, int tolerance_defined, double tolerance, double start) {
  if (tolerance_defined && !take_tolerance(&c->now, tolerance))
    return WRONG("tolerance should be " TOLERANCES ", got %g", tolerance);
  if (!take_time(&c->now, start)) return WRONG("startTime should be " STARTS ", got %g", start);
  return DONE;
}

static int enter(instance *c, int phase) {
  c->now.phase = phase;
  c->now.stale = 1;
  return DONE;
}

EXPORT OF(Status) FMI(Terminate)(void *i) {
  ((instance *)i)->now.phase = TERMINATED;
  return OF(OK);
}

EXPORT OF(Status) FMI(Reset)(void *i) {
  to_start(&((instance *)i)->now);
  return OF(OK);
}

/* The state. */

EXPORT OF(Status) FMU_STATE(Get, )(void *i, void **state) { return STATUS(copy_state(i, state)); }

EXPORT OF(Status) FMU_STATE(Set, )(void *i, void *state) { return STATUS(restore_state(i, state)); }

EXPORT OF(Status) FMU_STATE(Free, )(void *i, void **state) {
  UNUSED(i);
  free(*state);
  *state = NULL;
  return OF(OK);
}

EXPORT OF(Status) FMU_STATE(Serialized, Size)(void *i, void *state, size_t *size) {
  UNUSED(i), UNUSED(state);
  *size = SERIALIZED;
  return OF(OK);
}

EXPORT OF(Status) FMU_STATE(Serialize, )(void *i, void *state, OF(Byte) bytes[], size_t size) {
  return STATUS(serialize(i, state, bytes, size));
}

EXPORT OF(Status) DESERIALIZE(void *i, const OF(Byte) bytes[], size_t size, void **state) {
  return STATUS(deserialize(i, bytes, size, state));
}

#define ABSENT(Name, ...) \
  EXPORT OF(Status) FMI(Name)(void *c, __VA_ARGS__) { return STATUS(WRONG(PREFIX #Name " is not offered by this FMU")); }

#endif
