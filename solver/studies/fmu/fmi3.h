/* FMI 3.0: the functions of co-simulation.

   As in fmi2.h, what is needed of fmi3Functions.h is repeated, and checked with FMI3_HEADERS. */

#ifdef FMI3_HEADERS
#include "fmi3Functions.h"
#else
#include <stdbool.h>
typedef void *fmi3Instance, *fmi3InstanceEnvironment, *fmi3FMUState;
typedef uint32_t fmi3ValueReference;
typedef float fmi3Float32;
typedef double fmi3Float64;
typedef int8_t fmi3Int8;
typedef uint8_t fmi3UInt8, fmi3Byte;
typedef int16_t fmi3Int16;
typedef uint16_t fmi3UInt16;
typedef int32_t fmi3Int32;
typedef uint32_t fmi3UInt32;
typedef int64_t fmi3Int64;
typedef uint64_t fmi3UInt64;
typedef bool fmi3Boolean, fmi3Clock;
typedef const char *fmi3String;
typedef const fmi3Byte *fmi3Binary;
typedef enum { fmi3OK, fmi3Warning, fmi3Discard, fmi3Error, fmi3Fatal } fmi3Status;
typedef int fmi3DependencyKind, fmi3IntervalQualifier;
typedef void (*fmi3LogMessageCallback)(fmi3InstanceEnvironment, fmi3Status, fmi3String, fmi3String);
typedef void (*fmi3IntermediateUpdateCallback)(fmi3InstanceEnvironment, fmi3Float64, fmi3Boolean,
                                               fmi3Boolean, fmi3Boolean, fmi3Boolean, fmi3Boolean *,
                                               fmi3Float64 *);
typedef void (*fmi3ClockUpdateCallback)(fmi3InstanceEnvironment);
typedef void (*fmi3LockPreemptionCallback)();
typedef void (*fmi3UnlockPreemptionCallback)();
#endif

static void log3(Instance *a, int status, const char *text)
{
    const char *category = status == STATUS_WARNING ? "logStatusWarning" : "logStatusError";
    if (a->call)
        ((fmi3LogMessageCallback)(uintptr_t)a->call)(a->environment, (fmi3Status)status, category, text);
}

/* ---------------------------------------------------------------- FMI 3: life of an instance */

EXPORT const char *fmi3GetVersion(void) { return "3.0"; }

EXPORT fmi3Status fmi3SetDebugLogging(fmi3Instance c, fmi3Boolean on, size_t n, const fmi3String k[])
{
    (void)c, (void)on, (void)n, (void)k;
    return fmi3OK;                            /* warnings and errors are always told */
}

EXPORT fmi3Instance fmi3InstantiateCoSimulation(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3Boolean events, fmi3Boolean early, const fmi3ValueReference between[], size_t n_between,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback call,
    fmi3IntermediateUpdateCallback update)
{
    (void)visible, (void)logging, (void)between, (void)n_between, (void)update;
    Instance *a = calloc(1, sizeof *a);
    if (!a) return 0;
    a->log = log3, a->call = (const void *)(uintptr_t)call, a->environment = environment;
    a->socket = -1, a->events = events, a->stops = events && early;
    a->name = strdup(name && *name ? name : "plymotion");
    int ours = token && strcmp(token, GUID) == 0;
    if (!ours) refuse(a, "fmi3InstantiateCoSimulation", "token of another modelDescription.xml");
    else if (!resources) refuse(a, "fmi3InstantiateCoSimulation", "resourcePath: expected a folder");
    return made(a, ours ? resources : 0);
}

EXPORT void fmi3FreeInstance(fmi3Instance c) { if (c) release(c); }

EXPORT fmi3Status fmi3EnterInitializationMode(fmi3Instance c, fmi3Boolean has_tolerance,
                                              fmi3Float64 tolerance, fmi3Float64 start,
                                              fmi3Boolean has_stop, fmi3Float64 stop)
{
    Instance *a = c;
    (void)has_tolerance, (void)tolerance;     /* it is that of the case */
    (void)has_stop, (void)stop;               /* there is no end */
    int status = enter(a, "fmi3EnterInitializationMode", INSTANTIATED, INITIALIZING);
    if (status == STATUS_OK) a->t0 = a->t = start;
    return (fmi3Status)status;
}

EXPORT fmi3Status fmi3ExitInitializationMode(fmi3Instance c)
{
    return (fmi3Status)exit_initialization(c, "fmi3ExitInitializationMode");
}

EXPORT fmi3Status fmi3EnterStepMode(fmi3Instance c)
{
    return (fmi3Status)enter(c, "fmi3EnterStepMode", EVENT, STEPPING);
}

EXPORT fmi3Status fmi3EnterEventMode(fmi3Instance c)
{
    Instance *a = c;
    if (!a->events) return (fmi3Status)refuse(a, "fmi3EnterEventMode", "eventModeUsed was false");
    return (fmi3Status)enter(a, "fmi3EnterEventMode", STEPPING, EVENT);
}

