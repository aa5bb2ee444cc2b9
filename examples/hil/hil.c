/* The FMU's shared library in the loop: one fmi2DoStep each millisecond against the clock, as a rig does it.
 *
 *   cc -O2 -Iinclude -o hil hil.c -ldl -lm && ./hil LIBRARY GUID [--seconds S] [--ring 1|2] [--cells N] [--load NAME] [--free]
 *
 * docs/real-time.md has the whole of it. --free runs without waiting for the clock. The program asks for SCHED_FIFO and says
 * whether it got it. It prints the histogram of step times, the misses (steps that ended after their millisecond) and the
 * defect that the unit reports. Needs Linux and a C11 compiler; it has its own declarations of the few fmi2 functions it calls.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>
#include <sched.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <time.h>

typedef void *fmi2Component;
typedef unsigned int fmi2ValueReference;
typedef int fmi2Status;

typedef struct {
    void (*logger)(void *, const char *, fmi2Status, const char *, const char *, ...);
    void *(*allocateMemory)(size_t, size_t);
    void (*freeMemory)(void *);
    void (*stepFinished)(void *, fmi2Status);
    void *componentEnvironment;
} fmi2CallbackFunctions;

static struct {
    fmi2Component (*Instantiate)(const char *, int, const char *, const char *, const fmi2CallbackFunctions *, int, int);
    fmi2Status (*SetupExperiment)(fmi2Component, int, double, double, int, double);
    fmi2Status (*EnterInitializationMode)(fmi2Component);
    fmi2Status (*ExitInitializationMode)(fmi2Component);
    fmi2Status (*SetReal)(fmi2Component, const fmi2ValueReference *, size_t, const double *);
    fmi2Status (*SetInteger)(fmi2Component, const fmi2ValueReference *, size_t, const int *);
    fmi2Status (*GetReal)(fmi2Component, const fmi2ValueReference *, size_t, double *);
    fmi2Status (*DoStep)(fmi2Component, double, double, int);
    fmi2Status (*Terminate)(fmi2Component);
    void (*FreeInstance)(fmi2Component);
} fmi2;

/* Value references: docs/variables.md. */
enum { TORQUE_P = 101, FORCE_P = 102, TORQUE_S = 201, FORCE_S = 202 };
enum { RING_MODEL = 1001, CELLS = 1074, MODE = 1084, SPEED_0 = 1012, DEFECT = 30, SPEED_P = 111, SPEED_S = 211, RATIO = 5 };

#define STEP 1e-3
#define BINS 12
static const double EDGES_MS[BINS] = {0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.5, 0.7, 1.0, 2.0, 5.0, INFINITY};

static void log_message(void *environment, const char *name, fmi2Status status, const char *category, const char *message, ...) {
    va_list arguments;
    (void)environment;
    fprintf(stderr, "%s [%d, %s]: ", name, status, category);
    va_start(arguments, message);
    vfprintf(stderr, message, arguments);
    va_end(arguments);
    fputc('\n', stderr);
}

static void check(fmi2Status status, const char *what) {
    if (status > 1) {
        fprintf(stderr, "%s failed with status %d\n", what, status);
        exit(1);
    }
}

static void *symbol(void *library, const char *name) {
    void *found = dlsym(library, name);
    if (!found) {
        fprintf(stderr, "the library has no function %s\n", name);
        exit(1);
    }
    return found;
}

static double now(void) {
    struct timespec time;
    clock_gettime(CLOCK_MONOTONIC, &time);
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void wait_until(double when) {
    struct timespec time = {(time_t)when, (long)((when - floor(when)) * 1e9)};
    while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &time, NULL)) {
    }
}

/* White noise of unit variance, the same in each run. */
static double noise(void) {
    static unsigned int seed = 1;
    double sum = 0.0;
    for (int i = 0; i < 12; i++) {
        seed = 1664525u * seed + 1013904223u;
        sum += (double)(seed >> 8) / 16777216.0;
    }
    return sum - 6.0;
}

/* Loads on the four inputs at a step, in the order of their value references above. */
static void load(const char *name, long step, double *inputs) {
    double time = (double)step * STEP, pi = 3.14159265358979;
    double torque = 50.0, forces = 1.0, rough = 0.0;
    if (!strcmp(name, "firing")) torque = 80.0 + 30.0 * sin(2.0 * pi * 70.0 * time);
    if (!strcmp(name, "ripple")) forces = 1.0 + 0.05 * sin(2.0 * pi * 100.0 * time);
    if (!strcmp(name, "noise")) rough = 30.0;
    if (!strcmp(name, "slam")) torque = fmod(time, 1.0) < 0.15 ? 150.0 : 50.0;
    if (!strcmp(name, "flips")) torque = (step / 10) % 2 ? -50.0 : 50.0;
    inputs[0] = torque;
    inputs[1] = 13000.0 * forces + rough * noise();
    inputs[2] = -49.0;
    inputs[3] = 10000.0 * forces + rough * noise();
    if (!strcmp(name, "flips")) inputs[2] = 0.0;
}

