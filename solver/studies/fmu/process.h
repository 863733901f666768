/* Instances of an FMU, and the process of the solver that each one has: what both versions of FMI
   share. Status numbers are the same in both. */

#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <signal.h>
#include <spawn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/wait.h>
#include <unistd.h>

#ifndef MSG_NOSIGNAL
#define MSG_NOSIGNAL 0
#endif

#ifdef __APPLE__
#include <crt_externs.h>
#define environ (*_NSGetEnviron())
#else
extern char **environ;
#endif

enum { START = 1, STEP, SAVE, RESTORE, FORGET, DERIVE }; /* requests */
enum { STATUS_OK, STATUS_WARNING, STATUS_DISCARD, STATUS_ERROR };
enum { DRIVE_ORDER, FORCE_ORDER, N_PARAMETER };
enum { INSTANTIATED, INITIALIZING, STEPPING, EVENT, ENDED, FAILED };
enum { TO_EVENT = 1, JUMPED = 2 };            /* of a step */
enum { MOST_TEXT = 1 << 20, MOST_NUMBERS = 1 << 24 };
#define NEAR 1e-9                             /* communication steps by which times may differ */

typedef struct Instance {
    void (*log)(struct Instance *, int status, const char *text);
    const void *call;                         /* of version 2: callbacks; of 3: the logger, */
    void *environment;                        /* and the environment */
    char *name;
    int state, stale;                         /* stale: outputs are not those of the inputs */
    int stops, events, jumped;                /* steps end at events; event mode; input in it */
    int socket;
    pid_t process;
    int n_in, n_out;
    double *start, *in, *rates, *out;         /* (n_in), (n_in), (n_in, 2), (n_out) */
    double *rows;                             /* (n_out, n_in) derivatives of the last step, or 0 */
    int32_t parameter[N_PARAMETER];
    double t0, t;
} Instance;

typedef struct {                              /* a state of an instance; the solver has the rest */
    double number, t0, t;
    int state, stale, jumped;
    int32_t parameter[N_PARAMETER];
    double numbers[];                         /* in, rates, out */
} Saved;

static const int32_t usual[N_PARAMETER] = {2, 1};

static int tell(Instance *a, int status, const char *text)
{
    a->log(a, status, text);
    return status;
}

static int refuse(Instance *a, const char *function, const char *why)
{
    char text[256];
    snprintf(text, sizeof text, "%s: %s", function, why);
    return tell(a, STATUS_ERROR, text);
}

/* ---------------------------------------------------------------- the solver's process */

static int transfer(Instance *a, char *data, size_t size, int sends)
{
    while (size > 0) {
        ssize_t n = sends ? send(a->socket, data, size, MSG_NOSIGNAL) : recv(a->socket, data, size, 0);
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return 0;
        data += n, size -= (size_t)n;
    }
    return 1;
}

static int lost(Instance *a)
{
    a->state = FAILED;
    return tell(a, STATUS_ERROR, a->start ? "the process of the solver has ended"
        : "the process of the solver has ended; expected a Python with plymotion: set "
          "PLYMOTION_PYTHON");
}

/* Take one answer: status, length of a text, count of numbers; numbers go to *into, made if null. */
static int answer(Instance *a, double **into, int expected)
{
    int32_t head[3];
    int status;
    if (!transfer(a, (char *)head, sizeof head, 0)) return lost(a);
    if (head[1] < 0 || head[1] > MOST_TEXT || head[2] < 0 || head[2] > MOST_NUMBERS) return lost(a);
    status = (int)head[0];
    if (head[1] > 0) {
        char *text = calloc((size_t)head[1] + 1, 1);
        if (!text || !transfer(a, text, (size_t)head[1], 0)) { free(text); return lost(a); }
        tell(a, status, text);
        free(text);
    }
    if (status > STATUS_WARNING) {
        a->state = FAILED;
        return status;
    }
    if (expected >= 0 && head[2] != expected) return lost(a);
    if (!*into) *into = calloc((size_t)head[2] + 1, sizeof(double));
    if (!*into || !transfer(a, (char *)*into, (size_t)head[2] * sizeof(double), 0)) return lost(a);
    return status;
}

static int request(Instance *a, int what, const double *first, int n_first, int n_in, int n_rates)
{
    int32_t head[2] = {what, n_first + n_in + n_rates};
    return transfer(a, (char *)head, sizeof head, 1)
        && transfer(a, (char *)first, (size_t)n_first * sizeof(double), 1)
        && transfer(a, (char *)a->in, (size_t)n_in * sizeof(double), 1)
        && transfer(a, (char *)a->rates, (size_t)n_rates * sizeof(double), 1);
}