/* An impact changes memories of forces alone; the step behind it begins with that. */
EXPORT fmi3Status fmi3UpdateDiscreteStates(fmi3Instance c, fmi3Boolean *again, fmi3Boolean *terminate,
                                           fmi3Boolean *nominals, fmi3Boolean *values,
                                           fmi3Boolean *next, fmi3Float64 *time)
{
    *again = *terminate = *nominals = *values = *next = 0, *time = 0.0;
    return (fmi3Status)enter(c, "fmi3UpdateDiscreteStates", EVENT, EVENT);
}

EXPORT fmi3Status fmi3Terminate(fmi3Instance c)
{
    ((Instance *)c)->state = ENDED;
    return fmi3OK;
}

EXPORT fmi3Status fmi3Reset(fmi3Instance c) { return (fmi3Status)reset(c); }

EXPORT fmi3Status fmi3DoStep(fmi3Instance c, fmi3Float64 t, fmi3Float64 h, fmi3Boolean no_way_back,
                             fmi3Boolean *event, fmi3Boolean *terminate, fmi3Boolean *early,
                             fmi3Float64 *reached)
{
    int stopped;
    (void)no_way_back;
    fmi3Status status = (fmi3Status)move(c, "fmi3DoStep", t, h, &stopped);
    *terminate = 0, *event = *early = stopped, *reached = ((Instance *)c)->t;
    return status;
}

/* ---------------------------------------------------------------- FMI 3: variables */

#define VARIABLES(type, get, set)                                                             \
    EXPORT fmi3Status fmi3Get##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n,  \
                                    fmi3##type value[], size_t m)                             \
    {                                                                                         \
        (void)vr, (void)value, (void)m;                                                       \
        return (fmi3Status)(get);                                                             \
    }                                                                                         \
    EXPORT fmi3Status fmi3Set##type(fmi3Instance c, const fmi3ValueReference vr[], size_t n,  \
                                    const fmi3##type value[], size_t m)                       \
    {                                                                                         \
        (void)vr, (void)value, (void)m;                                                       \
        return (fmi3Status)(set);                                                             \
    }
#define NONE(what) n ? refuse(c, what, "there are no variables of this type") : STATUS_OK
#define NO_VARIABLES(type) VARIABLES(type, NONE("fmi3Get" #type), NONE("fmi3Set" #type))

VARIABLES(Float64, get_reals(c, "fmi3GetFloat64", vr, n, value),
          set_reals(c, "fmi3SetFloat64", vr, n, value))
VARIABLES(Int32, get_orders(c, "fmi3GetInt32", vr, n, value),
          set_orders(c, "fmi3SetInt32", vr, n, value))
NO_VARIABLES(Float32)
NO_VARIABLES(Int8)
NO_VARIABLES(UInt8)
NO_VARIABLES(Int16)
NO_VARIABLES(UInt16)
NO_VARIABLES(UInt32)
NO_VARIABLES(Int64)
NO_VARIABLES(UInt64)
NO_VARIABLES(Boolean)
NO_VARIABLES(String)

/* ---------------------------------------------------------------- FMI 3: states and derivatives */

EXPORT fmi3Status fmi3GetFMUState(fmi3Instance c, fmi3FMUState *s)
{
    return (fmi3Status)save(c, "fmi3GetFMUState", s);
}

EXPORT fmi3Status fmi3SetFMUState(fmi3Instance c, fmi3FMUState s)
{
    return (fmi3Status)restore(c, "fmi3SetFMUState", s);
}

EXPORT fmi3Status fmi3FreeFMUState(fmi3Instance c, fmi3FMUState *s) { return (fmi3Status)forget(c, s); }

