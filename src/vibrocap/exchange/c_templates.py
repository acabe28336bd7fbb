"""The texts around a stepper in C, with @places@: header, interface, a program that prints a motion, and a README."""

HEADER = """/* A vibro-driven capsule with its exact stick-slip contact, moved on from outside.

   @drive_said@

   @units_said@

   Order of calls: @name@_case, then any of @name@_set_parameter, @name@_set_initial, @name@_set_tolerance, then
   @name@_begin, then @name@_step and @name@_look as often as wanted. */
#ifndef @NAME@_H
#define @NAME@_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define @NAME@_STATES @states@
#define @NAME@_OBSERVABLES @observables@
#define @NAME@_PARAMETERS @parameters@
#define @NAME@_CONTACTS @contacts@
#define @NAME@_INPUTS @inputs@ /* value, slope and curvature of the drive; 0: it is the case's own */
#define @NAME@_EVENT_KINDS @event_kinds@
#define @NAME@_CONTACT_EVENT_KINDS @contact_kinds@ /* the first so many are of a contact, the others of none */

/* What steps return. 3 and above: the motion has ended there, see @name@_status_text and @name@_time. */
#define @NAME@_RUNNING 0  /* it went on by all of the length */
#define @NAME@_AT_EVENT 1 /* it stands at an event before that; of @name@_step_to_event only */
#define @NAME@_REFUSED 2  /* nothing was done: a number is not finite or not positive, or the motion has not begun */
@status_defines@

/* One motion, @kilobytes@ kB. No pointers: copy it by assignment to save and restore it. */
typedef struct {
  double floats[@floats@];
  int64_t ints[@ints@];
  double trace[@trace@];
} @name@;

/* A quantity in its unit ("1" where the case is not in SI), of which one unit of the equations is `scale`. */
typedef struct {
  const char *name, *unit;
  double scale;
  double value;       /* that of the case: of parameters and initial states */
  double least, most; /* what a parameter may be, by itself; infinite where any finite number is allowed */
} @name@_quantity;

/* NULL where i is beyond the last. */
const @name@_quantity *@name@_time_info(void);
const @name@_quantity *@name@_input_info(int i);
const @name@_quantity *@name@_parameter_info(int i);
const @name@_quantity *@name@_state_info(int i);
const @name@_quantity *@name@_observable_info(int i);
const char *@name@_event_name(int kind);
const char *@name@_status_text(int status);

/* Parameters, initial states and tolerance of the case. */
void @name@_case(@name@ *c);
/* Before @name@_begin. 1: taken; 0: refused, as it is not finite or out of bounds, or as the motion has begun. */
int @name@_set_parameter(@name@ *c, int i, double value);
int @name@_set_initial(@name@ *c, int i, double value);
int @name@_set_tolerance(@name@ *c, double tolerance); /* 1e-14 to 1e-2; the order of the series stays */
/* The motion begins, at time 0. */
int @name@_begin(@name@ *c);
@input_declared@
/* Advance by h > 0. */
int @name@_step(@name@ *c, double h);
/* Advance by h > 0 at most, to the first event that changes anything. A graze does not, and is only counted. Where an
   input that was set now changes a side at once, that is an event now: the time has not gone on then. */
int @name@_step_to_event(@name@ *c, double h);

int @name@_status(const @name@ *c); /* @NAME@_RUNNING, or 3 and above */
double @name@_time(const @name@ *c);
double @name@_parameter(const @name@ *c, int i);
/* The states now, then the observables; they stand in c until the next call. The motion is not changed. */
const double *@name@_look(@name@ *c);
/* +1, -1: it slides; 0: it is at rest. contact: 1 for the first */
int @name@_side(const @name@ *c, int contact);
/* contact: 1 for the first; 0 for kinds that are of none */
int64_t @name@_event_count(const @name@ *c, int kind, int contact);
/* How many events there were; the last one, of which any pointer may be NULL. */
int64_t @name@_last_event(const @name@ *c, double *time, int *kind, int *contact);

/* A motion as bytes, for the same library on a machine of the same byte order. 1: taken; 0: not of this library. */
#define @NAME@_BYTES (sizeof(@name@) + 8)
void @name@_save(const @name@ *c, void *bytes);
int @name@_load(@name@ *c, const void *bytes, size_t size);

#ifdef __cplusplus
}
#endif

#endif
"""

