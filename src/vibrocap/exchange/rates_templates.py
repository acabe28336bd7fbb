"""The texts around rates, guards and decisions in C, with @places@: header, interface, an integrator, and a README."""

HEADER = """/* A vibro-driven capsule as rates, guards and decisions, for an integrator of your own: the error is that
   of the integrator, which also locates where a guard falls to zero.

   @drive_said@

   All numbers are dimensionless. @units_said@

   Order of calls: @name@_case, then any of @name@_set_parameter and states, then @name@_begin. From then on states and
   time are the integrator's: after it has set them, @name@_evaluate says rates and guards. Where a guard is zero or
   below, where the time reaches @name@_corner and after an input that jumps, @name@_event says how the motion goes
   on. */
#ifndef @NAME@_H
#define @NAME@_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define @NAME@_STATES @states@
#define @NAME@_GUARDS @guards@
#define @NAME@_OBSERVABLES @observables@
#define @NAME@_PARAMETERS @parameters@
#define @NAME@_INPUTS @inputs@
#define @NAME@_EVENT_KINDS @event_kinds@

/* What @name@_event returns. 3 and above: the motion has ended there. */
#define @NAME@_RUNNING 0
@status_defines@

/* One motion, @bytes@ bytes. No pointers: copy it by assignment to save and restore it. */
typedef struct {
  double values[@values@];
  double corner;
  int64_t counts[@counts@];
} @name@;

@quantities@

/* Parameters and initial states of the case. */
void @name@_case(@name@ *c);
/* Before @name@_begin. 1: taken; 0: refused, as it is not finite or out of bounds. */
int @name@_set_parameter(@name@ *c, int i, double value);
double @name@_parameter(const @name@ *c, int i);
/* The states, to be read and written. */
double *@name@_states(@name@ *c);
/* The motion begins at the time 0 with the states as they are. */
void @name@_begin(@name@ *c);
@input_declared@
void @name@_set_time(@name@ *c, double time);
/* Rates, guards and observables at the present time and states; they stand in c until the next call. */
void @name@_evaluate(@name@ *c);
const double *@name@_rates(const @name@ *c);
const double *@name@_guards(const @name@ *c); /* positive between events */
const double *@name@_observables(const @name@ *c);
/* Infinite for a drive without corners. */
double @name@_corner(const @name@ *c);
/* An event: the states may change. @NAME@_RUNNING, or the status with which the motion ends. */
int @name@_event(@name@ *c);
/* +1, -1: the contact slides; 0: it is at rest. */
int @name@_side(const @name@ *c);
int64_t @name@_event_count(const @name@ *c, int kind);

#ifdef __cplusplus
}
#endif

#endif
"""

INPUT_DECLARED = """/* The input from now on. 1: taken; 0: it is not finite. After a jump call @name@_event. */
int @name@_set_input(@name@ *c, double value);
"""

INTERFACE = """
@constants@
@declarations@

@rates@
@tables@
void @name@_case(@name@ *c) {
  memset(c, 0, sizeof *c);
@set_values@
}

int @name@_set_parameter(@name@ *c, int i, double value) {
  const @name@_quantity *known = @name@_parameter_info(i);
  if (known == NULL || !@name@_finite(value) || value < known->least || value > known->most) return 0;
  c->values[@name@_place(i)] = value;
  return 1;
}

double @name@_parameter(const @name@ *c, int i) {
  return i >= 0 && i < @NAME@_PARAMETERS ? c->values[@name@_place(i)] : 0.0;
}

double *@name@_states(@name@ *c) { return c->values + STATE; }

void @name@_begin(@name@ *c) {
  c->values[TIME] = 0.0;
  begin_rates(c->values);
  c->corner = SEGMENTS ? take_segment(c->values) : @infinity@;
  evaluate(c->values, c->counts);
}
@input_defined@
void @name@_set_time(@name@ *c, double time) { c->values[TIME] = time; }

void @name@_evaluate(@name@ *c) { evaluate(c->values, c->counts); }

const double *@name@_rates(const @name@ *c) { return c->values + RATE; }

const double *@name@_guards(const @name@ *c) { return c->values + INDICATOR; }

const double *@name@_observables(const @name@ *c) { return c->values + OBSERVED; }

double @name@_corner(const @name@ *c) { return c->corner; }

int @name@_event(@name@ *c) {
  int i, bound;
  if (SEGMENTS) c->corner = take_segment(c->values);
  for (i = 0; i < MOST_SWITCHES; i++) {
    int found = event(c->values, c->counts, &bound);
    if (found == ENDS) return bound_status[bound];
    if (found == BRANCHED) continue;
    evaluate(c->values, c->counts);
    return @NAME@_RUNNING;
  }
  return @NAME@_TOO_MANY_EVENTS;
}

int @name@_side(const @name@ *c) { return (int)c->values[SIDE]; }

int64_t @name@_event_count(const @name@ *c, int kind) {
  return kind >= 0 && kind < @NAME@_EVENT_KINDS ? c->counts[1 + kind] : 0;
}
"""

INPUT_DEFINED = """
int @name@_set_input(@name@ *c, double value) {
  if (!@name@_finite(value)) return 0;
  c->values[HELD] = value;
  return 1;
}
"""

