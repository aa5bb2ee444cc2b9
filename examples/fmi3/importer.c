/* An importer for FMI 3.0 in C: event mode, early return, intermediate updates, rollback.
 *
 *     cc -std=c11 -I HEADERS -o importer importer.c -ldl -lm
 *     ./importer binaries/x86_64-linux/PushbeltVariator.so TOKEN
 *
 * HEADERS is a folder with the standard's fmi3Functions.h and what it includes (fmpy has them in fmpy/c-code); TOKEN is the
 * instantiationToken of modelDescription.xml. The program runs a coarse belt into an over-torque, answers the event, goes back and
 * does it again, and prints what it saw. Returns 0 if all was as it should be.
 */
#include <dlfcn.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "fmi3Functions.h"

/* Value references, from modelDescription.xml. */
enum { PRIMARY_TORQUE = 101, PRIMARY_SPEED = 111, THRUST_RATIO = 1, MACRO_SLIP = 10, PUSH_FORCE = 10101, RING_MODEL = 1001 };
enum { PLACES = 72 };

static void *library;

#define CALL(name) ((name##TYPE *)find(#name))

static void *find(const char *name) {
    void *function = dlsym(library, name);
    if (!function) {
        fprintf(stderr, "%s is missing\n", name);
        exit(1);
    }
    return function;
}

static void check(fmi3Status status, const char *what) {
    if (status != fmi3OK) {
        fprintf(stderr, "%s: status %d\n", what, status);
        exit(1);
    }
}

static void expect(int holds, const char *what) {
    if (!holds) {
        fprintf(stderr, "expected: %s\n", what);
        exit(1);
    }
}

/* What the callbacks get: the instance, and what they have counted. */
typedef struct {
    fmi3Instance instance;
    int messages, updates;
    double last;
} Run;

static void log_message(fmi3InstanceEnvironment environment, fmi3Status status, fmi3String category, fmi3String message) {
    (void)status;
    ((Run *)environment)->messages++;
    printf("  [%s] %s\n", category, message);
}

static void update(fmi3InstanceEnvironment environment, fmi3Float64 time, fmi3Boolean set, fmi3Boolean get, fmi3Boolean finished,
                   fmi3Boolean can_return, fmi3Boolean *wanted, fmi3Float64 *until) {
    Run *run = environment;
    const fmi3ValueReference speed = PRIMARY_SPEED;
    double value = NAN;
    (void)set, (void)finished, (void)can_return, (void)until;
    expect(get && time > run->last, "times rise, and values can be read");
    check(CALL(fmi3GetFloat64)(run->instance, &speed, 1, &value, 1), "reading in intermediate update mode");
    expect(isfinite(value), "a finite speed");
    run->updates++;
    run->last = time;
    *wanted = fmi3False;
}

static double real(fmi3Instance instance, fmi3ValueReference reference) {
    double value = NAN;
    check(CALL(fmi3GetFloat64)(instance, &reference, 1, &value, 1), "fmi3GetFloat64");
    return value;
}

static void set_real(fmi3Instance instance, fmi3ValueReference reference, double value) {
    check(CALL(fmi3SetFloat64)(instance, &reference, 1, &value, 1), "fmi3SetFloat64");
}

/* Through event mode, which the instance is in. */
static void handle(fmi3Instance instance) {
    fmi3Boolean again = fmi3True, terminate, nominals, values, defined;
    fmi3Float64 next;
    while (again) {
        check(CALL(fmi3UpdateDiscreteStates)(instance, &again, &terminate, &nominals, &values, &defined, &next),
              "fmi3UpdateDiscreteStates");
    }
    check(CALL(fmi3EnterStepMode)(instance), "fmi3EnterStepMode");
}

/* Steps of 1 ms up to an event or 0.1 s; the time reached, and whether there was an event. */
static double to_event(Run *run, double time, fmi3Boolean *event) {
    *event = fmi3False;
    while (time < 0.1 && !*event) {
        fmi3Boolean terminate, early;
        double reached;
        run->last = time;
        check(CALL(fmi3DoStep)(run->instance, time, 1e-3, fmi3False, event, &terminate, &early, &reached), "fmi3DoStep");
        expect(early == (reached < time + 1e-3 - 1e-12), "an early return ends earlier");
        time = reached;
    }
    return time;
}

