/* A capsule as a block of Simulink: an S-function of level 2 that calls the stepper.

   vibrocap export examples/travels-by-stick-slip.toml --to c --input drive --out capsule
   mex -Icapsule examples/exchange/capsule_sfunction.c capsule/capsule.c        (in MATLAB)

   Input: the drive. Outputs: the states, then friction and the other observables, in the order of capsule.h; the side of
   each contact. Parameter: the sample time. All in the units of the case, s where it is in SI. The motion is a DWork
   vector, so that Simulink saves and restores it with the model, and several blocks run side by side. */
#define S_FUNCTION_NAME capsule_sfunction
#define S_FUNCTION_LEVEL 2

#include "capsule.h"
#include "simstruc.h"

#define SAMPLE_TIME(S) (mxGetScalar(ssGetSFcnParam(S, 0)))
#define MOTION(S) ((capsule *)ssGetDWork(S, 0))

static void mdlInitializeSizes(SimStruct *S) {
  ssSetNumSFcnParams(S, 1);
  if (ssGetNumSFcnParams(S) != ssGetSFcnParamsCount(S)) return; /* Simulink tells of it */
  if (!ssSetNumInputPorts(S, 1) || !ssSetNumOutputPorts(S, 2)) return;
  ssSetInputPortWidth(S, 0, 1);
  ssSetInputPortRequiredContiguous(S, 0, 1);
  ssSetInputPortDirectFeedThrough(S, 0, 0); /* the input is held over the step that follows */
  ssSetOutputPortWidth(S, 0, CAPSULE_STATES + CAPSULE_OBSERVABLES);
  ssSetOutputPortWidth(S, 1, CAPSULE_CONTACTS);
  ssSetNumSampleTimes(S, 1);
  ssSetNumDWork(S, 1);
  ssSetDWorkWidth(S, 0, (int)((sizeof(capsule) + sizeof(double) - 1) / sizeof(double)));
  ssSetDWorkDataType(S, 0, SS_DOUBLE);
  ssSetOptions(S, SS_OPTION_EXCEPTION_FREE_CODE);
}

static void mdlInitializeSampleTimes(SimStruct *S) {
  ssSetSampleTime(S, 0, SAMPLE_TIME(S));
  ssSetOffsetTime(S, 0, 0.0);
}

#define MDL_INITIALIZE_CONDITIONS
static void mdlInitializeConditions(SimStruct *S) {
  capsule_case(MOTION(S));
  capsule_begin(MOTION(S));
}

static void mdlOutputs(SimStruct *S, int_T tid) {
  double *seen = ssGetOutputPortRealSignal(S, 0), *sides = ssGetOutputPortRealSignal(S, 1);
  const double *now = capsule_look(MOTION(S));
  int i;
  (void)tid;
  for (i = 0; i < CAPSULE_STATES; i++) seen[i] = now[i] * capsule_state_info(i)->scale;
  for (i = 0; i < CAPSULE_OBSERVABLES; i++)
    seen[CAPSULE_STATES + i] = now[CAPSULE_STATES + i] * capsule_observable_info(i)->scale;
  for (i = 0; i < CAPSULE_CONTACTS; i++) sides[i] = capsule_side(MOTION(S), i + 1);
}

#define MDL_UPDATE
static void mdlUpdate(SimStruct *S, int_T tid) {
  const double *drive = ssGetInputPortRealSignal(S, 0);
  int status = CAPSULE_REFUSED;
  (void)tid;
  if (capsule_set_input(MOTION(S), drive[0] / capsule_input_info(0)->scale, 0.0, 0.0))
    status = capsule_step(MOTION(S), SAMPLE_TIME(S) / capsule_time_info()->scale);
  if (status != CAPSULE_RUNNING) ssSetErrorStatus(S, capsule_status_text(status));
}

static void mdlTerminate(SimStruct *S) { (void)S; }

#ifdef MATLAB_MEX_FILE
#include "simulink.c"
#else
#include "cg_sfun.h"
#endif
