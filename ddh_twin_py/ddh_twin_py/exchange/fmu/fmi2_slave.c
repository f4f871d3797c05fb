/* FMI 2.0 co-simulation slave around the compiled free run.
 *
 * ddh_model.h is generated: counts, starts of all variables, GUID. ddh_step and ddh_settle are the model (object code).
 * References count as in variables.py: inputs from 0, settings from 100, parameters from 1000, outputs from 2000,
 * temperatures from 3000. Types and functions follow the FMI 2.0.4 specification.
 */
#include <math.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ddh_model.h"

#define EXPORT __attribute__((visibility("default")))

typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef unsigned int fmi2ValueReference;
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum { fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated } fmi2StatusKind;
typedef struct {
  void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
  void *(*allocateMemory)(size_t, size_t);
  void (*freeMemory)(void *);
  void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
  fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;

double ddh_step(double *parameters, double *state, double *temperature, const double *command, const double *ambient,
                double interval, double step, const double *position, double *point, double *temperatures);
void ddh_settle(double *parameters, double *state, double position, double pressure_a, double pressure_b);

enum { SPEED_COMMAND, PAYLOAD, AMBIENT, INPUTS };
enum { START_TEMPERATURE, START_POSITION, START_PRESSURE_A, START_PRESSURE_B, LONGEST_INTERVAL, HYDRAULIC_STEP, SETTINGS };

/* All that changes, without a pointer: a copy of it is the FMU's state. */
typedef struct {
  double time;
  double inputs[INPUTS], slopes[INPUTS], settings[SETTINGS], parameters[DDH_PARAMETERS];
  double state[DDH_STATES], temperature[DDH_NODES], outputs[DDH_OUTPUTS];
  int initialised;
} Values;

typedef struct {
  Values values;
  fmi2CallbackFunctions callbacks;
  char *name;
} Slave;

/* ---- what the compiled model wants of numba's runtime: memory that is counted, and errors that cannot happen ---- */

typedef struct {
  size_t references;
  void (*destroy)(void *, size_t, void *);
  void *destroy_info, *data;
  size_t size;
  void *allocator;
} MemInfo;

static _Thread_local int model_failed;

void *NRT_Allocate(size_t size) { return malloc(size); }
void NRT_Free(void *pointer) { free(pointer); }
static MemInfo *new_memory(size_t size, size_t alignment) {
  char *block = malloc(sizeof(MemInfo) + size + 2 * alignment);
  if (!block) return NULL;
  MemInfo *info = (MemInfo *)block;
  size_t first = (size_t)(block + sizeof(MemInfo));
  *info = (MemInfo){1, NULL, NULL, (void *)((first + alignment - 1) / alignment * alignment), size, NULL};
  return info;
}
void *NRT_MemInfo_alloc(size_t size) { return new_memory(size, 16); }
void *NRT_MemInfo_alloc_aligned(size_t size, unsigned alignment) { return new_memory(size, alignment < 16 ? 16 : alignment); }
void NRT_MemInfo_call_dtor(MemInfo *info) {
  if (info->destroy) info->destroy(info->data, info->size, info->destroy_info);
  free(info);
}
/* Reached only where the model raises, which it does for arrays of a wrong length alone. */
#define REFUSED(name) \
  void *name(void) { model_failed = 1; return NULL; }
REFUSED(PyBytes_FromStringAndSize)
REFUSED(PyErr_Clear)
REFUSED(PyErr_SetNone)
REFUSED(PyErr_SetString)
REFUSED(PyErr_WriteUnraisable)
REFUSED(PyErr_Format)
REFUSED(PyObject_Hash)
REFUSED(PyTuple_Pack)
REFUSED(PyUnicode_FromKindAndData)
REFUSED(PyUnicode_FromString)
REFUSED(Py_DecRef)
REFUSED(Py_IncRef)
REFUSED(numba_do_raise)
REFUSED(numba_gil_ensure)
REFUSED(numba_gil_release)
REFUSED(numba_runtime_build_excinfo_struct)
REFUSED(numba_unpickle)
void *PyExc_RuntimeError, *PyExc_StopIteration, *PyExc_SystemError, *PyExc_ValueError, *PyExc_IndexError;

/* ---- values ---- */

static double *place(Values *v, fmi2ValueReference r) {
  if (r < INPUTS) return v->inputs + r;
  if (r >= DDH_FIRST_SETTING && r < DDH_FIRST_SETTING + SETTINGS) return v->settings + (r - DDH_FIRST_SETTING);
  if (r >= DDH_FIRST_PARAMETER && r < DDH_FIRST_PARAMETER + DDH_PARAMETERS) return v->parameters + (r - DDH_FIRST_PARAMETER);
  if (r >= DDH_FIRST_OUTPUT && r < DDH_FIRST_OUTPUT + DDH_OUTPUTS) return v->outputs + (r - DDH_FIRST_OUTPUT);
  if (r >= DDH_FIRST_TEMPERATURE && r < DDH_FIRST_TEMPERATURE + DDH_NODES) return v->temperature + (r - DDH_FIRST_TEMPERATURE);
  return NULL;
}

typedef struct {
  fmi2ValueReference reference;
  const char *name;
  double lowest, highest;
} Bound;

/* What a parameter of the rig may be set to, as in a rig file; NULL where nothing is said of it. */
static const Bound *bound_of(fmi2ValueReference r) {
  static const Bound bounds[] = DDH_BOUNDS;
  for (size_t i = 0; i < sizeof bounds / sizeof bounds[0]; i++)
    if (bounds[i].reference == r) return bounds + i;
  return NULL;
}

static fmi2Status said(Slave *s, fmi2Status status, const char *format, ...) {
  char text[256];
  va_list more;
  va_start(more, format);
  vsnprintf(text, sizeof text, format, more);
  va_end(more);
  if (s->callbacks.logger) s->callbacks.logger(s->callbacks.componentEnvironment, s->name, status, "logStatusError", "%s", text);
  return status;
}

static void begin(Values *v) {
  static const double inputs[] = DDH_INPUT_STARTS, settings[] = DDH_SETTING_STARTS, parameters[] = DDH_PARAMETER_STARTS;
  memset(v, 0, sizeof *v);
  memcpy(v->inputs, inputs, sizeof inputs);
  memcpy(v->settings, settings, sizeof settings);
  memcpy(v->parameters, parameters, sizeof parameters);
}

/* The outputs that hold now, from the hydraulic state. */
static void tell(Values *v) {
  static const int now[][2] = DDH_NOW;
  for (size_t i = 0; i < sizeof now / sizeof now[0]; i++) {
    double value = v->state[now[i][1]];
    v->outputs[now[i][0]] = now[i][1] == DDH_STATE_PRESSURE_A || now[i][1] == DDH_STATE_PRESSURE_B
                                ? fmax(value, DDH_VAPOUR_PRESSURE) : value;
  }
}

static void settle(Values *v) {
  for (int i = 0; i < DDH_NODES; i++) v->temperature[i] = v->settings[START_TEMPERATURE];
  v->parameters[DDH_PAYLOAD] = v->inputs[PAYLOAD];
  ddh_settle(v->parameters, v->state, v->settings[START_POSITION], v->settings[START_PRESSURE_A], v->settings[START_PRESSURE_B]);
  memset(v->outputs, 0, sizeof v->outputs);
  tell(v);
}

static const char *wrong_setting(const Values *v) {
  if (!(v->settings[LONGEST_INTERVAL] > 0.0 && v->settings[LONGEST_INTERVAL] <= 10.0)) return "solver.longest_interval must be above 0 to 10 s";
  if (!(v->settings[HYDRAULIC_STEP] > 0.0 && v->settings[HYDRAULIC_STEP] <= 0.1)) return "solver.hydraulic_step must be above 0 to 0.1 s";
  if (!(v->settings[START_TEMPERATURE] > 173.15 && v->settings[START_TEMPERATURE] < 573.15)) return "start.temperature is in K, 173.15 to 573.15";
  if (!(v->settings[START_POSITION] >= 0.0 && v->settings[START_POSITION] <= v->parameters[DDH_STROKE])) return "start.rod_position must be 0 to cylinder.stroke";
  for (int i = START_PRESSURE_A; i <= START_PRESSURE_B; i++)
    if (!(v->settings[i] >= -1.1e5 && v->settings[i] <= 1e8)) return "start.pressure_piston_side and _rod_side are gauge, in Pa, -1.1e5 to 1e8";
  if (!(v->inputs[PAYLOAD] > 0.0 && v->inputs[PAYLOAD] <= 1e5)) return "payload_mass must be above 0 to 1e5 kg";
  if (!(v->inputs[AMBIENT] > 173.15 && v->inputs[AMBIENT] < 573.15)) return "ambient_temperature is in K, 173.15 to 573.15";
  if (!isfinite(v->inputs[SPEED_COMMAND])) return "speed_command is not finite";
  return NULL;
}

/* ---- life ---- */

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid, fmi2String resources,
                                     const fmi2CallbackFunctions *callbacks, fmi2Boolean visible, fmi2Boolean logging) {
  (void)resources, (void)visible, (void)logging;
  Slave *s = calloc(1, sizeof *s);
  if (!s) return NULL;
  s->callbacks = *callbacks;
  s->name = strdup(name ? name : "ddh_twin");
  if (type != fmi2CoSimulation) {
    said(s, fmi2Error, "this FMU is for co-simulation");
  } else if (!guid || strcmp(guid, DDH_GUID) != 0) {
    said(s, fmi2Error, "GUID is %s, the binary is of %s", guid ? guid : "not given", DDH_GUID);
  } else {
    begin(&s->values);
    return s;
  }
  free(s->name);
  free(s);
  return NULL;
}

