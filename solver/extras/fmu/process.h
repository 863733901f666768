/* Instances of an FMU, and the process of the solver that each one has (library.c).

   The declarations of fmi2Functions.h that are needed are repeated here, so that nothing but a C
   compiler is. With FMI2_HEADERS that file is included instead, which checks them. */

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
#define FMI_FALSE 0
#ifdef FMI2_HEADERS
#include "fmi2Functions.h"
#define EXPORT FMI2_Export
#else
#define EXPORT __attribute__((visibility("default")))
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

#ifdef __APPLE__
#include <crt_externs.h>
#define environ (*_NSGetEnviron())
#else
extern char **environ;
#endif

enum { START = 1, STEP = 2 };                 /* requests */
enum { DRIVE_ORDER, FORCE_ORDER, N_PARAMETER };
enum { INSTANTIATED, INITIALIZING, STEPPING, ENDED, FAILED };
enum { MOST_TEXT = 1 << 20, MOST_NUMBERS = 1 << 24 };
#define NEAR 1e-9                             /* communication steps by which times may differ */

typedef struct {
    const fmi2CallbackFunctions *call;
    char *name;
    int state, stale;                         /* stale: outputs are not those of the inputs */
    int socket;
    pid_t process;
    int n_in, n_out;
    double *start, *in, *rates, *out;         /* (n_in), (n_in), (n_in, 2), (n_out) */
    fmi2Integer parameter[N_PARAMETER];
    double t0, t;
} Instance;

static const fmi2Integer usual[N_PARAMETER] = {2, 1};

/* The text goes as the format, because some programs show that alone: % is doubled. */
static fmi2Status tell(Instance *a, fmi2Status status, const char *text)
{
    char *format = calloc(2 * strlen(text) + 1, 1), *to = format;
    if (format && a->call && a->call->logger) {
        const char *category = status == fmi2Warning ? "logStatusWarning" : "logStatusError";
        for (; *text; text++) {
            if (*text == '%') *to++ = '%';
            *to++ = *text;
        }
        a->call->logger(a->call->componentEnvironment, a->name, status, category, format);
    }
    free(format);
    return status;
}

static fmi2Status refuse(Instance *a, const char *function, const char *why)
{
    char text[256];
    snprintf(text, sizeof text, "%s: %s", function, why);
    return tell(a, fmi2Error, text);
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

static fmi2Status lost(Instance *a)
{
    a->state = FAILED;
    return tell(a, fmi2Error, "the process of the solver has ended");
}

/* Take one answer: status, length of a text, count of numbers; numbers go to *into, made if null. */
static fmi2Status answer(Instance *a, double **into, int expected)
{
    int32_t head[3];
    fmi2Status status;
    if (!transfer(a, (char *)head, sizeof head, 0)) return lost(a);
    if (head[1] < 0 || head[1] > MOST_TEXT || head[2] < 0 || head[2] > MOST_NUMBERS) return lost(a);
    status = (fmi2Status)head[0];
    if (head[1] > 0) {
        char *text = calloc((size_t)head[1] + 1, 1);
        if (!text || !transfer(a, text, (size_t)head[1], 0)) { free(text); return lost(a); }
        tell(a, status, text);
        free(text);
    }
    if (status > fmi2Warning) {
        a->state = FAILED;
        return status;
    }
    if (expected >= 0 && head[2] != expected) return lost(a);
    if (!*into) *into = calloc((size_t)head[2] + 1, sizeof(double));
    if (!*into || !transfer(a, (char *)*into, (size_t)head[2] * sizeof(double), 0)) return lost(a);
    return status;
}

static int request(Instance *a, int what, const double *first, int n_first, int with_rates)
{
    int n_rates = with_rates ? 2 * a->n_in : 0;
    int32_t head[2] = {what, n_first + a->n_in + n_rates};
    return transfer(a, (char *)head, sizeof head, 1)
        && transfer(a, (char *)first, (size_t)n_first * sizeof(double), 1)
        && transfer(a, (char *)a->in, (size_t)a->n_in * sizeof(double), 1)
        && transfer(a, (char *)a->rates, (size_t)n_rates * sizeof(double), 1);
}

/* Close the joints with the present inputs. */
static fmi2Status begin(Instance *a)
{
    double first[N_PARAMETER];
    for (int i = 0; i < N_PARAMETER; i++) first[i] = a->parameter[i];
    if (!request(a, START, first, N_PARAMETER, 0)) return lost(a);
    a->stale = 0;
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
                       "from plymotion.solver.extras.fmu.server import main\n"
                       "sys.exit(main(sys.argv[2]))\n";
    int ends[2];
    if (!read_solver(folder, python, home, sizeof python)) {
        refuse(a, "fmi2Instantiate", "resources/solver.txt cannot be read");
        return 0;
    }
    if (socketpair(AF_UNIX, SOCK_STREAM, 0, ends)) {
        refuse(a, "fmi2Instantiate", "no socket");
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
        tell(a, fmi2Error, text);
    }
    return !failed;
}

static void release(Instance *a)
{
    if (a->socket >= 0) close(a->socket);     /* the process ends by itself */
    if (a->process > 0)
        while (waitpid(a->process, 0, 0) < 0 && errno == EINTR) {}
    free(a->start), free(a->in), free(a->rates), free(a->out), free(a->name), free(a);
}