MAIN = """\
/* An integrator for @name@.h: Runge-Kutta steps of a fixed length, events located by halving. Prints the motion
   @of@ as CSV: a line at its start, for every event, and @samples@ in each period. */
#include "@name@.h"

#include <stdio.h>
#include <string.h>

#define STEPS 16 /* between two lines */
#define MOST_EVENTS 1000 /* in one step, as of a body that comes to rest on a stop by ever smaller impacts */

static @name@ motion;

static void line(double time, const char *what) {
  int i;
  printf("%.17g,%s,%d", time, what, @name@_side(&motion));
  for (i = 0; i < @NAME@_STATES; i++) printf(",%.17g", @name@_states(&motion)[i]);
  for (i = 0; i < @NAME@_OBSERVABLES; i++) printf(",%.17g", @name@_observables(&motion)[i]);
  printf("\\n");
}

static void set(double time, const double *from, double h, const double *rates) {
  int i;
  for (i = 0; i < @NAME@_STATES; i++) @name@_states(&motion)[i] = from[i] + (rates ? h * rates[i] : 0.0);
  @name@_set_time(&motion, time);
  @name@_evaluate(&motion);
}

/* One step; whether a guard has fallen to zero in it. */
static int step(double time, const double *from, double h) {
  static const double at[] = {0.0, 0.5, 0.5, 1.0}, weight[] = {1.0, 2.0, 2.0, 1.0};
  double rates[@NAME@_STATES], sum[@NAME@_STATES];
  int i, k;
  memset(sum, 0, sizeof sum);
  for (k = 0; k < 4; k++) {
    set(time + at[k] * h, from, at[k] * h, k ? rates : NULL);
    memcpy(rates, @name@_rates(&motion), sizeof rates);
    for (i = 0; i < @NAME@_STATES; i++) sum[i] += weight[k] * rates[i] / 6.0;
  }
  set(time + h, from, h, sum);
  for (i = 0; i < @NAME@_GUARDS; i++)
    if (!(@name@_guards(&motion)[i] > 0.0)) return 1;
  return 0;
}

/* An event, with a line for all that it is; the status. */
static int decide(double time) {
  @name@ before = motion;
  int kind, status = @name@_event(&motion);
  for (kind = 0; !status && kind < @NAME@_EVENT_KINDS; kind++)
    if (@name@_event_count(&motion, kind) > @name@_event_count(&before, kind)) line(time, @name@_event_name(kind));
  return status;
}

/* Advance to a time; the status. */
static int go_on(double *time, double end) {
  double from[@NAME@_STATES];
  int events = 0;
  while (*time < end) {
    double corner = @name@_corner(&motion), until = corner < end ? corner : end, h = until - *time;
    int at_corner = corner <= end, fallen, status;
    memcpy(from, @name@_states(&motion), sizeof from);
    fallen = step(*time, from, h);
    if (fallen) {
      double low = 0.0, high = h;
      int halvings;
      for (halvings = 0; halvings < 60; halvings++) {
        double middle = 0.5 * (low + high);
        if (step(*time, from, middle)) high = middle;
        else low = middle;
      }
      step(*time, from, high);
      until = *time + high;
      at_corner = at_corner && high == h;
    }
    *time = until;
    if (!fallen && !at_corner) continue;
    if ((status = decide(*time))) return status;
    if (++events > MOST_EVENTS) return @NAME@_TOO_MANY_EVENTS;
  }
  return @NAME@_RUNNING;
}

int main(void) {
  double time = 0.0;
  int i, status = @NAME@_RUNNING;
  @name@_case(&motion);
@input_first@  @name@_begin(&motion);
  printf("time,what,side");
  for (i = 0; i < @NAME@_STATES; i++) printf(",%s", @name@_state_info(i)->name);
  for (i = 0; i < @NAME@_OBSERVABLES; i++) printf(",%s", @name@_observable_info(i)->name);
  printf("\\n");
  line(time, "start");
  for (i = 1; i <= @lines@ * STEPS; i++) {
@input_set@    if ((status = go_on(&time, @period@ / @samples@ / STEPS * i))) break;
    if (i % STEPS == 0) line(time, i < @lines@ * STEPS ? "instant" : "finished");
  }
  if (status) line(time, @name@_status_text(status));
  return status ? 3 : 0;
}
"""

OF_CASE = "of the case"
OF_INPUT = "under a square wave as its input"

INPUT_FIRST = """  @name@_set_input(&motion, @size@);
"""

INPUT_SET = """    if (i > 1 && i % (@samples@ / 2 * STEPS) == 1) {
      @name@_set_input(&motion, i / (@samples@ / 2 * STEPS) % 2 ? -@size@ : @size@);
      if ((status = decide(time))) break;
    }
"""

README = """\
Build and run: cc -O2 -o @name@ main.c @name@.c -lm && ./@name@ > motion.csv (any C99 compiler, no -ffast-math).
@name@.h is the interface; @name@.c needs no other library, allocates nothing and has no global state. It does not
integrate: main.c does, with steps of a fixed length, and locates the events. The error is that of the integrator.
All values are dimensionless; columns of main.c: time, what, side, states, observables.
"""