INPUT_DECLARED = """
/* The input from now on: value + slope s + curvature s^2/2 at the time s from now. 1: taken; 0: one is not finite. */
int @name@_set_input(@name@ *c, double value, double slope, double curvature);
"""

INTERFACE = """static int @name@_finite(double x) { return x - x == 0.0; }

static const @name@_quantity *@name@_found(const @name@_quantity *all, int count, int i) {
  return i >= 0 && i < count ? all + i : NULL;
}

const @name@_quantity *@name@_time_info(void) {
  static const @name@_quantity all[] = {@time_infos@};
  return all;
}

const @name@_quantity *@name@_input_info(int i) {
  static const @name@_quantity all[] = {@input_infos@};
  return @name@_found(all, @NAME@_INPUTS, i);
}

const @name@_quantity *@name@_parameter_info(int i) {
  static const @name@_quantity all[] = {@parameter_infos@};
  return @name@_found(all, @NAME@_PARAMETERS, i);
}

const @name@_quantity *@name@_state_info(int i) {
  static const @name@_quantity all[] = {@state_infos@};
  return @name@_found(all, @NAME@_STATES, i);
}

const @name@_quantity *@name@_observable_info(int i) {
  static const @name@_quantity all[] = {@observable_infos@};
  return @name@_found(all, @NAME@_OBSERVABLES, i);
}

const char *@name@_event_name(int kind) {
  static const char *const names[] = {@event_names@};
  return kind >= 0 && kind < @NAME@_EVENT_KINDS ? names[kind] : "";
}

const char *@name@_status_text(int status) {
  switch (status) {
@statuses@
    default: return "unknown";
  }
}

static int @name@_place(int i) {
  static const int16_t places[] = {@parameter_places@};
  return @PARAMETER@ + places[i];
}

/* What the motion has ended with: some codes of the kernel say the same. */
static int @name@_ended(const @name@ *c) {
  switch (c->ints[@ENDED@]) {
@same_statuses@    default: return (int)c->ints[@ENDED@];
  }
}

void @name@_case(@name@ *c) {
  memset(c, 0, sizeof *c);
@set_floats@
@set_ints@
}

int @name@_set_parameter(@name@ *c, int i, double value) {
  const @name@_quantity *known = @name@_parameter_info(i);
  if (known == NULL || c->ints[@BEGUN@] || !@name@_finite(value)) return 0;
  if (value < known->least || value > known->most) return 0;
  c->floats[@name@_place(i)] = value / known->scale;
  return 1;
}

int @name@_set_initial(@name@ *c, int i, double value) {
  if (i < 0 || i >= @NAME@_STATES || c->ints[@BEGUN@] || !@name@_finite(value)) return 0;
  c->floats[@STATE@ + i] = value / @name@_state_info(i)->scale;
  return 1;
}

int @name@_set_tolerance(@name@ *c, double tolerance) {
  if (c->ints[@BEGUN@] || !(tolerance >= 1e-14 && tolerance <= 1e-2)) return 0;
  c->floats[@TOLERANCE@] = tolerance;
  return 1;
}

int @name@_begin(@name@ *c) {
  if (c->ints[@BEGUN@]) return @NAME@_REFUSED;
  @name@_kernel_begin_motion(c->floats, c->ints, c->trace, 0);
  return @NAME@_RUNNING;
}
@input_defined@
static int @name@_gone(@name@ *c, double h, int to_event) {
  if (!c->ints[@BEGUN@] || !@name@_finite(h) || !(h > 0.0)) return @NAME@_REFUSED;
  c->floats[@LENGTH@] = h / @name@_time_info()->scale;
  c->ints[@STOPPED@] = 0;
  @name@_kernel_take_step(c->floats, c->ints, c->trace, to_event);
  if (c->ints[@ENDED@] != @NAME@_RUNNING) return @name@_ended(c);
  return c->ints[@STOPPED@] ? @NAME@_AT_EVENT : @NAME@_RUNNING;
}

int @name@_step(@name@ *c, double h) { return @name@_gone(c, h, 0); }

int @name@_step_to_event(@name@ *c, double h) { return @name@_gone(c, h, 1); }

int @name@_status(const @name@ *c) { return @name@_ended(c); }

double @name@_time(const @name@ *c) { return c->floats[@CLOCK@] * @name@_time_info()->scale; }

double @name@_parameter(const @name@ *c, int i) {
  const @name@_quantity *known = @name@_parameter_info(i);
  return known == NULL ? 0.0 : c->floats[@name@_place(i)] * known->scale;
}

const double *@name@_look(@name@ *c) {
  double *seen = c->trace + @SHOWN@;
  int i;
  @name@_kernel_look_at(c->floats, c->ints, c->trace, 0);
  for (i = 0; i < @NAME@_STATES; i++) seen[i] *= @name@_state_info(i)->scale;
  for (i = 0; i < @NAME@_OBSERVABLES; i++) seen[@NAME@_STATES + i] *= @name@_observable_info(i)->scale;
  return seen;
}

int @name@_side(const @name@ *c, int contact) {
  return contact >= 1 && contact <= @NAME@_CONTACTS ? (int)c->floats[@SHOWN_SIDE@ + contact - 1] : 0;
}

int64_t @name@_event_count(const @name@ *c, int kind, int contact) {
  if (kind >= 0 && kind < @NAME@_CONTACT_EVENT_KINDS) {
    if (contact < 1 || contact > @NAME@_CONTACTS) return 0;
    return c->ints[@COUNTED@ + kind * @NAME@_CONTACTS + contact - 1];
  }
  if (kind < 0 || kind >= @NAME@_EVENT_KINDS || contact != 0) return 0;
  return c->ints[@COUNTED@ + @NAME@_CONTACT_EVENT_KINDS * (@NAME@_CONTACTS - 1) + kind];
}

int64_t @name@_last_event(const @name@ *c, double *time, int *kind, int *contact) {
  int64_t total = 0;
  int i;
  for (i = 0; i < @counts@; i++) total += c->ints[@COUNTED@ + i];
  if (time) *time = c->floats[@LAST_TIME@] * @name@_time_info()->scale;
  if (kind) *kind = (int)c->ints[@LAST_KIND@];
  if (contact) *contact = (int)c->ints[@LAST_CONTACT@];
  return total;
}

static const unsigned char @name@_identity[8] = {@identity@};

void @name@_save(const @name@ *c, void *bytes) {
  memcpy(bytes, @name@_identity, 8);
  memcpy((unsigned char *)bytes + 8, c, sizeof *c);
}

int @name@_load(@name@ *c, const void *bytes, size_t size) {
  if (size != @NAME@_BYTES || memcmp(bytes, @name@_identity, 8) != 0) return 0;
  memcpy(c, (const unsigned char *)bytes + 8, sizeof *c);
  return 1;
}
"""