static void forget_derivatives(Instance *a)
{
    free(a->rows);
    a->rows = 0;
}

/* Close the joints with the present inputs. */
static int begin(Instance *a)
{
    double first[N_PARAMETER];
    for (int i = 0; i < N_PARAMETER; i++) first[i] = a->parameter[i];
    if (!request(a, START, first, N_PARAMETER, a->n_in, 0)) return lost(a);
    a->stale = 0;
    forget_derivatives(a);
    return answer(a, &a->out, a->n_out);
}

/* The folder of a file: URI, or 0. */
static char *folder_of(const char *uri)
{
    if (!uri || strncmp(uri, "file:", 5) != 0) return 0;
    uri += 5;
    if (strncmp(uri, "//", 2) == 0) {
        uri = strchr(uri + 2, '/');           /* behind the name of the machine, if any */
        if (!uri) return 0;
    }
    char *path = calloc(strlen(uri) + 1, 1), *to = path;
    for (; path && *uri; uri++, to++) {
        unsigned code;
        if (*uri == '%' && sscanf(uri + 1, "%2x", &code) == 1) *to = (char)code, uri += 2;
        else *to = *uri;
    }
    return path;
}

/* Lines of resources/solver.txt: interpreter, and a folder that has plymotion, or nothing. */
static int read_solver(const char *folder, char *python, char *home, int size)
{
    char path[4096];
    const char *other = getenv("PLYMOTION_PYTHON");
    snprintf(path, sizeof path, "%s/solver.txt", folder);
    FILE *file = fopen(path, "r");
    if (!file) return 0;
    int found = fgets(python, size, file) != 0;
    if (!fgets(home, size, file)) home[0] = 0;
    fclose(file);
    python[strcspn(python, "\r\n")] = 0, home[strcspn(home, "\r\n")] = 0;
    if (other && *other) snprintf(python, (size_t)size, "%s", other), home[0] = 0;
    return found;
}

static int launch(Instance *a, const char *folder)
{
    char python[4096], home[4096], text[5000];
    const char *code = "import sys\n"
                       "sys.path[:0] = [p for p in sys.argv[1:2] if p]\n"
                       "from plymotion.solver.studies.fmu.server import main\n"
                       "sys.exit(main(sys.argv[2]))\n";
    int ends[2];
    if (!read_solver(folder, python, home, sizeof python)) {
        refuse(a, "instantiate", "resources/solver.txt cannot be read");
        return 0;
    }
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends)) {
        refuse(a, "instantiate", "no socket");
        return 0;
    }
    for (int i = 0; i < 2; i++) fcntl(ends[i], F_SETFD, FD_CLOEXEC);
#ifdef SO_NOSIGPIPE
    int on = 1;
    setsockopt(ends[0], SOL_SOCKET, SO_NOSIGPIPE, &on, sizeof on);
#endif
    /* -E -P: no Python variables of the program that has loaded this library, nor its folder. */
    char *words[] = {python, "-E", "-P", "-c", (char *)code, home, (char *)folder, 0};
    posix_spawn_file_actions_t actions;
    posix_spawnattr_t attributes;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], 0);
    posix_spawn_file_actions_adddup2(&actions, 2, 1);
    posix_spawnattr_init(&attributes);
    posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETPGROUP); /* Ctrl-C is not for it */
    int failed = posix_spawnp(&a->process, python, &actions, &attributes, words, environ);
    posix_spawn_file_actions_destroy(&actions);
    posix_spawnattr_destroy(&attributes);
    close(ends[1]);
    a->socket = ends[0];
    if (failed) {
        a->process = 0;
        snprintf(text, sizeof text,
                 "%s: %s; expected a Python with plymotion: set PLYMOTION_PYTHON", python,
                 strerror(failed));
        tell(a, STATUS_ERROR, text);
    }
    return !failed;
}

static void release(Instance *a)
{
    if (a->socket >= 0) close(a->socket);     /* the process ends by itself */
    if (a->process > 0)
        while (waitpid(a->process, 0, 0) < 0 && errno == EINTR) {}
    free(a->start), free(a->in), free(a->rates), free(a->out), free(a->rows), free(a->name), free(a);
}

static void forget_rates(Instance *a)
{
    for (int i = 0; i < 2 * a->n_in; i++) a->rates[i] = NAN;
}

static int reset(Instance *a)
{
    memcpy(a->in, a->start, (size_t)a->n_in * sizeof(double));
    memcpy(a->parameter, usual, sizeof usual);
    forget_rates(a);
    forget_derivatives(a);
    a->state = INSTANTIATED, a->stale = 1, a->jumped = 0;
    a->t0 = a->t = 0.0;
    return STATUS_OK;
}

