/* Gets the linear model of an instance by the header in the FMU: test_linear.py runs it with a library and its GUID. */
#include <dlfcn.h>
#include <stdio.h>
#include "pushbelt.h"

typedef struct { void *logger, *allocate, *release, *finished, *environment; } callbacks;
static void ignore_message(void *e, const char *i, int status, const char *category, const char *format, ...) { (void)e; (void)i; (void)status; (void)category; (void)format; }

int main(int argc, char **argv) {
    void *library = dlopen(argv[1], RTLD_NOW);
    if (argc != 3 || !library) return 10;
    void *(*instantiate)(const char *, int, const char *, const char *, const callbacks *, int, int);
    int (*setup)(void *, int, double, double, int, double), (*enter)(void *), (*leave)(void *);
    void (*release)(void *);
    pushbeltLinearizeTYPE *linearize;
    pushbeltFreeTextTYPE *free_text;
    *(void **)&instantiate = dlsym(library, "fmi2Instantiate");
    *(void **)&setup = dlsym(library, "fmi2SetupExperiment");
    *(void **)&enter = dlsym(library, "fmi2EnterInitializationMode");
    *(void **)&leave = dlsym(library, "fmi2ExitInitializationMode");
    *(void **)&release = dlsym(library, "fmi2FreeInstance");
    *(void **)&linearize = dlsym(library, "pushbeltLinearize");
    *(void **)&free_text = dlsym(library, "pushbeltFreeText");
    callbacks functions = {0};
    *(void (**)(void *, const char *, int, const char *, const char *, ...))&functions.logger = ignore_message;
    void *instance = instantiate("c", 1, argv[2], "", &functions, 0, 0);
    char *json = (char *)1;
    if (linearize(instance, 50.0, &json) != 3 || json) return 11;
    if (setup(instance, 0, 0.0, 0.0, 0, 0.0) || enter(instance) || leave(instance)) return 12;
    int status = linearize(instance, 50.0, &json);
    printf("%s", json);
    free_text(json);
    free_text(NULL);
    release(instance);
    return status;
}
