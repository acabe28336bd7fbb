"""What stands in for other programs where examples of `examples/exchange/` are compiled: a board, Simulink, ROS 2.

Just enough of each to compile an example and to run it over the same input: MATLAB, ROS and a board themselves are not
there. Every program writes what it sees as doubles.
"""

STEPS, PHASE, STEP = 2500, 300, 0.01  # steps in all and between reversals of the drive, and their length

INPUT = f"""
#define STEPS {STEPS}
static double drive_at(int i) {{ return i / {PHASE} % 2 ? -1.8 : 1.8; }}
"""

# the library itself: time, states, observables and sides after every step
DIRECT = (
    INPUT
    + f"""
#include "capsule.h"
#include <stdio.h>
int main(void) {{
  static capsule c;
  int i, j;
  capsule_case(&c);
  capsule_begin(&c);
  for (i = 0; i <= STEPS; i++) {{
    const double *now = capsule_look(&c);
    double time = capsule_time(&c);
    fwrite(&time, sizeof time, 1, stdout);
    fwrite(now, sizeof *now, CAPSULE_STATES + CAPSULE_OBSERVABLES, stdout);
    for (j = 1; j <= CAPSULE_CONTACTS; j++) {{
      double side = capsule_side(&c, j);
      fwrite(&side, sizeof side, 1, stdout);
    }}
    if (!capsule_set_input(&c, drive_at(i), 0.0, 0.0) || capsule_step(&c, {STEP}) != CAPSULE_RUNNING) return 1;
  }}
  return 0;
}}
"""
)

# a board: it writes the pose after every step, then how much of the stack was in use
BOARD = (
    INPUT
    + """
#include "firmware.h"
#ifdef BARE /* no library of C: calls of Linux, which qemu answers */
static long call(long number, long a, long b, long n) {
  register long r7 __asm__("r7") = number, r0 __asm__("r0") = a, r1 __asm__("r1") = b, r2 __asm__("r2") = n;
  __asm__ volatile("svc 0" : "+r"(r0) : "r"(r7), "r"(r1), "r"(r2) : "memory");
  return r0;
}
static void out(const void *bytes, long n) { call(4, 1, (long)bytes, n); }
#else
#include <stdio.h>
static void out(const void *bytes, long n) { fwrite(bytes, 1, (unsigned long)n, stdout); }
#endif
#define STACK 16384
static int run(void) {
  volatile unsigned char here = 0, *stack = (volatile unsigned char *)((unsigned long)&here - STACK);
  double seen[3] = {0.0, 0.0, 0.0};
  int i, status = plant_begin();
  plant_pose pose;
  for (i = 0; i < STACK - 512; i++) stack[i] = 0xA5;
  for (i = 0; i < STEPS && status == 0; i++) {
    status = plant_step(drive_at(i), &pose);
    seen[0] = pose.angle, seen[1] = pose.position, seen[2] = pose.at_rest;
    out(seen, sizeof seen);
  }
  for (i = 0; i < STACK && stack[i] == 0xA5; i++) {
  }
  seen[0] = STACK - i, seen[1] = seen[2] = 0.0;
  out(seen, sizeof seen);
  return status;
}
#ifdef BARE
void _start(void) {
  call(1, run(), 0, 0);
  for (;;) {
  }
}
#else
int main(void) { return run(); }
#endif
"""
)

# what a library of C has for a kernel, where a compiler for a board brings none
BARE_HEADERS = {
    "math.h": """
double floor(double), sqrt(double), fabs(double);
#define INFINITY __builtin_inff()
#define HUGE_VAL __builtin_huge_val()
#define NAN __builtin_nanf("")
""",
    "string.h": """
#include <stddef.h>
void *memcpy(void *, const void *, size_t), *memset(void *, int, size_t);
int memcmp(const void *, const void *, size_t);
""",
}

