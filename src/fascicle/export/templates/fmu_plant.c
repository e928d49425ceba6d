/* numbers by their references: inputs first */
enum {
    COMMAND = 0,
    SUPPLY_PRESSURE = UNITS,
#if !PRESCRIBED
    LOAD_FORCE,
#endif
    INPUTS,
    POSITION = INPUTS,
    VELOCITY,
    PLATE_STRAIN,
    PULL,
    PRESSURE,
    TEMPERATURE = PRESSURE + UNITS,
    SUPPLY_FLOW = TEMPERATURE + UNITS,
    NUMBERS
};
enum { FLAGS, INTEGERS };

typedef struct {
    const callbacks *host;
    double of[NUMBERS];
    int choice[INTEGERS];
    double start;
    char called[128];
    double time; /* [s] since the start */
    state now;
    int folded;
    action acting;
    /* commands that wait for the end of the dead time, and when they act [s] */
    double waiting[WAITING][UNITS], due[WAITING];
    int first, count;
} slave;

static status refuse(slave *it, const char *why);

static void begin(slave *it)
{
    memset(it->of, 0, sizeof it->of);
    memset(it->choice, 0, sizeof it->choice);
    memset(&it->acting, 0, sizeof it->acting); /* valves are shut */
    it->of[SUPPLY_PRESSURE] = @supply_pressure@;
    it->start = it->time = 0;
    it->now = begin_state;
    it->folded = it->first = it->count = 0;
}

static status look(slave *it)
{
    const state *s = &it->now;
    double *of = it->of, sum = s->position + s->velocity;
    evaluation at;
    action from = it->acting;
    int i;

    from.supply = of[SUPPLY_PRESSURE];
    if (dead_time == 0) memcpy(from.command, of + COMMAND, sizeof from.command);
    at = evaluate(s, &from);
    of[POSITION] = s->position;
    of[VELOCITY] = s->velocity;
    of[PLATE_STRAIN] = s->position / plate_length;
    of[PULL] = at.pull;
    of[SUPPLY_FLOW] = at.drawn;
    for (i = 0; i < UNITS; i++) {
        of[PRESSURE + i] = s->pressure[i];
        of[TEMPERATURE + i] = warmth(i, s->chamber[i]);
        sum += s->pressure[i] + s->chamber[i][0] + s->chamber[i][1];
    }
    it->choice[FLAGS] = at.flags | it->folded | (sum - sum == 0 ? 0 : BROKEN);
    return sum - sum == 0 ? OK : refuse(it, "numbers are not finite: take shorter steps");
}

/* put the host's commands at the end of the dead time; only changes take a place */
static status send(slave *it)
{
    const double *command = it->of + COMMAND;
    const int last = (it->first + it->count - 1 + WAITING) % WAITING;
    const double *known = it->count ? it->waiting[last] : it->acting.command;
    const int next = (it->first + it->count) % WAITING;
    int i;

    for (i = 0; i < UNITS; i++)
        if (!(command[i] >= -1 && command[i] <= 1))
            return refuse(it, "a command must lie in -1 to 1, from open exhaust to open supply");
    if (memcmp(known, command, sizeof it->acting.command) == 0) return OK;
    if (it->count == WAITING)
        return refuse(it, "more than 1024 commands wait for their dead time: take longer steps");
    memcpy(it->waiting[next], command, sizeof it->acting.command);
    it->due[next] = it->time + dead_time;
    it->count += 1;
    return OK;
}

static status advance(slave *it, double time, double step)
{
    const double end = time - it->start + step, nearly = 1e-9 * longest_step;
    status now;

    it->time = time - it->start;
    now = send(it);
    if (now != OK) return now;
    it->acting.supply = it->of[SUPPLY_PRESSURE];
#if !PRESCRIBED
    it->acting.force = it->of[LOAD_FORCE];
#endif
    it->folded = 0;
    while (it->time < end - nearly) {
        double until = end, h;
        int i, count;

        while (it->count && it->due[it->first] <= it->time + nearly) {
            memcpy(it->acting.command, it->waiting[it->first], sizeof it->acting.command);
            it->first = (it->first + 1) % WAITING;
            it->count -= 1;
        }
        if (it->count && it->due[it->first] < end - nearly) until = it->due[it->first];
        count = (int)ceil((until - it->time) / longest_step - 1e-6);
        if (count < 1) count = 1;
        h = (until - it->time) / count;
        for (i = 0; i < count; i++)
            it->folded |= substep(&it->now, it->time + i * h, &it->acting, h);
        it->time = until;
    }
    it->time = end;
    return look(it);
}
