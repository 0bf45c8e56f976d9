/* Loads an FMU's library for Windows and drives it as a master of FMI 2.0 does: prints the force after each step.
   windows_master.exe damper.dll TOKEN; lines of "time displacement velocity voltage" come on the standard input. */
#include <stdio.h>
#include <windows.h>

typedef void *(*Instantiate)(const char *, int, const char *, const char *, const void *, int, int);
typedef int (*OfInstance)(void *);
typedef int (*Setup)(void *, int, double, double, int, double);
typedef int (*Write)(void *, const unsigned *, size_t, const double *);
typedef int (*Read)(void *, const unsigned *, size_t, double *);
typedef int (*Step)(void *, double, double, int);
typedef void (*Free)(void *);
typedef struct { void *logger, *allocate, *release, *finished, *environment; } Callbacks;

static void quiet(void *e, const char *n, int s, const char *c, const char *m, ...) { (void)e; (void)n; (void)s; (void)c; (void)m; }

#define FUNCTION(type, name) type name = (type)(void *)GetProcAddress(library, #name); if (!name) { puts("no " #name); return 2; }

int main(int count, char **words)
{
    if (count != 3) return 2;
    HMODULE library = LoadLibraryA(words[1]);
    if (!library) { printf("the library cannot be loaded: %lu\n", GetLastError()); return 2; }
    FUNCTION(Instantiate, fmi2Instantiate)
    FUNCTION(Setup, fmi2SetupExperiment)
    FUNCTION(OfInstance, fmi2EnterInitializationMode)
    FUNCTION(OfInstance, fmi2ExitInitializationMode)
    FUNCTION(Write, fmi2SetReal)
    FUNCTION(Read, fmi2GetReal)
    FUNCTION(Step, fmi2DoStep)
    FUNCTION(Free, fmi2FreeInstance)
    Callbacks callbacks = { (void *)quiet, 0, 0, 0, 0 };
    void *unit = fmi2Instantiate("one", 1, words[2], "", &callbacks, 0, 0);
    if (!unit) { puts("the unit refuses the token"); return 2; }
    const unsigned inputs[3] = { 0, 1, 2 }, force[1] = { 3 };
    double t, before = 0.0, value[3], found;
    for (int k = 0; scanf("%lf %lf %lf %lf", &t, value, value + 1, value + 2) == 4; k++) {
        if (k == 0) { fmi2SetupExperiment(unit, 0, 0.0, t, 0, 0.0); fmi2EnterInitializationMode(unit); }
        else if (fmi2DoStep(unit, before, t - before, 1)) return 3;
        if (fmi2SetReal(unit, inputs, 3, value)) return 3;
        if (k == 0) fmi2ExitInitializationMode(unit);
        if (fmi2GetReal(unit, force, 1, &found)) return 3;
        printf("%.17g\n", found);
        before = t;
    }
    fmi2FreeInstance(unit);
    return 0;
}