INPUT_DEFINED = """
int @name@_set_input(@name@ *c, double value, double slope, double curvature) {
  if (!@name@_finite(value) || !@name@_finite(slope) || !@name@_finite(curvature)) return 0;
  c->floats[@INPUT@] = value / @name@_input_info(0)->scale;
  c->floats[@INPUT@ + 1] = slope / @name@_input_info(1)->scale;
  c->floats[@INPUT@ + 2] = curvature / @name@_input_info(2)->scale;
  c->ints[@NEW_INPUT@] = 1;
  return 1;
}
"""

MAIN_HEAD = """#include "@name@.h"

#include <stdio.h>

static void line(@name@ *c, const char *what, int contact) {
  const double *values = @name@_look(c);
  int i;
  printf("%.17g,%s,%d", @name@_time(c), what, contact);
  for (i = 1; i <= @NAME@_CONTACTS; i++) printf(",%d", @name@_side(c, i));
  for (i = 0; i < @NAME@_STATES + @NAME@_OBSERVABLES; i++) printf(",%.17g", values[i]);
  printf("\\n");
}

static void head(void) {
  int i;
  printf("time,what,contact");
  for (i = 1; i <= @NAME@_CONTACTS; i++) i == 1 ? printf(",side") : printf(",side_%d", i);
  for (i = 0; i < @NAME@_STATES; i++) printf(",%s", @name@_state_info(i)->name);
  for (i = 0; i < @NAME@_OBSERVABLES; i++) printf(",%s", @name@_observable_info(i)->name);
  printf("\\n");
}

/* Advance by h, with a line for every event. */
static int go_on(@name@ *c, double h) {
  double end = @name@_time(c) + h;
  int status = @NAME@_AT_EVENT;
  while (status == @NAME@_AT_EVENT && end > @name@_time(c)) {
    @name@ before = *c;
    int kind, contact;
    int64_t n;
    status = @name@_step_to_event(c, end - @name@_time(c));
    if (status != @NAME@_AT_EVENT) break;
    for (kind = 0; kind < @NAME@_EVENT_KINDS; kind++)
      for (contact = 0; contact <= @NAME@_CONTACTS; contact++) {
        n = @name@_event_count(c, kind, contact) - @name@_event_count(&before, kind, contact);
        for (; n > 0; n--) line(c, @name@_event_name(kind), contact);
      }
  }
  return status;
}
"""