EXPORT void fmi2FreeInstance(fmi2Component c) {
  Slave *s = c;
  if (!s) return;
  free(s->name);
  free(s);
}

EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String categories[]) {
  (void)c, (void)on, (void)n, (void)categories;
  return fmi2OK;
}

EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean tolerant, fmi2Real tolerance, fmi2Real start, fmi2Boolean ends, fmi2Real stop) {
  (void)tolerant, (void)tolerance, (void)ends, (void)stop;
  ((Slave *)c)->values.time = start;
  return fmi2OK;
}

EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c) {
  (void)c;
  return fmi2OK;
}

EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c) {
  Slave *s = c;
  const char *wrong = wrong_setting(&s->values);
  if (wrong) return said(s, fmi2Error, "%s", wrong);
  settle(&s->values);
  s->values.initialised = 1;
  return fmi2OK;
}

EXPORT fmi2Status fmi2Terminate(fmi2Component c) {
  (void)c;
  return fmi2OK;
}

EXPORT fmi2Status fmi2Reset(fmi2Component c) {
  begin(&((Slave *)c)->values);
  return fmi2OK;
}

/* ---- one step ---- */

EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real now, fmi2Real h, fmi2Boolean keeps) {
  Slave *s = c;
  Values *v = &s->values;
  double command[DDH_COMMAND_PARTS + 1], point[DDH_POINT], sum[DDH_OUTPUTS] = {0}, after[DDH_NODES], ambient, nowhere = NAN;
  (void)keeps;
  if (!v->initialised) return said(s, fmi2Error, "not initialised");
  const char *wrong = wrong_setting(v);
  if (wrong) return said(s, fmi2Error, "%s", wrong);
  if (!(h > 0.0)) return said(s, fmi2Error, "the step is %g s, it must be above 0", h);
  double payload = v->inputs[PAYLOAD] + v->slopes[PAYLOAD] * h;
  if (!(payload > 0.0 && payload <= 1e5)) return said(s, fmi2Error, "the slope of payload_mass leads to %g kg, it must be above 0 to 1e5 kg", payload);
  double wanted = ceil(h / v->settings[LONGEST_INTERVAL] - 1e-6);
  long count = wanted < 1.0 ? 1 : (long)wanted;
  double interval = h / count;
  model_failed = 0;
  for (long k = 0; k < count; k++) {
    for (int j = 0; j <= DDH_COMMAND_PARTS; j++)
      command[j] = v->inputs[SPEED_COMMAND] + v->slopes[SPEED_COMMAND] * interval * (k + (double)j / DDH_COMMAND_PARTS);
    v->parameters[DDH_PAYLOAD] = v->inputs[PAYLOAD] + v->slopes[PAYLOAD] * interval * (k + 0.5);
    ambient = v->inputs[AMBIENT] + v->slopes[AMBIENT] * interval * (k + 0.5);
    ddh_step(v->parameters, v->state, v->temperature, command, &ambient, interval, v->settings[HYDRAULIC_STEP], &nowhere, point, after);
    for (int i = 0; i < DDH_OUTPUTS; i++) sum[i] += point[i];
  }
  for (int i = 0; i < DDH_OUTPUTS; i++) v->outputs[i] = sum[i] / count;
  tell(v);
  memset(v->slopes, 0, sizeof v->slopes);
  v->time = now + h;
  for (int i = 0; i < DDH_OUTPUTS; i++)
    if (!isfinite(v->outputs[i])) model_failed = 1;
  for (int i = 0; i < DDH_NODES; i++)
    if (!isfinite(v->temperature[i])) model_failed = 1;
  return model_failed ? said(s, fmi2Error, "no finite numbers from %g s to %g s; look at parameters and inputs", now, now + h) : fmi2OK;
}

