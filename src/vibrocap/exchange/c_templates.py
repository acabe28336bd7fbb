"""The texts around a kernel in C, with @places@: header, interface, a program that prints a motion, and a README."""

HEADER = """/* A vibro-driven capsule with its exact stick-slip contact. Times and states are dimensionless. */
#ifndef @NAME@_H
#define @NAME@_H

#include <stdint.h>

#define @NAME@_STATES @rows@
#define @NAME@_RUNNING 0
#define @NAME@_DONE 1
#define @NAME@_TRACE_FULL 2 /* read the pieces and events, then call @name@_clear */

/* One motion, about @kilobytes@ kB. No pointers: copy it by assignment to save and restore it. */
typedef struct {
  double floats[@floats@];
  int64_t ints[@ints@];
  double trace[@trace@];
} @name@;

/* The case at its start. */
void @name@_begin(@name@ *c);
/* Take at most so many steps; returns a status, see @name@_status_text. */
int @name@_run(@name@ *c, int64_t steps);
/* Forget the recorded pieces and events, and go on where the trace was full. */
void @name@_clear(@name@ *c);
const char *@name@_status_text(int status);

double @name@_time(const @name@ *c);           /* now */
const double *@name@_states(const @name@ *c);  /* now, [@NAME@_STATES] */
const char *@name@_state_name(int i);

/* Steps recorded since the last clear: time at the start, length, side of the first contact
   (+1, -1 sliding; 0 stuck). */
int64_t @name@_pieces(const @name@ *c);
double @name@_piece_time(const @name@ *c, int64_t i);
double @name@_piece_length(const @name@ *c, int64_t i);
int @name@_piece_side(const @name@ *c, int64_t i);
/* State j at a time s after the start of a piece, from its Taylor series. */
double @name@_piece_state(const @name@ *c, int64_t i, int j, double s);

/* Events recorded since the last clear; contact: 1 for the first, 0 for none. */
int64_t @name@_events(const @name@ *c);
double @name@_event_time(const @name@ *c, int64_t i);
const char *@name@_event_kind(const @name@ *c, int64_t i);
int @name@_event_contact(const @name@ *c, int64_t i);
const double *@name@_event_states(const @name@ *c, int64_t i);

#endif
"""

INTERFACE = """void @name@_begin(@name@ *c) {
  memset(c, 0, sizeof *c);
@set_floats@
@set_ints@
@set_trace@
}

int @name@_run(@name@ *c, int64_t steps) {
  if (c->ints[@STATUS@] == @NAME@_RUNNING && steps > 0) @name@_advance(c->floats, c->ints, c->trace, steps);
  return (int)c->ints[@STATUS@];
}

void @name@_clear(@name@ *c) {
  c->ints[@PIECES@] = c->ints[@RECORDED_EVENTS@] = 0;
  if (c->ints[@STATUS@] == @NAME@_TRACE_FULL) c->ints[@STATUS@] = @NAME@_RUNNING;
}

const char *@name@_status_text(int status) {
  switch (status) {
@statuses@
    default: return "unknown";
  }
}

double @name@_time(const @name@ *c) {
  return (double)c->ints[@PERIOD_COUNT@] * c->floats[@PERIOD@] + c->floats[@TIME@];
}

const double *@name@_states(const @name@ *c) { return c->floats + @STATE@; }

const char *@name@_state_name(int i) {
  static const char *const names[] = {@states@};
  return i >= 0 && i < @rows@ ? names[i] : "";
}

int64_t @name@_pieces(const @name@ *c) { return c->ints[@PIECES@]; }

static const double *@name@_piece(const @name@ *c, int64_t i) {
  return c->trace + c->ints[@PIECE_START@] + i * @PIECE_SIZE@;
}

double @name@_piece_time(const @name@ *c, int64_t i) {
  const double *p = @name@_piece(c, i);
  return p[0] * c->floats[@PERIOD@] + p[1];
}

double @name@_piece_length(const @name@ *c, int64_t i) { return @name@_piece(c, i)[2]; }

int @name@_piece_side(const @name@ *c, int64_t i) { return (int)@name@_piece(c, i)[3]; }

double @name@_piece_state(const @name@ *c, int64_t i, int j, double s) {
  const double *series = @name@_piece(c, i) + @PIECE_HEAD@ + j * (@ORDER@ + 1);
  double value = series[@ORDER@];
  int k;
  for (k = @ORDER@ - 1; k >= 0; k--) value = value * s + series[k];
  return value;
}

int64_t @name@_events(const @name@ *c) { return c->ints[@RECORDED_EVENTS@]; }

static const double *@name@_event(const @name@ *c, int64_t i) {
  return c->trace + c->ints[@RECORDED_EVENT_START@] + i * @EVENT_SIZE@;
}

double @name@_event_time(const @name@ *c, int64_t i) {
  const double *e = @name@_event(c, i);
  return e[0] * c->floats[@PERIOD@] + e[1];
}

const char *@name@_event_kind(const @name@ *c, int64_t i) {
  static const char *const kinds[] = {@kinds@};
  int kind = (int)@name@_event(c, i)[2];
  return kind >= 0 && kind < @kind_count@ ? kinds[kind] : "";
}

int @name@_event_contact(const @name@ *c, int64_t i) { return (int)@name@_event(c, i)[@EVENT_HEAD@ + @rows@]; }

const double *@name@_event_states(const @name@ *c, int64_t i) { return @name@_event(c, i) + @EVENT_HEAD@; }
"""

MAIN = """/* Prints the motion of the case as CSV: a line per step, per event, and one for its end. */
#include "@name@.h"

#include <stdio.h>

static void line(double time, const char *what, int which) { printf("%.17g,%s,%d", time, what, which); }

static void states(const double *values) {
  int j;
  for (j = 0; j < @NAME@_STATES; j++) printf(",%.17g", values[j]);
  printf("\\n");
}

static void recorded(const @name@ *c) {
  int64_t i, e = 0;
  int j;
  for (i = 0; i <= @name@_pieces(c); i++) {
    for (; e < @name@_events(c); e++) {
      if (i < @name@_pieces(c) && @name@_event_time(c, e) > @name@_piece_time(c, i)) break;
      line(@name@_event_time(c, e), @name@_event_kind(c, e), @name@_event_contact(c, e));
      states(@name@_event_states(c, e));
    }
    if (i < @name@_pieces(c)) {
      line(@name@_piece_time(c, i), "step", @name@_piece_side(c, i));
      for (j = 0; j < @NAME@_STATES; j++) printf(",%.17g", @name@_piece_state(c, i, j, 0.0));
      printf("\\n");
    }
  }
}

int main(void) {
  @name@ motion;
  int j, status;
  @name@_begin(&motion);
  printf("time,what,side_or_contact");
  for (j = 0; j < @NAME@_STATES; j++) printf(",%s", @name@_state_name(j));
  printf("\\n");
  do {
    status = @name@_run(&motion, 1000000);
    if (status == @NAME@_RUNNING) continue;
    recorded(&motion);
    @name@_clear(&motion);
  } while (status == @NAME@_RUNNING || status == @NAME@_TRACE_FULL);
  line(@name@_time(&motion), @name@_status_text(status), 0);
  states(@name@_states(&motion));
  return status == @NAME@_DONE ? 0 : 3;
}
"""

README = """\
Build and run: cc -O2 -o @name@ main.c @name@.c -lm && ./@name@ > motion.csv (any C99 compiler, no -ffast-math).
@name@.h is the interface; @name@.c needs no other library, allocates nothing and has no global state.
All values are dimensionless; lines of main.c: time, step or event, side or number of the contact, then the states.
"""