int main(int argc, char **argv) {
    if (argc != 3) {
        fprintf(stderr, "usage: importer LIBRARY TOKEN\n");
        return 2;
    }
    library = dlopen(argv[1], RTLD_NOW | RTLD_LOCAL);
    if (!library) {
        fprintf(stderr, "%s\n", dlerror());
        return 1;
    }
    expect(strcmp(CALL(fmi3GetVersion)(), "3.0") == 0, "version 3.0");
    Run run = {0};
    const fmi3ValueReference watched = PRIMARY_SPEED;
    run.instance = CALL(fmi3InstantiateCoSimulation)("variator", argv[2], NULL, fmi3False, fmi3True, fmi3True, fmi3True, &watched, 1,
                                                     &run, log_message, update);
    expect(run.instance != NULL, "an instance");
    fmi3Instance c = run.instance;

    /* A coarse ring: this is about the interface. */
    const fmi3ValueReference model = RING_MODEL;
    const fmi3Int64 ale0 = 1;
    check(CALL(fmi3SetInt64)(c, &model, 1, &ale0, 1), "fmi3SetInt64");
    check(CALL(fmi3EnterInitializationMode)(c, fmi3False, 0, 0, fmi3False, 0), "fmi3EnterInitializationMode");
    printf("thrust ratio at the start: %.3f\n", real(c, THRUST_RATIO));
    check(CALL(fmi3ExitInitializationMode)(c), "fmi3ExitInitializationMode");
    handle(c);

    fmi3Boolean event;
    set_real(c, PRIMARY_TORQUE, 400);
    fmi3FMUState state = NULL;
    check(CALL(fmi3GetFMUState)(c, &state), "fmi3GetFMUState");
    double first = to_event(&run, 0, &event);
    expect(event, "the belt slips through");
    double speed = real(c, PRIMARY_SPEED);

    /* Back, by way of bytes, and the same again. */
    size_t size = 0;
    check(CALL(fmi3SerializedFMUStateSize)(c, state, &size), "fmi3SerializedFMUStateSize");
    fmi3Byte *bytes = malloc(size);
    check(CALL(fmi3SerializeFMUState)(c, state, bytes, size), "fmi3SerializeFMUState");
    check(CALL(fmi3FreeFMUState)(c, &state), "fmi3FreeFMUState");
    check(CALL(fmi3DeserializeFMUState)(c, bytes, size, &state), "fmi3DeserializeFMUState");
    free(bytes);
    check(CALL(fmi3SetFMUState)(c, state), "fmi3SetFMUState");
    check(CALL(fmi3FreeFMUState)(c, &state), "fmi3FreeFMUState");
    double again = to_event(&run, 0, &event);
    expect(event && again == first && real(c, PRIMARY_SPEED) == speed, "the same event after a rollback");

    /* The answer. */
    check(CALL(fmi3EnterEventMode)(c), "fmi3EnterEventMode");
    fmi3ValueReference slip = MACRO_SLIP;
    fmi3Boolean slips = fmi3False;
    check(CALL(fmi3GetBoolean)(c, &slip, 1, &slips, 1), "fmi3GetBoolean");
    expect(slips, "macro-slip");
    set_real(c, PRIMARY_TORQUE, 20);
    handle(c);
    double grips = to_event(&run, again, &event);

    double forces[PLACES];
    const fmi3ValueReference profile = PUSH_FORCE;
    check(CALL(fmi3GetFloat64)(c, &profile, 1, forces, PLACES), "an array");
    double most = 0;
    for (int k = 0; k < PLACES; k++) {
        most = fmax(most, forces[k]);
    }
    printf("slips at %.6f s, event %s at %.6f s, push force up to %.0f N, %d own steps, %d messages\n", first,
           event ? "again" : "not again", grips, most, run.updates, run.messages);
    check(CALL(fmi3Terminate)(c), "fmi3Terminate");
    CALL(fmi3FreeInstance)(c);
    dlclose(library);
    return 0;
}