EXPORT fmi2Status fmi2CancelStep(fmi2Component c) {
  (void)c;
  return fmi2Error;
}

/* ---- getting and setting ---- */

EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, fmi2Real value[]) {
  for (size_t i = 0; i < n; i++) {
    double *at = place(&((Slave *)c)->values, r[i]);
    if (!at) return said(c, fmi2Error, "no variable has the reference %u", r[i]);
    value[i] = *at;
  }
  return fmi2OK;
}

EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Real value[]) {
  Slave *s = c;
  for (size_t i = 0; i < n; i++) {
    double *at = place(&s->values, r[i]);
    if (!at || r[i] >= DDH_FIRST_OUTPUT) return said(s, fmi2Error, "reference %u is no variable that can be set", r[i]);
    if (!isfinite(value[i])) return said(s, fmi2Error, "reference %u: value is not finite", r[i]);
    const Bound *bound = bound_of(r[i]);
    if (bound && !(value[i] >= bound->lowest && value[i] <= bound->highest))
      return said(s, fmi2Error, "%s: value is %g, allowed are %g to %g", bound->name, value[i], bound->lowest, bound->highest);
    *at = value[i];
    if (r[i] < INPUTS) s->values.slopes[r[i]] = 0.0;
  }
  return fmi2OK;
}

EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference r[], size_t n, const fmi2Integer order[],
                                              const fmi2Real value[]) {
  Slave *s = c;
  for (size_t i = 0; i < n; i++) {
    if (r[i] >= INPUTS || order[i] != 1) return said(s, fmi2Error, "reference %u: first derivatives of inputs alone can be set", r[i]);
    s->values.slopes[r[i]] = value[i];
  }
  return fmi2OK;
}

#define NONE(name, ...) \
  EXPORT fmi2Status name(fmi2Component c, __VA_ARGS__) { return n ? said(c, fmi2Error, #name ": there is no such variable") : fmi2OK; }
NONE(fmi2GetInteger, const fmi2ValueReference r[], size_t n, fmi2Integer value[])
NONE(fmi2GetBoolean, const fmi2ValueReference r[], size_t n, fmi2Boolean value[])
NONE(fmi2GetString, const fmi2ValueReference r[], size_t n, fmi2String value[])
NONE(fmi2SetInteger, const fmi2ValueReference r[], size_t n, const fmi2Integer value[])
NONE(fmi2SetBoolean, const fmi2ValueReference r[], size_t n, const fmi2Boolean value[])
NONE(fmi2SetString, const fmi2ValueReference r[], size_t n, const fmi2String value[])
NONE(fmi2GetRealOutputDerivatives, const fmi2ValueReference r[], size_t n, const fmi2Integer order[], fmi2Real value[])

EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference u[], size_t n, const fmi2ValueReference k[],
                                               size_t m, const fmi2Real dk[], fmi2Real du[]) {
  (void)u, (void)n, (void)k, (void)m, (void)dk, (void)du;
  return said(c, fmi2Error, "directional derivatives are not given");
}

/* ---- state ---- */

EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *state) {
  if (!*state) *state = malloc(sizeof(Values));
  if (!*state) return said(c, fmi2Error, "no memory for the state");
  memcpy(*state, &((Slave *)c)->values, sizeof(Values));
  return fmi2OK;
}
EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate state) {
  memcpy(&((Slave *)c)->values, state, sizeof(Values));
  return fmi2OK;
}
EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *state) {
  (void)c;
  free(*state);
  *state = NULL;
  return fmi2OK;
}
EXPORT fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate state, size_t *size) {
  (void)c, (void)state;
  *size = sizeof(Values);
  return fmi2OK;
}
EXPORT fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate state, fmi2Byte bytes[], size_t size) {
  if (size < sizeof(Values)) return said(c, fmi2Error, "%zu bytes are too few for the state", size);
  memcpy(bytes, state, sizeof(Values));
  return fmi2OK;
}
EXPORT fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte bytes[], size_t size, fmi2FMUstate *state) {
  if (size != sizeof(Values)) return said(c, fmi2Error, "a state of %zu bytes is none of this FMU", size);
  if (!*state) *state = malloc(sizeof(Values));
  if (!*state) return said(c, fmi2Error, "no memory for the state");
  memcpy(*state, bytes, sizeof(Values));
  return fmi2OK;
}

/* ---- status of a step: every step is done when it returns ---- */

EXPORT fmi2Status fmi2GetStatus(fmi2Component c, fmi2StatusKind kind, fmi2Status *value) {
  (void)c, (void)kind;
  *value = fmi2OK;
  return fmi2OK;
}
EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, fmi2StatusKind kind, fmi2Real *value) {
  if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
  *value = ((Slave *)c)->values.time;
  return fmi2OK;
}
EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, fmi2StatusKind kind, fmi2Integer *value) {
  (void)c, (void)kind, (void)value;
  return fmi2Discard;
}
EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, fmi2StatusKind kind, fmi2Boolean *value) {
  (void)c;
  *value = 0;
  return kind == fmi2Terminated ? fmi2OK : fmi2Discard;
}
EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, fmi2StatusKind kind, fmi2String *value) {
  (void)c, (void)kind;
  *value = "";
  return fmi2Discard;
}
