/* What the board's code sees of a capsule, see firmware.c. */
#ifndef FIRMWARE_H
#define FIRMWARE_H

typedef struct {
  double angle, position; /* in the units of the case */
  int at_rest;            /* 1: the contact sticks */
} plant_pose;

/* Both return the status of the motion: 0 while it goes on, see capsule_status_text of capsule.h. */
int plant_begin(void);
int plant_step(double drive, plant_pose *pose);

#endif
