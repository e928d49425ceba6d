/* numbers by their references: inputs first */
enum {
    PRESSURE = 0,
    STRAIN = @guard@_UNITS,
    DEMAND,
    SUPPLY_PRESSURE,
#if @controls@
    STRAIN_RATE,
    MEASURED_FORCE,
#endif
    INPUTS,
    FORCE = INPUTS,
    VOLUME,
    SETPOINT = VOLUME + @guard@_UNITS,
    REACHED_FORCE = SETPOINT + @guard@_UNITS,
#if @controls@
    COMMAND,
    NUMBERS = COMMAND + @guard@_UNITS
#else
    NUMBERS
#endif
};
enum { RECRUITMENT_STATE, DEMAND_STATUS, INTEGERS };

typedef struct {
    const callbacks *host;
    double of[NUMBERS];
    int choice[INTEGERS];
    double next; /* sample of the controller, counted from the start */
    double start;
#if @controls@
    @name@_memory memory;
#endif
    char called[128];
} slave;

static status refuse(slave *it, const char *why);

static const double sample_time = @sample_time@;

static void begin(slave *it)
{
    memset(it->of, 0, sizeof it->of);
    memset(it->choice, 0, sizeof it->choice);
    it->of[SUPPLY_PRESSURE] = @supply_pressure@;
    it->next = 0;
    it->start = 0;
#if @controls@
    @name@_begin(&it->memory);
#endif
}

static status look(slave *it)
{
    double *of = it->of;

    if (@name@_force(of + PRESSURE, of[STRAIN], of + FORCE, NULL, NULL)
        || @name@_volume(of + PRESSURE, of[STRAIN], of + VOLUME))
        return refuse(it, "a strain or pressure is outside of the table: strains @low@ to @high@,"
                          " pressures @lowest_pressure@ to @highest@ Pa");
    it->choice[DEMAND_STATUS] =
        @name@_pressures(of[DEMAND], of[STRAIN], of[SUPPLY_PRESSURE], of + SETPOINT,
                         it->choice + RECRUITMENT_STATE, of + REACHED_FORCE);
    return OK;
}

/* a step up to a time, with the controller's samples on the way */
static status advance(slave *it, double time, double step)
{
#if @controls@
    const double until = time + step;
    double *of = it->of;
#endif
    const status now = look(it);

    if (now != OK) return now;
#if @controls@

    while (it->start + it->next * sample_time < until - 1e-9 * sample_time) {
        if (@name@_step(&it->memory, of[DEMAND], of[MEASURED_FORCE], of + PRESSURE,
                        of[SUPPLY_PRESSURE], of[STRAIN], of[STRAIN_RATE], of + COMMAND))
            return look(it);
        it->next += 1;
    }
#else
    UNUSED(time);
    UNUSED(step);
    UNUSED(sample_time);
#endif
    return OK;
}
