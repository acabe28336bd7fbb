/* An instance of the FMU: its values, what its variables are, and how it speaks. */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "variables.h"

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#elif defined(__GNUC__)
#define EXPORT __attribute__((visibility("default")))
#else
#define EXPORT
#endif

enum { INSTANTIATED, INITIALIZING, EVENTS, STEPPING, TERMINATED };

/* Everything that a copy of the state holds. */
typedef struct {
  double values[VALUES];
  int64_t counts[COUNTS];
  int phase, stale, status;
  own_state own;
} data;

#define SERIALIZED (sizeof TOKEN + sizeof(data))

typedef struct {
  data now;
  void *environment;
  void (*log)(void); /* of the importer, whose type differs between the versions of FMI */
  int event_mode, early_return;
  char name[64];
} instance;

/* The numbers of fmi2Status and fmi3Status. */
enum { DONE, WARNING, DISCARD, ERROR, FATAL };

/* What each version of FMI does in its own way, and what steps the motion. */
static void tell(instance *c, int status, const char *text);
static void to_start(data *d);
static void refresh(instance *c);
static void input_changed(data *d);

/* Tell the importer what is wrong or how a motion ended, whether it asked for messages or not: there are no others. */
static int say(instance *c, int status, const char *form, ...) {
  char text[400];
  va_list given;
  va_start(given, form);
  vsnprintf(text, sizeof text, form, given);
  va_end(given);
  if (c->log) tell(c, status, text);
  return status;
}

#define WRONG(...) say(c, ERROR, __VA_ARGS__)
#define UNUSED(x) ((void)(x))

static int in_phase(instance *c, int phase, const char *function) {
  static const char *const names[] = {"before initialization", "initialization mode", "event mode", "step mode",
                                      "after the end"};
  if (c->now.phase == phase) return DONE;
  return WRONG("%s cannot be called now (%s)", function, names[c->now.phase]);
}

static const variable *variable_of(uint64_t reference, int type) {
  return reference < VARIABLES && variables[reference].type == type ? &variables[reference] : NULL;
}

/* Whether a variable may be set now; NULL, or why not. */
static const char *not_settable(const instance *c, const variable *v) {
  switch (v->causality) {
    case PARAMETER_OF_CASE:
    case START:
      return c->now.phase <= INITIALIZING ? NULL : "can be set before the end of initialization only";
    case INPUT: return c->now.phase == TERMINATED ? "cannot be set after the end" : NULL;
    default: return "is no input, parameter or start value and cannot be set";
  }
}

/* Whether a variable may have a value, in its unit; if not, the importer is told. */
static int check_value(instance *c, const variable *v, double value) {
  if (!isfinite(value)) return WRONG("%s should be a finite number, got %g", v->name, value);
  if (value < v->least && v->least < 1e-300 && v->least > 0.0)
    return WRONG("%s should be greater than 0, got %g", v->name, value);
  if (value < v->least) return WRONG("%s should be at least %.17g, got %.17g", v->name, v->least, value);
  if (value > v->most) return WRONG("%s should be at most %.17g, got %.17g", v->name, v->most, value);
  return DONE;
}

/* A new instance; NULL where this FMU is of another kind, or the token that of another. */
static instance *made(
    const char *name, const char *token, void *environment, void (*log)(void), int right_kind) {
  instance *c = calloc(1, sizeof *c);
  if (!c) return NULL;
  c->log = log;
  c->environment = environment;
  snprintf(c->name, sizeof c->name, "%s", name ? name : "");
  if (!right_kind) {
    WRONG("this FMU is for co-simulation only");
  } else if (!token || strcmp(token, TOKEN) != 0) {
    WRONG("the token is %s, that of this FMU is %s", token ? token : "missing", TOKEN);
  } else {
    to_start(&c->now);
    return c;
  }
  free(c);
  return NULL;
}

static int get_real(instance *c, const uint32_t references[], size_t n, double values[]) {
  size_t k;
  refresh(c);
  for (k = 0; k < n; k++) {
    const variable *v = variable_of(references[k], REAL);
    if (!v) return WRONG("there is no real variable with the value reference %u", (unsigned)references[k]);
    values[k] = c->now.values[v->place];
  }
  return DONE;
}

static int set_real(instance *c, const uint32_t references[], size_t n, const double values[]) {
  size_t k;
  for (k = 0; k < n; k++) { /* all are checked before any is set */
    const variable *v = variable_of(references[k], REAL);
    const char *why;
    if (!v) return WRONG("there is no real variable with the value reference %u", (unsigned)references[k]);
    if ((why = not_settable(c, v))) return WRONG("%s %s", v->name, why);
    if (check_value(c, v, values[k])) return ERROR;
  }
  for (k = 0; k < n; k++) {
    const variable *v = &variables[references[k]];
    c->now.values[v->place] = values[k];
    c->now.stale = 1;
    if (v->causality == INPUT) input_changed(&c->now);
  }
  return DONE;
}

static int get_whole(instance *c, uint32_t reference, int64_t *value) {
  const variable *v = variable_of(reference, WHOLE);
  refresh(c);
  if (!v) return WRONG("there is no whole variable with the value reference %u", (unsigned)reference);
  *value = c->now.counts[v->place];
  return DONE;
}

static int get_text(instance *c, uint32_t reference, const char **value) {
  refresh(c);
  if (!variable_of(reference, TEXT))
    return WRONG("there is no text variable with the value reference %u", (unsigned)reference);
  *value = status_text(c->now.status);
  return DONE;
}

/* The state is one flat copy. */

static int copy_state(instance *c, void **state) {
  if (!*state && !(*state = malloc(sizeof(data)))) return WRONG("there is no memory for a copy of the state");
  memcpy(*state, &c->now, sizeof(data));
  return DONE;
}

static int restore_state(instance *c, const void *state) {
  if (!state) return WRONG("there is no state to be set");
  memcpy(&c->now, state, sizeof(data));
  return DONE;
}

static int serialize(instance *c, const void *state, void *bytes, size_t size) {
  if (!state || size < SERIALIZED) return WRONG("a serialized state has %zu bytes, got room for %zu", SERIALIZED, size);
  memcpy(bytes, TOKEN, sizeof TOKEN);
  memcpy((char *)bytes + sizeof TOKEN, state, sizeof(data));
  return DONE;
}

static int deserialize(instance *c, const void *bytes, size_t size, void **state) {
  if (size < SERIALIZED) return WRONG("a serialized state has %zu bytes, got %zu", SERIALIZED, size);
  if (memcmp(bytes, TOKEN, sizeof TOKEN)) return WRONG("the serialized state is that of another FMU");
  if (!*state && !(*state = malloc(sizeof(data)))) return WRONG("there is no memory for a copy of the state");
  memcpy(*state, (const char *)bytes + sizeof TOKEN, sizeof(data));
  return DONE;
}

#endif