/* Start the solver in a folder of resources; 0 and everything released where that fails. */
static Instance *made(Instance *a, const char *folder)
{
    double *counts = 0;
    int ready = folder && launch(a, folder) && answer(a, &counts, 2) <= STATUS_WARNING;
    if (ready) {
        a->n_in = (int)counts[0], a->n_out = (int)counts[1];
        a->in = calloc((size_t)a->n_in + 1, sizeof(double));
        a->rates = calloc(2 * (size_t)a->n_in + 1, sizeof(double));
        a->out = calloc((size_t)a->n_out + 1, sizeof(double));
        ready = a->in && a->rates && a->out && answer(a, &a->start, a->n_in) <= STATUS_WARNING;
    }
    free(counts);
    if (ready) reset(a);
    else release(a), a = 0;
    return a;
}

/* ---------------------------------------------------------------- modes */

/* Go from one mode to another, if the instance is in the first. */
static int enter(Instance *a, const char *function, int from, int to)
{
    if (a->state != from) return refuse(a, function, "called out of turn");
    a->state = to;
    return STATUS_OK;
}

static int exit_initialization(Instance *a, const char *function)
{
    if (a->state != INITIALIZING) return refuse(a, function, "called out of turn");
    int status = a->stale ? begin(a) : STATUS_OK;
    if (status <= STATUS_WARNING) a->state = a->events ? EVENT : STEPPING;
    return status;
}

/* ---------------------------------------------------------------- variables */

/* Value references: inputs, outputs, parameters, time. */
static int get_reals(Instance *a, const char *function, const uint32_t vr[], size_t n, double value[])
{
    int status = STATUS_OK, count = a->n_in + a->n_out;
    for (size_t i = 0; i < n; i++) {
        if (vr[i] < (unsigned)a->n_in) {
            value[i] = a->in[vr[i]];
            continue;
        }
        if (vr[i] == (unsigned)(count + N_PARAMETER)) {
            value[i] = a->t;
            continue;
        }
        if (vr[i] >= (unsigned)count) return refuse(a, function, "no such value reference");
        if (a->stale && (a->state == INITIALIZING || a->state == INSTANTIATED)) {
            status = begin(a);
            if (status > STATUS_WARNING) return status;
        }
        value[i] = a->out[vr[i] - (unsigned)a->n_in];
    }
    return status;
}

static int set_reals(Instance *a, const char *function, const uint32_t vr[], size_t n,
                     const double value[])
{
    for (size_t i = 0; i < n; i++) {
        if (vr[i] >= (unsigned)a->n_in) return refuse(a, function, "not an input");
        if (!isfinite(value[i])) return refuse(a, function, "expected a finite number");
        if (a->in[vr[i]] != value[i]) a->stale = 1, a->jumped |= a->state == EVENT;
        a->in[vr[i]] = value[i];
    }
    return STATUS_OK;
}

static int get_orders(Instance *a, const char *function, const uint32_t vr[], size_t n, int32_t value[])
{
    for (size_t i = 0; i < n; i++) {
        unsigned k = vr[i] - (unsigned)(a->n_in + a->n_out);
        if (k >= N_PARAMETER) return refuse(a, function, "no such value reference");
        value[i] = a->parameter[k];
    }
    return STATUS_OK;
}

static int set_orders(Instance *a, const char *function, const uint32_t vr[], size_t n,
                      const int32_t value[])
{
    for (size_t i = 0; i < n; i++) {
        unsigned k = vr[i] - (unsigned)(a->n_in + a->n_out);
        if (k >= N_PARAMETER) return refuse(a, function, "no such value reference");
        if (a->state != INSTANTIATED && a->state != INITIALIZING)
            return refuse(a, function, "parameters are fixed after the initialization");
        if (value[i] < 0 || value[i] > 2)
            return refuse(a, function, "an order of polynomials: expected 0, 1 or 2");
        a->parameter[k] = value[i], a->stale = 1;
    }
    return STATUS_OK;
}

/* ---------------------------------------------------------------- steps, states, derivatives */

