/* A program that loads a library of the FMU and calls every function of FMI 2.0 for co-simulation in it. It compiles for Linux and for
 * Windows, so it shows that a library works on its platform, and that other platforms can read its stored states.
 *
 *     host LIBRARY GUID REFERENCES -        STATE_OUT READINGS    a run of 20 ms, its state, and 20 ms more
 *     host LIBRARY GUID REFERENCES STATE_IN STATE_OUT READINGS    the 20 ms from a stored state on
 *     host LIBRARY GUID REFERENCES RUN READINGS                   the calls in the file RUN, a line each:
 *
 *     integer REFERENCE VALUE, real REFERENCE VALUE, start, step TIME LENGTH, read
 *
 * REFERENCES contains value references of real variables. READINGS gets their values at each stop, as the bits of doubles in hexadecimal.
 * The program ends with 1 at the first call with an unexpected result, and prints the call. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef _WIN32
#include <windows.h>
static void *load(const char *path) { return (void *)LoadLibraryA(path); }
static void *find(void *library, const char *name) { return (void *)GetProcAddress((HMODULE)library, name); }
static void unload(void *library) { FreeLibrary((HMODULE)library); }
static unsigned long why(void) { return GetLastError(); }
#else
#include <dlfcn.h>
static void *load(const char *path) { return dlopen(path, RTLD_NOW | RTLD_LOCAL); }
static void *find(void *library, const char *name) { return dlsym(library, name); }
static void unload(void *library) { dlclose(library); }
static unsigned long why(void) { return 0; }
#endif

typedef void *component;
typedef void *state;
typedef void (*logger)(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    logger log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, int);
    void *environment;
} callbacks;

enum { OK, WARNING, DISCARD, ERROR_, FATAL, PENDING };
enum { REAL = 1024 };
/* Of the error control. The test's tolerances follow from it. */
static const double TOLERANCE = 1e-7;

static int calls;

static void check(const char *call, int found, int expected) {
    calls++;
    if (found != expected) {
        fprintf(stderr, "%s: %d instead of %d\n", call, found, expected);
        exit(1);
    }
}

/* FN(result, name, types) declares a function of the library by its name. */
#define FN(result, name, types) static result(*name) types;
FN(const char *, fmi2GetTypesPlatform, (void))
FN(const char *, fmi2GetVersion, (void))
FN(int, fmi2SetDebugLogging, (component, int, size_t, const char *const *))
FN(component, fmi2Instantiate, (const char *, int, const char *, const char *, const callbacks *, int, int))
FN(void, fmi2FreeInstance, (component))
FN(int, fmi2SetupExperiment, (component, int, double, double, int, double))
FN(int, fmi2EnterInitializationMode, (component))
FN(int, fmi2ExitInitializationMode, (component))
FN(int, fmi2Terminate, (component))
FN(int, fmi2Reset, (component))
FN(int, fmi2GetReal, (component, const unsigned *, size_t, double *))
FN(int, fmi2GetInteger, (component, const unsigned *, size_t, int *))
FN(int, fmi2GetBoolean, (component, const unsigned *, size_t, int *))
FN(int, fmi2GetString, (component, const unsigned *, size_t, const char **))
FN(int, fmi2SetReal, (component, const unsigned *, size_t, const double *))
FN(int, fmi2SetInteger, (component, const unsigned *, size_t, const int *))
FN(int, fmi2SetBoolean, (component, const unsigned *, size_t, const int *))
FN(int, fmi2SetString, (component, const unsigned *, size_t, const char *const *))
FN(int, fmi2GetFMUstate, (component, state *))
FN(int, fmi2SetFMUstate, (component, state))
FN(int, fmi2FreeFMUstate, (component, state *))
FN(int, fmi2SerializedFMUstateSize, (component, state, size_t *))
FN(int, fmi2SerializeFMUstate, (component, state, char *, size_t))
FN(int, fmi2DeSerializeFMUstate, (component, const char *, size_t, state *))
FN(int, fmi2GetDirectionalDerivative,
   (component, const unsigned *, size_t, const unsigned *, size_t, const double *, double *))
