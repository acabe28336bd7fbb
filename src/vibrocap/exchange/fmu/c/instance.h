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

enum { INSTANTIATED, INITIALIZING, EVENTS, CONTINUOUS, STEPPING, TERMINATED };

/* Everything that a copy of the state holds. Values are dimensionless: those of variables are values times factors. */
typedef struct {
  double values[VALUES];
  int64_t counts[COUNTS];
  int phase, stale, status;
  own_state own;
} data;

#define SERIALIZED (sizeof TOKEN + sizeof(data))

typedef struct {
  data now;
  void *environment, *log;
  int logging, events_shown, early;
  char name[64];
} instance;

typedef void (*speaker)(void *environment, void *log, const char *name, int status, const char *text);

/* Tell the importer what is wrong; errors are told whether it asked for messages or not. */
static int say(instance *c, int status, speaker tell, const char *form, ...) {
  char text[400];
  va_list given;
  va_start(given, form);
  vsnprintf(text, sizeof text, form, given);
  va_end(given);
  if (c->log && (c->logging || status >= 3)) tell(c->environment, c->log, c->name, status, text);
  return status;
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

static const char *not_allowed(const variable *v, double value) {
  if (!(fabs(value) <= 1.7976931348623157e308)) return "should be a finite number";
  if (v->bound == ABOVE_ZERO && !(value > 0.0)) return "should be greater than 0";
  if (v->bound == FROM_ZERO && !(value >= 0.0)) return "should be at least 0";
  return NULL;
}

#endif
