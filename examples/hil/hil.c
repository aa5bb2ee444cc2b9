/* The FMU's shared library in the loop: one fmi2DoStep each millisecond against the clock, as a rig does it.
 *
 *   cc -O2 -Iinclude -o hil hil.c -ldl -lm && ./hil LIBRARY GUID [--seconds S] [--ring 1|2] [--cells N] [--effort N]
 *     [--ratio R] [--load NAME] [--free]
 *
 * docs/levels.md has the whole of it. --free runs without waiting for the clock. The program asks for SCHED_FIFO and says
 * whether it got it. It prints the histogram of step times, the misses (steps that ended after their millisecond), the
 * largest defect that the unit reports, how many steps were begun again, and how far it was behind. Needs Linux and a C11
 * compiler; it has its own declarations of the few fmi2 functions it calls.
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
    fmi2Status (*GetInteger)(fmi2Component, const fmi2ValueReference *, size_t, int *);
    fmi2Status (*DoStep)(fmi2Component, double, double, int);
    fmi2Status (*Terminate)(fmi2Component);
    void (*FreeInstance)(fmi2Component);
} fmi2;

/* Value references: docs/variables.md. */
enum { TORQUE_P = 101, FORCE_P = 102, TORQUE_S = 201, FORCE_S = 202 };
enum { RING_MODEL = 1001, CELLS = 1074, MODE = 1084, EFFORT = 1086, RATIO_0 = 1011, SPEED_0 = 1012, INERTIA_S = 233 };
enum { DEFECT = 30, BEHIND = 31, ROLLBACKS = 32, SPEED_P = 111, SPEED_S = 211, RATIO = 5 };

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

/* A load: its name, the torque on the primary shaft in the mean, N m, and the speed of that shaft at the start, rad/s. */
typedef struct {
    const char *name;
    double torque, speed;
} Load;

/* The loads of `cargo fmu bench --loads`, in the order of their letters. */
static const Load LOADS[] = {{"smooth", 50, 210},  {"firing", 80, 210}, {"ripple", 50, 210}, {"noise", 50, 210},
                             {"slam", 50, 210},    {"launch", 0, 0},    {"flips", 0, 210},   {"stairs", 50, 210},
                             {"firing-and-noise", 20, 210}, {"hunting", 0, 20}};

/* Clamping forces that the load moves, N, and the gains of the controllers: of the ratio, N and N/s, and of the vehicle's speed. */
static const double FORCE = 12000.0, HIGHEST = 6000.0, PROPORTIONAL = 2e4, INTEGRAL = 1e4, OF_SPEED = 2.0, INERTIA = 4.0;

/* What the unit said last, and what the controller of the ratio remembers. */
typedef struct {
    double speed_p, speed_s, ratio, defect, behind, integral;
} Seen;

static int is(const Load *load, const char *name) { return !strcmp(load->name, name); }

/* The four inputs at a step, in the order of their value references above: the load on the primary shaft, a vehicle that is held
 * at its speed on the secondary one, and a controller that holds the ratio by the primary force. */
static void inputs_of(const Load *load, double wanted, long step, Seen *seen, double *inputs) {
    double time = (double)step * STEP, pi = 3.14159265358979;
    double firing = 30.0 * sin(2.0 * pi * 70.0 * time), cruise = load->speed / wanted;
    double torque = load->torque, vehicle = -load->torque * wanted - OF_SPEED * (seen->speed_s - cruise);
    if (is(load, "smooth")) torque += 30.0 * sin(2.0 * pi * 0.2 * time), vehicle -= (torque - load->torque) * wanted;
    if (is(load, "firing") || is(load, "firing-and-noise")) torque += firing;
    if (is(load, "slam") && fmod(time, 1.0) < 0.15) torque = 150.0;
    if (is(load, "launch")) torque = 60.0 * fmin(time, 1.0) * tanh((150.0 - seen->speed_p) / 10.0), vehicle = -5.0;
    if (is(load, "flips")) torque = (step / 10) % 2 ? -50.0 : 50.0;
    if (is(load, "hunting")) torque = seen->speed_p < 22.0 ? 60.0 : -60.0;

    double error = seen->ratio - wanted;
    seen->integral += STEP * error;
    double control = fmax(-HIGHEST, fmin(HIGHEST, PROPORTIONAL * error + INTEGRAL * seen->integral));
    double forces[2] = {FORCE + control, FORCE};
    for (int k = 0; k < 2; k++) {
        if (is(load, "ripple")) forces[k] *= 1.0 + 0.05 * sin(2.0 * pi * 100.0 * time);
        if (is(load, "noise") || is(load, "firing-and-noise")) forces[k] += 30.0 * noise();
        if (is(load, "stairs")) forces[k] = 200.0 * round((forces[k] + 150.0 * noise()) / 200.0);
    }
    inputs[0] = torque;
    inputs[1] = forces[0];
    inputs[2] = vehicle;
    inputs[3] = forces[1];
}

