/* FMI 2.0: the functions of co-simulation.

   The declarations of fmi2Functions.h that are needed are repeated here, so that nothing but a C
   compiler is. With FMI2_HEADERS that file is included instead, which checks them. */

#define FMI_FALSE 0
#ifdef FMI2_HEADERS
#include "fmi2Functions.h"
#else
typedef double fmi2Real;
typedef int fmi2Integer, fmi2Boolean;
typedef unsigned int fmi2ValueReference;
typedef const char *fmi2String;
typedef char fmi2Byte;
typedef void *fmi2Component, *fmi2ComponentEnvironment, *fmi2FMUstate;
typedef enum { fmi2OK, fmi2Warning, fmi2Discard, fmi2Error, fmi2Fatal, fmi2Pending } fmi2Status;
typedef enum { fmi2ModelExchange, fmi2CoSimulation } fmi2Type;
typedef enum {
    fmi2DoStepStatus, fmi2PendingStatus, fmi2LastSuccessfulTime, fmi2Terminated
} fmi2StatusKind;
typedef struct {
    void (*logger)(fmi2ComponentEnvironment, fmi2String, fmi2Status, fmi2String, fmi2String, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(fmi2ComponentEnvironment, fmi2Status);
    fmi2ComponentEnvironment componentEnvironment;
} fmi2CallbackFunctions;
#endif

/* The text goes as the format, because some programs show that alone: % is doubled. */
static void log2_(Instance *a, int status, const char *text)
{
    const fmi2CallbackFunctions *call = a->call;
    char *format = calloc(2 * strlen(text) + 1, 1), *to = format;
    if (format && call && call->logger) {
        const char *category = status == STATUS_WARNING ? "logStatusWarning" : "logStatusError";
        for (; *text; text++) {
            if (*text == '%') *to++ = '%';
            *to++ = *text;
        }
        call->logger(call->componentEnvironment, a->name, (fmi2Status)status, category, format);
    }
    free(format);
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean on, size_t n, const fmi2String k[])
{
    (void)c, (void)on, (void)n, (void)k;
    return fmi2OK;                            /* warnings and errors are always told */
}

EXPORT fmi2Component fmi2Instantiate(fmi2String name, fmi2Type type, fmi2String guid,
                                     fmi2String resources, const fmi2CallbackFunctions *call,
                                     fmi2Boolean visible, fmi2Boolean logging)
{
    (void)visible, (void)logging;
    Instance *a = calloc(1, sizeof *a);
    if (!a) return 0;
    a->log = log2_, a->call = call, a->socket = -1;
    a->name = strdup(name && *name ? name : "plymotion");
    char *folder = 0;
    if (type != fmi2CoSimulation) refuse(a, "fmi2Instantiate", "expected fmi2CoSimulation");
    else if (!guid || strcmp(guid, GUID) != 0)
        refuse(a, "fmi2Instantiate", "GUID of another modelDescription.xml");
    else if (!(folder = folder_of(resources)))
        refuse(a, "fmi2Instantiate", "fmuResourceLocation: expected a file: URI");
    a = made(a, folder);
    free(folder);
    return a;
}

EXPORT void fmi2FreeInstance(fmi2Component c) { if (c) release(c); }

EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                      fmi2Real start, fmi2Boolean has_stop, fmi2Real stop)
{
    Instance *a = c;
    (void)has_tolerance, (void)tolerance;     /* it is that of the case */
    (void)has_stop, (void)stop;               /* there is no end */
    if (a->state != INSTANTIATED) return (fmi2Status)refuse(a, "fmi2SetupExperiment", "called out of turn");
    a->t0 = start, a->t = start;
    return fmi2OK;
}

EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    return (fmi2Status)enter(c, "fmi2EnterInitializationMode", INSTANTIATED, INITIALIZING);
}

EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    return (fmi2Status)exit_initialization(c, "fmi2ExitInitializationMode");
}

EXPORT fmi2Status fmi2Terminate(fmi2Component c)
{
    ((Instance *)c)->state = ENDED;
    return fmi2OK;
}

EXPORT fmi2Status fmi2Reset(fmi2Component c) { return (fmi2Status)reset(c); }

/* ---------------------------------------------------------------- FMI: variables */

EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    return (fmi2Status)get_reals(c, "fmi2GetReal", vr, n, value);
}

EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                              const fmi2Real value[])
{
    return (fmi2Status)set_reals(c, "fmi2SetReal", vr, n, value);
}

EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Integer value[])
{
    return (fmi2Status)get_orders(c, "fmi2GetInteger", vr, n, value);
}

EXPORT fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                              const fmi2Integer value[])
{
    return (fmi2Status)set_orders(c, "fmi2SetInteger", vr, n, value);
}

#define NO_VARIABLES(type)                                                                    \
    EXPORT fmi2Status fmi2Get##type(fmi2Component c, const fmi2ValueReference vr[], size_t n, \
                                    fmi2##type value[])                                       \
    {                                                                                         \
        (void)vr, (void)value;                                                                \
        return n ? (fmi2Status)refuse(c, "fmi2Get" #type, "there are no " #type " variables") : fmi2OK;   \
    }                                                                                         \
    EXPORT fmi2Status fmi2Set##type(fmi2Component c, const fmi2ValueReference vr[], size_t n, \
                                    const fmi2##type value[])                                 \
    {                                                                                         \
        (void)vr, (void)value;                                                                \
        return n ? (fmi2Status)refuse(c, "fmi2Set" #type, "there are no " #type " variables") : fmi2OK;   \
    }

NO_VARIABLES(Boolean)
NO_VARIABLES(String)

/* ---------------------------------------------------------------- FMI: co-simulation */

EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                              const fmi2Integer order[], const fmi2Real value[])
{
    Instance *a = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= (unsigned)a->n_in)
            return (fmi2Status)refuse(a, "fmi2SetRealInputDerivatives", "not an input");
        if (order[i] < 1 || order[i] > 2)
            return (fmi2Status)refuse(a, "fmi2SetRealInputDerivatives", "order: expected 1 or 2");
        a->rates[2 * vr[i] + (unsigned)order[i] - 1] = value[i];
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                               const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    return n ? (fmi2Status)refuse(c, "fmi2GetRealOutputDerivatives", "outputs have no derivatives") : fmi2OK;
}

EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_way_back)
{
    int early;
    (void)no_way_back;
    return (fmi2Status)move(c, "fmi2DoStep", t, h, &early);
}

EXPORT fmi2Status fmi2CancelStep(fmi2Component c)
{
    return (fmi2Status)refuse(c, "fmi2CancelStep", "steps are not asynchronous");
}

EXPORT fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Status *value)
{
    if (kind != fmi2DoStepStatus) return fmi2Discard;
    *value = ((Instance *)c)->state == FAILED ? fmi2Error : fmi2OK;
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Real *value)
{
    if (kind != fmi2LastSuccessfulTime) return fmi2Discard;
    *value = ((Instance *)c)->t;
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind k, fmi2Integer *value)
{
    (void)c, (void)k, (void)value;
    return fmi2Discard;
}

EXPORT fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind kind, fmi2Boolean *value)
{
    (void)c;
    if (kind != fmi2Terminated) return fmi2Discard;
    *value = FMI_FALSE;
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind k, fmi2String *value)
{
    (void)c, (void)k, (void)value;
    return fmi2Discard;
}

/* ---------------------------------------------------------------- FMI: states and derivatives */

EXPORT fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *s)
{
    return (fmi2Status)save(c, "fmi2GetFMUstate", s);
}

EXPORT fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate s)
{
    return (fmi2Status)restore(c, "fmi2SetFMUstate", s);
}

EXPORT fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *s) { return (fmi2Status)forget(c, s); }

EXPORT fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference unknown[],
                                               size_t n_unknown, const fmi2ValueReference known[],
                                               size_t n_known, const fmi2Real seed[], fmi2Real out[])
{
    return (fmi2Status)derive(c, "fmi2GetDirectionalDerivative", unknown, n_unknown, known, n_known,
                              seed, out, 0);
}

/* ---------------------------------------------------------------- FMI: optional, not available */

#define NOT_AVAILABLE(name, ...)                                              \
    EXPORT fmi2Status name(fmi2Component c, __VA_ARGS__)                      \
    {                                                                         \
        return (fmi2Status)refuse(c, #name, "not available, see modelDescription.xml"); \
    }

NOT_AVAILABLE(fmi2SerializedFMUstateSize, fmi2FMUstate s, size_t *n)
NOT_AVAILABLE(fmi2SerializeFMUstate, fmi2FMUstate s, fmi2Byte b[], size_t n)
NOT_AVAILABLE(fmi2DeSerializeFMUstate, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
#undef NO_VARIABLES
#undef NOT_AVAILABLE