MAIN = (
    """/* Prints the motion of the case as CSV: a line for its start, each event, @samples@ in each period, its end. */
"""
    + MAIN_HEAD
    + """
int main(void) {
  static @name@ motion;
  int i, status = @NAME@_AT_EVENT;
  @name@_case(&motion);
  @name@_begin(&motion);
  head();
  line(&motion, "start", 0);
  for (i = 1; i <= @lines@; i++) {
    status = go_on(&motion, @period@ * i / @samples@ - @name@_time(&motion));
    if (status > @NAME@_AT_EVENT) break;
    line(&motion, i < @lines@ ? "instant" : "finished", 0);
  }
  if (status > @NAME@_AT_EVENT) line(&motion, @name@_status_text(status), 0);
  return status > @NAME@_AT_EVENT ? 3 : 0;
}
"""
)

INPUT_MAIN = (
    """/* Reads lines "length value [slope [curvature]]" and prints the motion under that input as CSV: a line at its
   start, for every event, and where each length ends. */
"""
    + MAIN_HEAD
    + """
int main(void) {
  static @name@ motion;
  char text[256];
  int status = @NAME@_RUNNING;
  @name@_case(&motion);
  @name@_begin(&motion);
  head();
  line(&motion, "start", 0);
  while (status == @NAME@_RUNNING && fgets(text, sizeof text, stdin)) {
    double h = 0.0, value = 0.0, slope = 0.0, curvature = 0.0;
    if (sscanf(text, "%lf %lf %lf %lf", &h, &value, &slope, &curvature) < 2) continue;
    if (!@name@_set_input(&motion, value, slope, curvature)) status = @NAME@_REFUSED;
    if (status == @NAME@_RUNNING) status = go_on(&motion, h);
    line(&motion, status == @NAME@_RUNNING ? "step" : @name@_status_text(status), 0);
  }
  return status == @NAME@_RUNNING ? 0 : 3;
}
"""
)

README = """\
Build and run: cc -O2 -o @name@ main.c @name@.c -lm && ./@name@ @run@ (any C99 compiler, no -ffast-math).
@name@.h is the interface; @name@.c needs no other library, allocates nothing and has no global state.
@units_said@
Columns of main.c: time, what, number of the contact, sides, states, observables.
"""
