/* A capsule that runs beside its controller on a microcontroller: a stepper in a control loop of 1 kHz.

   vibrocap export examples/travels-by-stick-slip.toml --to c --input drive --out capsule
   arm-none-eabi-gcc -mcpu=cortex-m7 -mthumb -mfpu=fpv5-d16 -mfloat-abi=hard -Os -Icapsule -c \
       examples/exchange/firmware.c capsule/capsule.c

   The code of the board calls `plant_begin` once and `plant_step` from its timer: a torque goes in, a pose comes out.
   Nothing is allocated; all memory but the stack is `motion`. A step takes longer where an event is, so leave a margin. */
#include "firmware.h"

#include "capsule.h"

#define LOOP_TIME 1e-3 /* of one step, in the units of the case: s where it is in SI */

static capsule motion; /* all memory but the stack */

int plant_begin(void) {
  capsule_case(&motion);
  return capsule_begin(&motion);
}

int plant_step(double drive, plant_pose *pose) {
  double h = LOOP_TIME / capsule_time_info()->scale;
  const double *now;
  int status;
  if (!capsule_set_input(&motion, drive / capsule_input_info(0)->scale, 0.0, 0.0)) return CAPSULE_REFUSED;
  status = capsule_step(&motion, h);
  now = capsule_look(&motion);
  pose->angle = now[0] * capsule_state_info(0)->scale;
  pose->position = now[2] * capsule_state_info(2)->scale;
  pose->at_rest = capsule_side(&motion, 1) == 0;
  return status;
}