#define DERIVATIVE(name, adjoint)                                                                     \
    EXPORT fmi3Status name(fmi3Instance c, const fmi3ValueReference unknown[], size_t n_unknown,      \
                           const fmi3ValueReference known[], size_t n_known, const fmi3Float64 seed[], \
                           size_t n_seed, fmi3Float64 out[], size_t n_out)                            \
    {                                                                                                 \
        if (n_seed != (adjoint ? n_unknown : n_known) || n_out != (adjoint ? n_known : n_unknown))    \
            return (fmi3Status)refuse(c, #name, "sizes of seed or answer");                           \
        return (fmi3Status)derive(c, #name, unknown, n_unknown, known, n_known, seed, out, adjoint);  \
    }

DERIVATIVE(fmi3GetDirectionalDerivative, 0)
DERIVATIVE(fmi3GetAdjointDerivative, 1)

/* ---------------------------------------------------------------- FMI 3: not available */

#define NOT_AVAILABLE(name, ...)                                                        \
    EXPORT fmi3Status name(fmi3Instance c, __VA_ARGS__)                                 \
    {                                                                                   \
        return (fmi3Status)refuse(c, #name, "not available, see modelDescription.xml"); \
    }
#define OF const fmi3ValueReference v[], size_t n

NOT_AVAILABLE(fmi3GetBinary, OF, size_t sizes[], fmi3Binary x[], size_t m)
NOT_AVAILABLE(fmi3SetBinary, OF, const size_t sizes[], const fmi3Binary x[], size_t m)
NOT_AVAILABLE(fmi3GetClock, OF, fmi3Clock x[])
NOT_AVAILABLE(fmi3SetClock, OF, const fmi3Clock x[])
NOT_AVAILABLE(fmi3GetNumberOfVariableDependencies, fmi3ValueReference v, size_t *n)
NOT_AVAILABLE(fmi3GetVariableDependencies, fmi3ValueReference v, size_t i[], fmi3ValueReference x[],
              size_t j[], fmi3DependencyKind kinds[], size_t n)
NOT_AVAILABLE(fmi3SerializedFMUStateSize, fmi3FMUState s, size_t *n)
NOT_AVAILABLE(fmi3SerializeFMUState, fmi3FMUState s, fmi3Byte b[], size_t n)
NOT_AVAILABLE(fmi3DeserializeFMUState, const fmi3Byte b[], size_t n, fmi3FMUState *s)
NOT_AVAILABLE(fmi3GetOutputDerivatives, OF, const fmi3Int32 order[], fmi3Float64 x[], size_t m)
NOT_AVAILABLE(fmi3GetIntervalDecimal, OF, fmi3Float64 x[], fmi3IntervalQualifier q[])
NOT_AVAILABLE(fmi3GetIntervalFraction, OF, fmi3UInt64 x[], fmi3UInt64 y[], fmi3IntervalQualifier q[])
NOT_AVAILABLE(fmi3GetShiftDecimal, OF, fmi3Float64 x[])
NOT_AVAILABLE(fmi3GetShiftFraction, OF, fmi3UInt64 x[], fmi3UInt64 y[])
NOT_AVAILABLE(fmi3SetIntervalDecimal, OF, const fmi3Float64 x[])
NOT_AVAILABLE(fmi3SetIntervalFraction, OF, const fmi3UInt64 x[], const fmi3UInt64 y[])
NOT_AVAILABLE(fmi3SetShiftDecimal, OF, const fmi3Float64 x[])
NOT_AVAILABLE(fmi3SetShiftFraction, OF, const fmi3UInt64 x[], const fmi3UInt64 y[])

#define NOT_HERE(name)                                                                  \
    EXPORT fmi3Status name(fmi3Instance c)                                              \
    {                                                                                   \
        return (fmi3Status)refuse(c, #name, "not available, see modelDescription.xml"); \
    }

NOT_HERE(fmi3EnterConfigurationMode)
NOT_HERE(fmi3ExitConfigurationMode)
NOT_HERE(fmi3EvaluateDiscreteStates)
NOT_HERE(fmi3EnterContinuousTimeMode)

/* Of model exchange and scheduled execution: some importers load all names of the standard. */
NOT_AVAILABLE(fmi3CompletedIntegratorStep, fmi3Boolean a, fmi3Boolean *event, fmi3Boolean *terminate)
NOT_AVAILABLE(fmi3SetTime, fmi3Float64 t)
NOT_AVAILABLE(fmi3SetContinuousStates, const fmi3Float64 x[], size_t n)
NOT_AVAILABLE(fmi3GetContinuousStateDerivatives, fmi3Float64 x[], size_t n)
NOT_AVAILABLE(fmi3GetEventIndicators, fmi3Float64 x[], size_t n)
NOT_AVAILABLE(fmi3GetContinuousStates, fmi3Float64 x[], size_t n)
NOT_AVAILABLE(fmi3GetNominalsOfContinuousStates, fmi3Float64 x[], size_t n)
NOT_AVAILABLE(fmi3GetNumberOfEventIndicators, size_t *n)
NOT_AVAILABLE(fmi3GetNumberOfContinuousStates, size_t *n)
NOT_AVAILABLE(fmi3ActivateModelPartition, fmi3ValueReference clock, fmi3Float64 t)

static fmi3Instance only_co_simulation(fmi3InstanceEnvironment environment, fmi3LogMessageCallback call)
{
    if (call) call(environment, fmi3Error, "logStatusError", "expected fmi3InstantiateCoSimulation");
    return 0;
}

EXPORT fmi3Instance fmi3InstantiateModelExchange(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback call)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    return only_co_simulation(environment, call);
}

EXPORT fmi3Instance fmi3InstantiateScheduledExecution(
    fmi3String name, fmi3String token, fmi3String resources, fmi3Boolean visible, fmi3Boolean logging,
    fmi3InstanceEnvironment environment, fmi3LogMessageCallback call, fmi3ClockUpdateCallback clock,
    fmi3LockPreemptionCallback lock, fmi3UnlockPreemptionCallback unlock)
{
    (void)name, (void)token, (void)resources, (void)visible, (void)logging;
    (void)clock, (void)lock, (void)unlock;
    return only_co_simulation(environment, call);
}