SIMULINK = {
    "simstruc.h": """
#include <stddef.h>
typedef int int_T;
typedef struct {
  double parameter, in, seen[64], sides[8], work[8192];
  int parameters, work_width, widths[2];
  double sample_time;
  const char *error;
} SimStruct;
#define SS_DOUBLE 0
#define SS_OPTION_EXCEPTION_FREE_CODE 1
#define mxGetScalar(p) (*(p))
#define ssGetSFcnParam(S, i) (&(S)->parameter)
#define ssSetNumSFcnParams(S, n) ((S)->parameters = (n))
#define ssGetNumSFcnParams(S) ((S)->parameters)
#define ssGetSFcnParamsCount(S) 1
#define ssSetNumInputPorts(S, n) ((n) == 1)
#define ssSetNumOutputPorts(S, n) ((n) == 2)
#define ssSetInputPortWidth(S, i, n) ((void)0)
#define ssSetInputPortRequiredContiguous(S, i, n) ((void)0)
#define ssSetInputPortDirectFeedThrough(S, i, n) ((void)0)
#define ssSetOutputPortWidth(S, i, n) ((S)->widths[i] = (n))
#define ssSetNumSampleTimes(S, n) ((void)0)
#define ssSetNumDWork(S, n) ((void)0)
#define ssSetDWorkWidth(S, i, n) ((S)->work_width = (n))
#define ssSetDWorkDataType(S, i, t) ((void)0)
#define ssGetDWork(S, i) ((void *)(S)->work)
#define ssSetOptions(S, o) ((void)0)
#define ssSetSampleTime(S, i, t) ((S)->sample_time = (t))
#define ssSetOffsetTime(S, i, t) ((void)0)
#define ssGetOutputPortRealSignal(S, i) ((i) ? (S)->sides : (S)->seen)
#define ssGetInputPortRealSignal(S, i) ((const double *)&(S)->in)
#define ssSetErrorStatus(S, text) ((S)->error = (text))
""",
    "cg_sfun.h": INPUT
    + f"""
#include <stdio.h>
int main(void) {{
  static SimStruct s;
  int i;
  s.parameter = {STEP};
  mdlInitializeSizes(&s);
  mdlInitializeSampleTimes(&s);
  mdlInitializeConditions(&s);
  for (i = 0; i <= STEPS && !s.error; i++) {{
    mdlOutputs(&s, 0);
    fwrite(s.seen, sizeof(double), (size_t)s.widths[0], stdout);
    fwrite(s.sides, sizeof(double), (size_t)s.widths[1], stdout);
    s.in = drive_at(i);
    mdlUpdate(&s, 0);
  }}
  s.in = s.seen[0] / 0.0; /* is refused, in words */
  mdlUpdate(&s, 0);
  if (s.error) fputs(s.error, stderr);
  mdlTerminate(&s);
  return (size_t)s.work_width * sizeof(double) < sizeof(capsule);
}}
""",
}

ROS = {
    "std_msgs/msg/float64.hpp": """
#pragma once
#include <memory>
namespace std_msgs::msg {
struct Float64 {
  double data = 0.0;
  using ConstSharedPtr = std::shared_ptr<const Float64>;
};
}
""",
    "std_msgs/msg/float64_multi_array.hpp": """
#pragma once
#include <vector>
namespace std_msgs::msg { struct Float64MultiArray { std::vector<double> data; }; }
""",
    "std_msgs/msg/string.hpp": """
#pragma once
#include <string>
namespace std_msgs::msg { struct String { std::string data; }; }
""",
    "rclcpp/rclcpp.hpp": INPUT
    + """
#pragma once
#include <chrono>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include "std_msgs/msg/float64.hpp"
#include "std_msgs/msg/float64_multi_array.hpp"
#include "std_msgs/msg/string.hpp"
#define RCLCPP_WARN(logger, ...) std::fprintf(stderr, __VA_ARGS__)
#define RCLCPP_ERROR(logger, ...) std::fprintf(stderr, __VA_ARGS__)
namespace rclcpp {
inline void tell(const std_msgs::msg::Float64MultiArray &m) { std::fwrite(m.data.data(), 8, m.data.size(), stdout); }
inline void tell(const std_msgs::msg::String &m) { std::fprintf(stderr, "%s\\n", m.data.c_str()); }
template <class M> struct Publisher {
  using SharedPtr = std::shared_ptr<Publisher>;
  void publish(const M &m) { tell(m); }
};
template <class M> struct Subscription {
  using SharedPtr = std::shared_ptr<Subscription>;
};
struct TimerBase {
  using SharedPtr = std::shared_ptr<TimerBase>;
  std::function<void()> ring;
  bool over = false;
  void cancel() { over = true; }
};
class Node {
 public:
  explicit Node(const std::string &) {}
  int get_logger() { return 0; }
  template <class M> typename Publisher<M>::SharedPtr create_publisher(const std::string &, int) {
    return std::make_shared<Publisher<M>>();
  }
  template <class M, class F> typename Subscription<M>::SharedPtr create_subscription(const std::string &, int, F f) {
    hear = [f](double value) { auto m = std::make_shared<M>(); m->data = value; f(m); };
    return std::make_shared<Subscription<M>>();
  }
  template <class D, class F> TimerBase::SharedPtr create_wall_timer(D, F f) {
    timer = std::make_shared<TimerBase>();
    timer->ring = f;
    return timer;
  }
  std::function<void(double)> hear;
  TimerBase::SharedPtr timer;
};
inline void init(int, char **) {}
inline void shutdown() {}
inline void spin(std::shared_ptr<Node> node) {
  for (int i = 0; i < STEPS && !node->timer->over; i++) { node->hear(drive_at(i)); node->timer->ring(); }
}
}  // namespace rclcpp
""",
}
