/* The library of an FMU (FMI 2.0, co-simulation): it starts the solver as a process of its own and
   exchanges numbers with it over a socket (server.py has the other end).

   Inputs, parameters and outputs are kept here. The solver hears of them at the start and with each
   communication step, and answers with all outputs at its end. POSIX only. */

#include "process.h"

static void forget_rates(Instance *a)
{
    for (int i = 0; i < 2 * a->n_in; i++) a->rates[i] = NAN;
}

static void restore(Instance *a)
{
    memcpy(a->in, a->start, (size_t)a->n_in * sizeof(double));
    memcpy(a->parameter, usual, sizeof usual);
    forget_rates(a);
    a->state = INSTANTIATED, a->stale = 1;
    a->t0 = a->t = 0.0;
}

/* ---------------------------------------------------------------- FMI: life of an instance */

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
    double *counts = 0;
    if (!a) return 0;
    a->call = call, a->socket = -1;
    a->name = strdup(name && *name ? name : "plymotion");
    if (type != fmi2CoSimulation || !guid || strcmp(guid, GUID) != 0) {
        refuse(a, "fmi2Instantiate", type != fmi2CoSimulation
               ? "expected fmi2CoSimulation" : "GUID of another modelDescription.xml");
        release(a);
        return 0;
    }
    char *folder = folder_of(resources);
    if (!folder) refuse(a, "fmi2Instantiate", "fmuResourceLocation: expected a file: URI");
    int ready = folder && launch(a, folder) && answer(a, &counts, 2) <= fmi2Warning;
    free(folder);
    if (ready) {
        a->n_in = (int)counts[0], a->n_out = (int)counts[1];
        a->in = calloc((size_t)a->n_in + 1, sizeof(double));
        a->rates = calloc(2 * (size_t)a->n_in + 1, sizeof(double));
        a->out = calloc((size_t)a->n_out + 1, sizeof(double));
        ready = a->in && a->rates && a->out && answer(a, &a->start, a->n_in) <= fmi2Warning;
    }
    free(counts);
    if (!ready) {
        release(a);
        return 0;
    }
    restore(a);
    return a;
}

EXPORT void fmi2FreeInstance(fmi2Component c) { if (c) release(c); }

EXPORT fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean has_tolerance, fmi2Real tolerance,
                                      fmi2Real start, fmi2Boolean has_stop, fmi2Real stop)
{
    Instance *a = c;
    (void)has_tolerance, (void)tolerance;     /* it is that of the case */
    (void)has_stop, (void)stop;               /* there is no end */
    if (a->state != INSTANTIATED) return refuse(a, "fmi2SetupExperiment", "called out of turn");
    a->t0 = start, a->t = start;
    return fmi2OK;
}

EXPORT fmi2Status fmi2EnterInitializationMode(fmi2Component c)
{
    Instance *a = c;
    if (a->state != INSTANTIATED)
        return refuse(a, "fmi2EnterInitializationMode", "called out of turn");
    a->state = INITIALIZING;
    return fmi2OK;
}

EXPORT fmi2Status fmi2ExitInitializationMode(fmi2Component c)
{
    Instance *a = c;
    if (a->state != INITIALIZING)
        return refuse(a, "fmi2ExitInitializationMode", "called out of turn");
    fmi2Status status = a->stale ? begin(a) : fmi2OK;
    if (status <= fmi2Warning) a->state = STEPPING;
    return status;
}

EXPORT fmi2Status fmi2Terminate(fmi2Component c)
{
    ((Instance *)c)->state = ENDED;
    return fmi2OK;
}

EXPORT fmi2Status fmi2Reset(fmi2Component c)
{
    restore(c);
    return fmi2OK;
}

/* ---------------------------------------------------------------- FMI: variables */

EXPORT fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n, fmi2Real value[])
{
    Instance *a = c;
    fmi2Status status = fmi2OK;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] < (unsigned)a->n_in) {
            value[i] = a->in[vr[i]];
            continue;
        }
        if (vr[i] >= (unsigned)(a->n_in + a->n_out))
            return refuse(a, "fmi2GetReal", "no such value reference");
        if (a->stale && (a->state == INITIALIZING || a->state == INSTANTIATED)) {
            status = begin(a);
            if (status > fmi2Warning) return status;
        }
        value[i] = a->out[vr[i] - (unsigned)a->n_in];
    }
    return status;
}