FN(int, fmi2SetRealInputDerivatives, (component, const unsigned *, size_t, const int *, const double *))
FN(int, fmi2GetRealOutputDerivatives, (component, const unsigned *, size_t, const int *, double *))
FN(int, fmi2DoStep, (component, double, double, int))
FN(int, fmi2CancelStep, (component))
FN(int, fmi2GetStatus, (component, int, int *))
FN(int, fmi2GetRealStatus, (component, int, double *))
FN(int, fmi2GetIntegerStatus, (component, int, int *))
FN(int, fmi2GetBooleanStatus, (component, int, int *))
FN(int, fmi2GetStringStatus, (component, int, const char **))

static void *library;

static void *needed(const char *name) {
    void *found = find(library, name);
    if (!found) {
        fprintf(stderr, "the library has no %s\n", name);
        exit(1);
    }
    return found;
}

static void find_all(void) {
#define GET(name) *(void **)&name = needed(#name);
    GET(fmi2GetTypesPlatform) GET(fmi2GetVersion) GET(fmi2SetDebugLogging) GET(fmi2Instantiate) GET(fmi2FreeInstance)
    GET(fmi2SetupExperiment) GET(fmi2EnterInitializationMode) GET(fmi2ExitInitializationMode) GET(fmi2Terminate)
    GET(fmi2Reset) GET(fmi2GetReal) GET(fmi2GetInteger) GET(fmi2GetBoolean) GET(fmi2GetString) GET(fmi2SetReal)
    GET(fmi2SetInteger) GET(fmi2SetBoolean) GET(fmi2SetString) GET(fmi2GetFMUstate) GET(fmi2SetFMUstate)
    GET(fmi2FreeFMUstate) GET(fmi2SerializedFMUstateSize) GET(fmi2SerializeFMUstate) GET(fmi2DeSerializeFMUstate)
    GET(fmi2GetDirectionalDerivative) GET(fmi2SetRealInputDerivatives) GET(fmi2GetRealOutputDerivatives)
    GET(fmi2DoStep) GET(fmi2CancelStep) GET(fmi2GetStatus) GET(fmi2GetRealStatus) GET(fmi2GetIntegerStatus)
    GET(fmi2GetBooleanStatus) GET(fmi2GetStringStatus)
}

static int messages;

/* A message without a percent sign is the format itself. */
static void log_message(void *environment, const char *name, int status, const char *category, const char *format, ...) {
    (void)environment, (void)name, (void)category;
    if (*format) messages++;
    if (status > WARNING) messages += 1000;
}

static FILE *opened(const char *path, const char *how) {
    FILE *file = fopen(path, how);
    if (!file) {
        fprintf(stderr, "can't open %s\n", path);
        exit(1);
    }
    return file;
}

static unsigned references[REAL];
static size_t count;

static void read_references(const char *path) {
    FILE *file = opened(path, "r");
    while (count < REAL && fscanf(file, "%u", &references[count]) == 1) count++;
    fclose(file);
}

static void write_readings(component c, FILE *to) {
    static double values[REAL];
    check("fmi2GetReal", fmi2GetReal(c, references, count, values), OK);
    for (size_t k = 0; k < count; k++) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        fprintf(to, "%08x%08x\n", (unsigned)(bits >> 32), (unsigned)bits);
    }
}

static void steps(component c, int from, int to) {
    for (int k = from; k < to; k++) check("fmi2DoStep", fmi2DoStep(c, 1e-3 * k, 1e-3, 1), OK);
}

static const unsigned TORQUE = 101, CLAMPING = 102, DRIVE = 131, STEADY = 1013, RATIO = 5, SLIPS = 10;

