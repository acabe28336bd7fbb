/* The types of the Functional Mock-up Interface 2.0 (https://fmi-standard.org) that this FMU uses, declared anew. */
#ifndef FMI2_H
#define FMI2_H

#include <stddef.h>

/* Linked statically, all names begin with the prefix. */
#ifdef FMI2_FUNCTION_PREFIX
#define FMI_JOIN(prefix, name) prefix##fmi2##name
#define FMI_JOINED(prefix, name) FMI_JOIN(prefix, name)
#define FMI(name) FMI_JOINED(FMI2_FUNCTION_PREFIX, name)
#else
#define FMI(name) fmi2##name
#endif

typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer;
typedef int fmi2Boolean;
typedef char fmi2Byte;
typedef const char *fmi2String;

typedef struct {
  void (*logger)(fmi2ComponentEnvironment, fmi2String instance, fmi2Status, fmi2String category, fmi2String form, ...);
  void *(*allocateMemory)(size_t n, size_t size);
  void (*freeMemory)(void *);
  void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
  fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

#endif
