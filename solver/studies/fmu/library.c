/* The library of an FMU, for co-simulation by FMI 2.0 and 3.0: it starts the solver as a process of
   its own and exchanges numbers with it over a socket (server.py has the other end).

   Inputs, parameters and outputs are kept here. The solver hears of them at the start and with each
   communication step, and answers with all outputs at its end. POSIX only. */

#define EXPORT __attribute__((visibility("default")))

#include "process.h"

#include "fmi2.h"

#include "fmi3.h"