EXPORT fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                              const fmi2Real value[])
{
    Instance *a = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= (unsigned)a->n_in) return refuse(a, "fmi2SetReal", "not an input");
        if (!isfinite(value[i])) return refuse(a, "fmi2SetReal", "expected a finite number");
        if (a->in[vr[i]] != value[i]) a->stale = 1;
        a->in[vr[i]] = value[i];
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                 fmi2Integer value[])
{
    Instance *a = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= N_PARAMETER) return refuse(a, "fmi2GetInteger", "no such value reference");
        value[i] = a->parameter[vr[i]];
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2SetInteger(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                 const fmi2Integer value[])
{
    Instance *a = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= N_PARAMETER) return refuse(a, "fmi2SetInteger", "no such value reference");
        if (a->state != INSTANTIATED && a->state != INITIALIZING)
            return refuse(a, "fmi2SetInteger", "parameters are fixed after the initialization");
        if (value[i] < 0 || value[i] > 2)
            return refuse(a, "fmi2SetInteger", "an order of polynomials: expected 0, 1 or 2");
        a->parameter[vr[i]] = value[i], a->stale = 1;
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                 fmi2Boolean value[])
{
    (void)vr, (void)value;
    return n ? refuse(c, "fmi2GetBoolean", "there are no Boolean variables") : fmi2OK;
}

EXPORT fmi2Status fmi2SetBoolean(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                 const fmi2Boolean value[])
{
    (void)vr, (void)value;
    return n ? refuse(c, "fmi2SetBoolean", "there are no Boolean variables") : fmi2OK;
}

EXPORT fmi2Status fmi2GetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                fmi2String value[])
{
    (void)vr, (void)value;
    return n ? refuse(c, "fmi2GetString", "there are no String variables") : fmi2OK;
}

EXPORT fmi2Status fmi2SetString(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                const fmi2String value[])
{
    (void)vr, (void)value;
    return n ? refuse(c, "fmi2SetString", "there are no String variables") : fmi2OK;
}

/* ---------------------------------------------------------------- FMI: co-simulation */

EXPORT fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                              const fmi2Integer order[], const fmi2Real value[])
{
    Instance *a = c;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= (unsigned)a->n_in)
            return refuse(a, "fmi2SetRealInputDerivatives", "not an input");
        if (order[i] < 1 || order[i] > 2)
            return refuse(a, "fmi2SetRealInputDerivatives", "order: expected 1 or 2");
        a->rates[2 * vr[i] + (unsigned)order[i] - 1] = value[i];
    }
    return fmi2OK;
}

EXPORT fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t n,
                                               const fmi2Integer order[], fmi2Real value[])
{
    (void)vr, (void)order, (void)value;
    return n ? refuse(c, "fmi2GetRealOutputDerivatives", "outputs have no derivatives") : fmi2OK;
}

EXPORT fmi2Status fmi2DoStep(fmi2Component c, fmi2Real t, fmi2Real h, fmi2Boolean no_way_back)
{
    Instance *a = c;
    (void)no_way_back;
    if (a->state != STEPPING) return refuse(a, "fmi2DoStep", "called out of turn");
    if (!(h > 0.0) || !isfinite(h)) return refuse(a, "fmi2DoStep", "step size: expected above 0 s");
    if (fabs(t - a->t) > NEAR * (h + fabs(t)))
        return refuse(a, "fmi2DoStep", "expected to go on from where the last step has ended");
    double to = t + h - a->t0;
    if (!request(a, STEP, &to, 1, 1)) return lost(a);
    fmi2Status status = answer(a, &a->out, a->n_out);
    if (status <= fmi2Warning) a->t = t + h;
    forget_rates(a);
    a->stale = 0;
    return status;
}

EXPORT fmi2Status fmi2CancelStep(fmi2Component c)
{
    return refuse(c, "fmi2CancelStep", "steps are not asynchronous");
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

/* ---------------------------------------------------------------- FMI: optional, not available */

#define NOT_AVAILABLE(name, ...)                                              \
    EXPORT fmi2Status name(fmi2Component c, __VA_ARGS__)                      \
    {                                                                         \
        return refuse(c, #name, "not available, see modelDescription.xml");   \
    }

NOT_AVAILABLE(fmi2GetFMUstate, fmi2FMUstate *s)
NOT_AVAILABLE(fmi2SetFMUstate, fmi2FMUstate s)
NOT_AVAILABLE(fmi2FreeFMUstate, fmi2FMUstate *s)
NOT_AVAILABLE(fmi2SerializedFMUstateSize, fmi2FMUstate s, size_t *n)
NOT_AVAILABLE(fmi2SerializeFMUstate, fmi2FMUstate s, fmi2Byte b[], size_t n)
NOT_AVAILABLE(fmi2DeSerializeFMUstate, const fmi2Byte b[], size_t n, fmi2FMUstate *s)
NOT_AVAILABLE(fmi2GetDirectionalDerivative, const fmi2ValueReference u[], size_t nu,
              const fmi2ValueReference k[], size_t nk, const fmi2Real dk[], fmi2Real du[])
