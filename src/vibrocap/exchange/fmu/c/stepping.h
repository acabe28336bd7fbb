/* Co-simulation round the stepper: its parameters, its input and its steps, in every version of FMI. */
#ifndef STEPPING_H
#define STEPPING_H

#include "instance.h"

#define NEAR 1e-9 /* by so much of it a time of the importer may differ from ours */

static void to_start(data *d) {
  memset(d, 0, sizeof *d);
  start_values(d->values);
  d->own.tolerance = TOLERANCE;
  d->stale = 1;
}

static void input_changed(data *d) { d->own.input_changed = 1; }

static int take_tolerance(data *d, double tolerance) {
  d->own.tolerance = tolerance;
  return tolerance >= 1e-14 && tolerance <= 1e-2;
}

/* The clock of the importer may begin anywhere where the drive is an input. */
static int take_time(data *d, double time) {
  d->own.begun = time;
  return INPUTS ? isfinite(time) : time == 0.0;
}

/* Begin the motion with the parameters and start values as they are. */
static int begin(instance *c) {
  data *d = &c->now;
  int k;
  STEPPER(case)(&d->own.motion);
  for (k = 0; k < PARAMETERS; k++)
    if (!STEPPER(set_parameter)(&d->own.motion, k, d->values[PARAMETER + k]))
      return WRONG("%s is outside of what is allowed", variables[PARAMETER_VARIABLE + k].name);
  for (k = 0; k < STATES; k++) STEPPER(set_initial)(&d->own.motion, k, d->values[STATE + k]);
  STEPPER(set_tolerance)(&d->own.motion, d->own.tolerance);
#if INPUTS
  STEPPER(set_input)(&d->own.motion, d->values[HELD], d->values[HELD + 1], d->values[HELD + 2]);
#endif
  d->own.input_changed = 0;
  d->status = STEPPER(begin)(&d->own.motion);
  if (d->status) return WRONG("the motion cannot begin: %s", STEPPER(status_text)(d->status));
  return DONE;
}

/* An input that was set holds from now on. */
static void take_input(data *d) {
#if INPUTS
  if (d->own.input_changed) STEPPER(set_input)(&d->own.motion, d->values[HELD], d->values[HELD + 1], d->values[HELD + 2]);
#endif
  d->own.input_changed = 0;
}

static double time_now(const data *d) { return d->own.begun + STEPPER(time)(&d->own.motion); }

static void refresh(instance *c) {
  data *d = &c->now;
  const double *seen;
  int k, contact;
  if (!d->stale) return;
  if (d->phase <= INITIALIZING && begin(c)) return;
  d->stale = 0;
  take_input(d);
  seen = STEPPER(look)(&d->own.motion);
  if (d->phase > INITIALIZING) memcpy(d->values + STATE, seen, STATES * sizeof *seen);
  memcpy(d->values + OBSERVED, seen + STATES, OBSERVABLES * sizeof *seen);
  d->values[TIME] = time_now(d);
  for (k = 0; k < CONTACTS; k++) d->counts[k] = STEPPER(side)(&d->own.motion, k + 1);
  for (k = CONTACTS; k < COUNTS; k++) d->counts[k] = 0;
  for (k = 0; k < EVENT_KINDS; k++)
    for (contact = 0; contact <= CONTACTS; contact++)
      if (count_of[k][contact] >= 0)
        d->counts[CONTACTS + count_of[k][contact]] += STEPPER(event_count)(&d->own.motion, k, contact);
}

/* Advance from a time by a length, at most to the first event where that is asked; `event`: whether there was one. */
static int go_on(instance *c, double from, double length, int to_event, int *event) {
  data *d = &c->now;
  double now = time_now(d), until, rest;
  *event = 0;
  if (!isfinite(length) || !(length > 0.0))
    return WRONG("communicationStepSize should be a finite number greater than 0, got %g", length);
  if (!(fabs(from - now) <= NEAR * (fabs(now) + length)))
    return WRONG("currentCommunicationPoint should be %.17g, where the motion stands, got %.17g", now, from);
  until = from + length;
  rest = until - time_now(d);
  take_input(d);
  d->stale = 1;
  if (!(rest > 0.0)) return DONE; /* the length is lost in the rounding of the time */
  d->status = to_event ? STEPPER(step_to_event)(&d->own.motion, rest) : STEPPER(step)(&d->own.motion, rest);
  if (d->status == AT_EVENT) {
    d->status = 0;
    *event = 1;
  }
  if (d->status)
    return say(c, DISCARD, "the motion cannot continue at %.9g: %s", time_now(d), status_text(d->status));
  return DONE;
}

#endif