static state read_state(component c, const char *path) {
    FILE *file = opened(path, "rb");
    fseek(file, 0, SEEK_END);
    size_t size = (size_t)ftell(file);
    rewind(file);
    char *bytes = malloc(size);
    if (!bytes || fread(bytes, 1, size, file) != size) exit(1);
    fclose(file);
    state found = NULL;
    bytes[size / 2] ^= 1;
    check("fmi2DeSerializeFMUstate of damaged bytes", fmi2DeSerializeFMUstate(c, bytes, size, &found), ERROR_);
    bytes[size / 2] ^= 1;
    check("fmi2DeSerializeFMUstate", fmi2DeSerializeFMUstate(c, bytes, size, &found), OK);
    free(bytes);
    return found;
}

static void write_state(component c, const char *path) {
    state stored = NULL;
    size_t size = 0;
    check("fmi2GetFMUstate", fmi2GetFMUstate(c, &stored), OK);
    check("fmi2SerializedFMUstateSize", fmi2SerializedFMUstateSize(c, stored, &size), OK);
    char *bytes = malloc(size);
    check("fmi2SerializeFMUstate", fmi2SerializeFMUstate(c, stored, bytes, size), OK);
    check("fmi2FreeFMUstate", fmi2FreeFMUstate(c, &stored), OK);
    FILE *file = opened(path, "wb");
    if (fwrite(bytes, 1, size, file) != size) exit(1);
    fclose(file);
    free(bytes);
}

/* The first 20 ms, after other calls that an importer may make. */
static void first_run(component c) {
    double number = 55.0, nan = 0.0 / (double)(count == 0 ? 1 : 0), gradient = 100.0;
    int whole = 1, truth = 1, order = 1;
    const char *text = "x";
    const char *category = "logEvents";
    check("fmi2SetDebugLogging", fmi2SetDebugLogging(c, 1, 1, &category), OK);
    check("fmi2SetReal", fmi2SetReal(c, &TORQUE, 1, &number), OK);
    check("fmi2SetReal of NaN", fmi2SetReal(c, &TORQUE, 1, &nan), DISCARD);
    check("fmi2SetInteger", fmi2SetInteger(c, &DRIVE, 1, &whole), OK);
    check("fmi2SetBoolean", fmi2SetBoolean(c, &STEADY, 1, &truth), OK);
    check("fmi2SetString", fmi2SetString(c, &TORQUE, 1, &text), ERROR_);
    check("fmi2Reset", fmi2Reset(c), OK);
    check("fmi2SetupExperiment", fmi2SetupExperiment(c, 1, TOLERANCE, 0.0, 1, 1.0), OK);
    check("fmi2EnterInitializationMode", fmi2EnterInitializationMode(c), OK);
    check("fmi2ExitInitializationMode", fmi2ExitInitializationMode(c), OK);
    steps(c, 0, 10);
    check("fmi2SetRealInputDerivatives", fmi2SetRealInputDerivatives(c, &TORQUE, 1, &order, &gradient), OK);
    steps(c, 10, 20);
    check("fmi2GetRealOutputDerivatives", fmi2GetRealOutputDerivatives(c, &RATIO, 1, &order, &number), OK);
    check("fmi2GetInteger", fmi2GetInteger(c, &DRIVE, 1, &whole), OK);
    check("fmi2GetBoolean", fmi2GetBoolean(c, &SLIPS, 1, &truth), OK);
    check("fmi2GetString", fmi2GetString(c, &TORQUE, 1, &text), ERROR_);
    check("the drive", whole, 1);
    check("macroSlip", truth, 0);
    check("fmi2GetDirectionalDerivative",
          fmi2GetDirectionalDerivative(c, &RATIO, 1, &TORQUE, 1, &number, &gradient), ERROR_);
    check("fmi2CancelStep", fmi2CancelStep(c), ERROR_);
    check("fmi2GetStatus", fmi2GetStatus(c, 0, &whole), OK);
    check("fmi2GetRealStatus", fmi2GetRealStatus(c, 2, &number), OK);
    check("fmi2GetIntegerStatus", fmi2GetIntegerStatus(c, 0, &whole), DISCARD);
    check("fmi2GetBooleanStatus", fmi2GetBooleanStatus(c, 3, &truth), OK);
    check("fmi2GetStringStatus", fmi2GetStringStatus(c, 1, &text), DISCARD);
    check("the time reached", number > 0.0199999 && number < 0.0200001, 1);
}