/* Move on by h, or to the first event before, which `early` reports. */
static int move(Instance *a, const char *function, double t, double h, int *early)
{
    double *found = 0;
    *early = 0;
    if (a->state != STEPPING) return refuse(a, function, "called out of turn");
    if (!(h > 0.0) || !isfinite(h)) return refuse(a, function, "step size: expected above 0 s");
    if (!(fabs(t - a->t) <= NEAR * (h + fabs(t)))) /* nan: the solver would never end */
        return refuse(a, function, "expected to go on from where the last step has ended");
    double to[2] = {t + h - a->t0, (a->stops ? TO_EVENT : 0) + (a->jumped ? JUMPED : 0)};
    if (!request(a, STEP, to, 2, a->n_in, 2 * a->n_in)) return lost(a);
    forget_derivatives(a);
    int status = answer(a, &found, a->n_out + 2);
    if (status <= STATUS_WARNING) {
        *early = found[1] != 0.0;
        a->t = *early ? a->t0 + found[0] : t + h;
        memcpy(a->out, found + 2, (size_t)a->n_out * sizeof(double));
    }
    free(found);
    forget_rates(a);
    a->stale = a->jumped = 0;
    return status;
}

static int save(Instance *a, const char *function, void **state)
{
    Saved *s = *state;
    size_t count = (size_t)(3 * a->n_in + a->n_out);
    double *number = 0, old = s ? s->number : 0.0; /* 0: a new one */
    if (a->state == FAILED) return refuse(a, function, "the run has failed");
    if (!request(a, SAVE, &old, 1, 0, 0)) return lost(a);
    int status = answer(a, &number, 1);
    if (status <= STATUS_WARNING && !s) s = calloc(1, sizeof *s + (count + 1) * sizeof(double));
    if (status <= STATUS_WARNING && s) {
        s->number = *number, s->t0 = a->t0, s->t = a->t, s->state = a->state;
        s->stale = a->stale, s->jumped = a->jumped;
        memcpy(s->parameter, a->parameter, sizeof s->parameter);
        memcpy(s->numbers, a->in, (size_t)a->n_in * sizeof(double));
        memcpy(s->numbers + a->n_in, a->rates, 2 * (size_t)a->n_in * sizeof(double));
        memcpy(s->numbers + 3 * a->n_in, a->out, (size_t)a->n_out * sizeof(double));
        *state = s;
    }
    free(number);
    return status;
}

static int restore(Instance *a, const char *function, void *state)
{
    Saved *s = state;
    if (!s) return refuse(a, function, "expected a state");
    if (!request(a, RESTORE, &s->number, 1, 0, 0)) return lost(a);
    double none, *nothing = &none;
    int status = answer(a, &nothing, 0);
    if (status > STATUS_WARNING) return status;
    a->t0 = s->t0, a->t = s->t, a->state = s->state;
    a->stale = s->stale, a->jumped = s->jumped;
    memcpy(a->parameter, s->parameter, sizeof s->parameter);
    memcpy(a->in, s->numbers, (size_t)a->n_in * sizeof(double));
    memcpy(a->rates, s->numbers + a->n_in, 2 * (size_t)a->n_in * sizeof(double));
    memcpy(a->out, s->numbers + 3 * a->n_in, (size_t)a->n_out * sizeof(double));
    forget_derivatives(a);
    return status;
}

static int forget(Instance *a, void **state)
{
    Saved *s = state ? *state : 0;
    if (!s) return STATUS_OK;
    double none, *nothing = &none, number = s->number;
    free(s), *state = 0;
    if (!request(a, FORGET, &number, 1, 0, 0)) return lost(a);
    return answer(a, &nothing, 0);
}

/* Outputs at the end of the last step by its inputs, along a seed of these or, adjoint, of those. */
static int derive(Instance *a, const char *function, const uint32_t unknown[], size_t n_unknown,
                  const uint32_t known[], size_t n_known, const double seed[], double out[],
                  int adjoint)
{
    for (size_t i = 0; i < n_unknown; i++)
        if (unknown[i] - (unsigned)a->n_in >= (unsigned)a->n_out)
            return refuse(a, function, "unknowns: expected outputs");
    for (size_t k = 0; k < n_known; k++)
        if (known[k] >= (unsigned)a->n_in) return refuse(a, function, "knowns: expected inputs");
    if (!a->rows) {
        int state = a->state;
        if (!request(a, DERIVE, 0, 0, 0, 0)) return lost(a);
        int status = answer(a, &a->rows, a->n_in * a->n_out);
        if (status > STATUS_WARNING) {        /* refused: the run can go on */
            a->state = state;
            return status;
        }
    }
    for (size_t i = 0; i < (adjoint ? n_known : n_unknown); i++) out[i] = 0.0;
    for (size_t i = 0; i < n_unknown; i++)
        for (size_t k = 0; k < n_known; k++) {
            size_t row = unknown[i] - (unsigned)a->n_in;
            double by = a->rows[row * (size_t)a->n_in + known[k]];
            if (adjoint) out[k] += by * seed[i];
            else out[i] += by * seed[k];
        }
    return STATUS_OK;
}