int main(int count, char **arguments) {
    double seconds = 5.0, wanted = 1.0;
    int ring = 2, cells = 1, effort = 4, waits = 1;
    const char *only = NULL;
    if (count < 3) {
        fprintf(stderr, "usage: %s LIBRARY GUID [--seconds S] [--ring 1|2] [--cells N] [--effort N] [--ratio R] [--load NAME] [--free]\n", arguments[0]);
        return 2;
    }
    for (int i = 3; i < count; i++) {
        const char *value = i + 1 < count ? arguments[i + 1] : "";
        if (!strcmp(arguments[i], "--free")) waits = 0;
        else if (!strcmp(arguments[i], "--seconds")) seconds = atof(value), i++;
        else if (!strcmp(arguments[i], "--ring")) ring = atoi(value), i++;
        else if (!strcmp(arguments[i], "--cells")) cells = atoi(value), i++;
        else if (!strcmp(arguments[i], "--effort")) effort = atoi(value), i++;
        else if (!strcmp(arguments[i], "--ratio")) wanted = atof(value), i++;
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
    BIND(SetReal); BIND(SetInteger); BIND(GetReal); BIND(GetInteger); BIND(DoStep); BIND(Terminate); BIND(FreeInstance);

    struct sched_param priority = {.sched_priority = 80};
    int fifo = waits && !sched_setscheduler(0, SCHED_FIFO, &priority);
    int locked = waits && !mlockall(MCL_CURRENT | MCL_FUTURE);
    printf("SCHED_FIFO: %s; memory locked: %s\n", fifo ? "yes" : "no", locked ? "yes" : "no");

    long missed_in_all = 0;
    int known = 0;
    for (const Load *load = LOADS; load < LOADS + sizeof LOADS / sizeof *LOADS; load++) {
        if (only && !is(load, only)) continue;
        known = 1;
        fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
        fmi2Component unit = fmi2.Instantiate("variator", 1, arguments[2], "file:///", &callbacks, 0, 0);
        if (!unit) return 1;
        const fmi2ValueReference choices[] = {RING_MODEL, CELLS, MODE, EFFORT}, start[] = {RATIO_0, SPEED_0, INERTIA_S};
        const fmi2ValueReference inputs[] = {TORQUE_P, FORCE_P, TORQUE_S, FORCE_S};
        const int chosen[] = {ring, cells, 2, effort};
        const double begun[] = {wanted, load->speed, INERTIA};
        double values[4];
        Seen seen = {load->speed, load->speed / wanted, wanted, 0.0, 0.0, 0.0};
        check(fmi2.SetupExperiment(unit, 0, 0.0, 0.0, 0, 0.0), "fmi2SetupExperiment");
        check(fmi2.SetInteger(unit, choices, 4, chosen), "fmi2SetInteger");
        check(fmi2.SetReal(unit, start, 3, begun), "fmi2SetReal");
        inputs_of(load, wanted, 0, &seen, values);
        check(fmi2.SetReal(unit, inputs, 4, values), "fmi2SetReal");
        check(fmi2.EnterInitializationMode(unit), "fmi2EnterInitializationMode");
        check(fmi2.ExitInitializationMode(unit), "fmi2ExitInitializationMode");

        long steps = (long)(seconds / STEP), misses = 0, late = 0, histogram[BINS] = {0};
        double longest = 0.0, sum = 0.0, worst = 0.0, latest = 0.0, begin = now() + 0.01;
        for (long k = 0; k < steps; k++) {
            double due = begin + (double)k * STEP;
            if (waits) wait_until(due);
            double from = now();
            inputs_of(load, wanted, k, &seen, values);
            check(fmi2.SetReal(unit, inputs, 4, values), "fmi2SetReal");
            check(fmi2.DoStep(unit, (double)k * STEP, STEP, 1), "fmi2DoStep");
            const fmi2ValueReference outputs[] = {SPEED_P, SPEED_S, RATIO, DEFECT, BEHIND};
            double read[5];
            check(fmi2.GetReal(unit, outputs, 5, read), "fmi2GetReal");
            seen.speed_p = read[0], seen.speed_s = read[1], seen.ratio = read[2], seen.defect = read[3], seen.behind = read[4];
            double to = now(), took = to - from;
            if (waits && to > due + STEP) misses++;
            if (seen.defect > worst) worst = seen.defect;
            if (seen.behind > latest) latest = seen.behind;
            if (seen.behind > 1e-9) late++;
            sum += took;
            if (took > longest) longest = took;
            int bin = 0;
            while (took * 1e3 > EDGES_MS[bin]) bin++;
            histogram[bin]++;
        }
        const fmi2ValueReference count[] = {ROLLBACKS};
        int rollbacks = 0;
        check(fmi2.GetInteger(unit, count, 1, &rollbacks), "fmi2GetInteger");
        printf("%s: mean %.3f ms, longest %.3f ms, %ld misses of %ld, largest defect %.1e, %d steps begun again, "
               "%ld steps behind, by %.1f ms at most\n",
               load->name, 1e3 * sum / (double)steps, 1e3 * longest, misses, steps, worst, rollbacks, late, 1e3 * latest);
        for (int bin = 0; bin < BINS; bin++)
            if (histogram[bin]) printf("  up to %5.2f ms: %ld\n", EDGES_MS[bin], histogram[bin]);
        missed_in_all += misses;
        fmi2.Terminate(unit);
        fmi2.FreeInstance(unit);
    }
    printf("%ld misses in all\n", missed_in_all);
    dlclose(library);
    if (!known) fprintf(stderr, "no load is called %s\n", only);
    return !known;
}
