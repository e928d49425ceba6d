/* @name@ as a co-simulation slave of FMI 2.0.
 *
 * The standard's types are declared here, so that nothing else is needed to build it:
 *
 *     gcc -O2 -std=c99 -shared -fPIC -o @name@.so @files@ -lm
 */
#include "@name@.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#ifdef _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT
#endif
#define UNUSED(x) ((void)(x))

typedef enum { OK, WARNING, DISCARD, ERROR, FATAL, PENDING } status;
typedef void (*logger)(void *, const char *, status, const char *, const char *, ...);
typedef struct {
    logger log;
    void *(*allocate)(size_t, size_t);
    void (*release)(void *);
    void (*finished)(void *, status);
    void *environment;
} callbacks;

@model@
static status refuse(slave *it, const char *why)
{
    const callbacks *host = it->host;

    if (host->log) host->log(host->environment, it->called, ERROR, "logStatusError", "%s", why);
    return ERROR;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT status fmi2SetDebugLogging(void *c, int on, size_t n, const char *const categories[])
{
    UNUSED(c); UNUSED(on); UNUSED(n); UNUSED(categories);
    return OK;
}

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                             const callbacks *host, int visible, int logging)
{
    slave *it;

    UNUSED(resources); UNUSED(visible); UNUSED(logging);
    if (!host || !host->allocate || !host->release) return NULL;
    if (type != 1 || !guid || strcmp(guid, "@guid@") != 0) {
        if (host->log)
            host->log(host->environment, name, ERROR, "logStatusError", "%s",
                      "it is a slave for co-simulation, and must be given its own GUID");
        return NULL;
    }
    it = (slave *)host->allocate(1, sizeof(slave));
    if (!it) return NULL;
    it->host = host;
    it->called[0] = 0;
    if (name) strncat(it->called, name, sizeof it->called - 1);
    begin(it);
    return it;
}

EXPORT void fmi2FreeInstance(void *c)
{
    if (c) ((slave *)c)->host->release(c);
}

EXPORT status fmi2SetupExperiment(void *c, int tolerates, double tolerance, double start, int ends,
                                  double stop)
{
    UNUSED(tolerates); UNUSED(tolerance); UNUSED(ends); UNUSED(stop);
    ((slave *)c)->start = start;
    return OK;
}

EXPORT status fmi2EnterInitializationMode(void *c) { UNUSED(c); return OK; }
EXPORT status fmi2ExitInitializationMode(void *c) { return look((slave *)c); }
EXPORT status fmi2Terminate(void *c) { UNUSED(c); return OK; }
EXPORT status fmi2Reset(void *c) { begin((slave *)c); return OK; }

EXPORT status fmi2GetReal(void *c, const unsigned vr[], size_t n, double value[])
{
    slave *it = (slave *)c;
    status now = OK;
    size_t i;

    for (i = 0; i < n; i++) {
        if (vr[i] >= NUMBERS) return refuse(it, "there is no number of this reference");
        if (vr[i] >= INPUTS && now == OK) now = look(it);
        value[i] = it->of[vr[i]];
    }
    return now;
}

EXPORT status fmi2SetReal(void *c, const unsigned vr[], size_t n, const double value[])
{
    slave *it = (slave *)c;
    size_t i;

    for (i = 0; i < n; i++) {
        if (vr[i] >= INPUTS) return refuse(it, "only inputs can be set");
        it->of[vr[i]] = value[i];
    }
    return OK;
}

EXPORT status fmi2GetInteger(void *c, const unsigned vr[], size_t n, int value[])
{
    slave *it = (slave *)c;
    status now = OK;
    size_t i;

    for (i = 0; i < n; i++) {
        if (vr[i] >= INTEGERS) return refuse(it, "there is no integer of this reference");
        if (now == OK) now = look(it);
        value[i] = it->choice[vr[i]];
    }
    return now;
}

EXPORT status fmi2DoStep(void *c, double time, double step, int kept)
{
    slave *it = (slave *)c;

    UNUSED(kept);
    return step > 0 ? advance(it, time, step) : refuse(it, "a step must be longer than 0 s");
}

/* what it doesn't have: numbers of other kinds, states to be kept, derivatives, steps that wait */
#define NONE(name, type) \
    EXPORT status fmi2Get##name(void *c, const unsigned vr[], size_t n, type value[]) \
    { UNUSED(vr); UNUSED(value); return n ? refuse((slave *)c, "it has no such numbers") : OK; }
#define NONE_SET(name, type) \
    EXPORT status fmi2Set##name(void *c, const unsigned vr[], size_t n, const type value[]) \
    { UNUSED(vr); UNUSED(value); return n ? refuse((slave *)c, "only real numbers can be set") : OK; }
typedef const char *text;
NONE(Boolean, int)
NONE(String, text)
NONE_SET(Integer, int)
NONE_SET(Boolean, int)
NONE_SET(String, text)

static status none(void *c) { return refuse((slave *)c, "it can't do this, as its description says"); }

EXPORT status fmi2GetFMUstate(void *c, void **s) { UNUSED(s); return none(c); }
EXPORT status fmi2SetFMUstate(void *c, void *s) { UNUSED(s); return none(c); }
EXPORT status fmi2FreeFMUstate(void *c, void **s) { UNUSED(s); return none(c); }
EXPORT status fmi2SerializedFMUstateSize(void *c, void *s, size_t *n)
{ UNUSED(s); UNUSED(n); return none(c); }
EXPORT status fmi2SerializeFMUstate(void *c, void *s, char b[], size_t n)
{ UNUSED(s); UNUSED(b); UNUSED(n); return none(c); }
EXPORT status fmi2DeSerializeFMUstate(void *c, const char b[], size_t n, void **s)
{ UNUSED(s); UNUSED(b); UNUSED(n); return none(c); }
EXPORT status fmi2GetDirectionalDerivative(void *c, const unsigned of[], size_t n,
                                           const unsigned by[], size_t m, const double seed[],
                                           double value[])
{ UNUSED(of); UNUSED(n); UNUSED(by); UNUSED(m); UNUSED(seed); UNUSED(value); return none(c); }
EXPORT status fmi2SetRealInputDerivatives(void *c, const unsigned vr[], size_t n, const int order[],
                                          const double value[])
{ UNUSED(vr); UNUSED(n); UNUSED(order); UNUSED(value); return none(c); }
EXPORT status fmi2GetRealOutputDerivatives(void *c, const unsigned vr[], size_t n,
                                           const int order[], double value[])
{ UNUSED(vr); UNUSED(n); UNUSED(order); UNUSED(value); return none(c); }
EXPORT status fmi2CancelStep(void *c) { return none(c); }
EXPORT status fmi2GetStatus(void *c, int kind, status *value)
{ UNUSED(kind); UNUSED(value); return none(c); }
EXPORT status fmi2GetRealStatus(void *c, int kind, double *value)
{ UNUSED(kind); UNUSED(value); return none(c); }
EXPORT status fmi2GetIntegerStatus(void *c, int kind, int *value)
{ UNUSED(kind); UNUSED(value); return none(c); }
EXPORT status fmi2GetBooleanStatus(void *c, int kind, int *value)
{ UNUSED(kind); UNUSED(value); return none(c); }
EXPORT status fmi2GetStringStatus(void *c, int kind, text *value)
{ UNUSED(kind); UNUSED(value); return none(c); }