int main(int count, char **arguments) {
    double seconds = 5.0;
    int ring = 2, cells = 1, waits = 1;
    const char *loads[] = {"smooth", "firing", "ripple", "noise", "slam", "flips"};
    const char *only = NULL;
    if (count < 3) {
        fprintf(stderr, "usage: %s LIBRARY GUID [--seconds S] [--ring 1|2] [--cells N] [--load NAME] [--free]\n", arguments[0]);
        return 2;
    }
    for (int i = 3; i < count; i++) {
        const char *value = i + 1 < count ? arguments[i + 1] : "";
        if (!strcmp(arguments[i], "--free")) waits = 0;
        else if (!strcmp(arguments[i], "--seconds")) seconds = atof(value), i++;
        else if (!strcmp(arguments[i], "--ring")) ring = atoi(value), i++;
        else if (!strcmp(arguments[i], "--cells")) cells = atoi(value), i++;
        else if (!strcmp(arguments[i], "--load")) only = value, i++;
        else {
            fprintf(stderr, "unknown option %s\n", arguments[i]);
            return 2;
        }
    }
    void *library = dlopen(arguments[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
#define BIND(name) *(void **)&fmi2.name = symbol(library, "fmi2" #name)
    BIND(Instantiate); BIND(SetupExperiment); BIND(EnterInitializationMode); BIND(ExitInitializationMode);
    BIND(SetReal); BIND(SetInteger); BIND(GetReal); BIND(DoStep); BIND(Terminate); BIND(FreeInstance);

    struct sched_param priority = {.sched_priority = 80};
    int fifo = waits && !sched_setscheduler(0, SCHED_FIFO, &priority);
    int locked = waits && !mlockall(MCL_CURRENT | MCL_FUTURE);
    printf("SCHED_FIFO: %s; memory locked: %s\n", fifo ? "yes" : "no", locked ? "yes" : "no");

    long missed_in_all = 0;
    for (size_t which = 0; which < sizeof loads / sizeof *loads; which++) {
        if (only && strcmp(only, loads[which])) continue;
        fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
        fmi2Component unit = fmi2.Instantiate("variator", 1, arguments[2], "file:///", &callbacks, 0, 0);
        if (!unit) return 1;
        const fmi2ValueReference choices[] = {RING_MODEL, CELLS, MODE}, inputs[] = {TORQUE_P, FORCE_P, TORQUE_S, FORCE_S};
        const int chosen[] = {ring, cells, 2};
        double values[4];
        check(fmi2.SetupExperiment(unit, 0, 0.0, 0.0, 0, 0.0), "fmi2SetupExperiment");
        check(fmi2.SetInteger(unit, choices, 3, chosen), "fmi2SetInteger");
        load(loads[which], 0, values);
        check(fmi2.SetReal(unit, inputs, 4, values), "fmi2SetReal");
        check(fmi2.EnterInitializationMode(unit), "fmi2EnterInitializationMode");
        check(fmi2.ExitInitializationMode(unit), "fmi2ExitInitializationMode");

        long steps = (long)(seconds / STEP), misses = 0, histogram[BINS] = {0};
        double longest = 0.0, sum = 0.0, worst = 0.0, begin = now() + 0.01;
        for (long k = 0; k < steps; k++) {
            double due = begin + (double)k * STEP;
            if (waits) wait_until(due);
            double from = now();
            load(loads[which], k, values);
            check(fmi2.SetReal(unit, inputs, 4, values), "fmi2SetReal");
            check(fmi2.DoStep(unit, (double)k * STEP, STEP, 1), "fmi2DoStep");
            const fmi2ValueReference outputs[] = {SPEED_P, SPEED_S, RATIO, DEFECT};
            double read[4];
            check(fmi2.GetReal(unit, outputs, 4, read), "fmi2GetReal");
            double to = now(), took = to - from;
            if (waits && to > due + STEP) misses++;
            if (read[3] > worst) worst = read[3];
            sum += took;
            if (took > longest) longest = took;
            int bin = 0;
            while (took * 1e3 > EDGES_MS[bin]) bin++;
            histogram[bin]++;
        }
        printf("%s: mean %.3f ms, longest %.3f ms, %ld misses of %ld, largest defect %.1e\n", loads[which],
               1e3 * sum / (double)steps, 1e3 * longest, misses, steps, worst);
        for (int bin = 0; bin < BINS; bin++)
            if (histogram[bin]) printf("  up to %5.2f ms: %ld\n", EDGES_MS[bin], histogram[bin]);
        missed_in_all += misses;
        fmi2.Terminate(unit);
        fmi2.FreeInstance(unit);
    }
    printf("%ld misses in all\n", missed_in_all);
    dlclose(library);
    return 0;
}