static void start(component c) {
    check("fmi2SetupExperiment", fmi2SetupExperiment(c, 1, TOLERANCE, 0.0, 0, 0.0), OK);
    check("fmi2EnterInitializationMode", fmi2EnterInitializationMode(c), OK);
    check("fmi2ExitInitializationMode", fmi2ExitInitializationMode(c), OK);
}

static void calls_of(component c, const char *path, FILE *readings) {
    FILE *file = opened(path, "r");
    char word[16];
    while (fscanf(file, "%15s", word) == 1) {
        unsigned reference;
        int whole;
        double number, length;
        if (!strcmp(word, "integer") && fscanf(file, "%u %d", &reference, &whole) == 2)
            check("fmi2SetInteger", fmi2SetInteger(c, &reference, 1, &whole), OK);
        else if (!strcmp(word, "real") && fscanf(file, "%u %lf", &reference, &number) == 2)
            check("fmi2SetReal", fmi2SetReal(c, &reference, 1, &number), OK);
        else if (!strcmp(word, "step") && fscanf(file, "%lf %lf", &number, &length) == 2)
            check("fmi2DoStep", fmi2DoStep(c, number, length, 1), OK);
        else if (!strcmp(word, "start"))
            start(c);
        else if (!strcmp(word, "read"))
            write_readings(c, readings);
        else
            check(word, 0, 1);
    }
    fclose(file);
}

int main(int argc, char **argv) {
    if (argc != 6 && argc != 7) {
        fprintf(stderr, "host LIBRARY GUID REFERENCES (RUN | STATE_IN|- STATE_OUT) READINGS\n");
        return 2;
    }
    read_references(argv[3]);
    library = load(argv[1]);
    if (!library) {
        fprintf(stderr, "can't load %s (%lu)\n", argv[1], why());
        return 1;
    }
    find_all();
    check("fmi2GetVersion", strcmp(fmi2GetVersion(), "2.0"), 0);
    check("fmi2GetTypesPlatform", strcmp(fmi2GetTypesPlatform(), "default"), 0);
    callbacks functions = {log_message, calloc, free, NULL, NULL};
    check("fmi2Instantiate with another GUID", !fmi2Instantiate("host", 1, "{0}", NULL, &functions, 0, 0), 1);
    check("the logged messages", messages, 1001);
    component c = fmi2Instantiate("host", 1, argv[2], NULL, &functions, 0, 0);
    check("fmi2Instantiate", c != NULL, 1);
    FILE *readings = opened(argv[argc - 1], "w");
    if (argc == 6) {
        calls_of(c, argv[4], readings);
    } else {
        if (strcmp(argv[4], "-")) {
            state stored = read_state(c, argv[4]);
            check("fmi2SetFMUstate", fmi2SetFMUstate(c, stored), OK);
            check("fmi2FreeFMUstate", fmi2FreeFMUstate(c, &stored), OK);
        } else {
            first_run(c);
        }
        write_readings(c, readings);
        write_state(c, argv[5]);
        double force = 14000.0;
        check("fmi2SetReal", fmi2SetReal(c, &CLAMPING, 1, &force), OK);
        steps(c, 20, 40);
        write_readings(c, readings);
    }
    fclose(readings);
    check("fmi2Terminate", fmi2Terminate(c), OK);
    fmi2FreeInstance(c);
    unload(library);
    printf("%d calls passed\n", calls);
    return 0;
}
