
/* the plant, by fixed steps of Runge and Kutta's classic method: chambers on the muscles, valves,
 * and a load. Between steps the state is that of fascicle's `simulate`; (T4) to (T6), (F4) to (F16)
 * are equations of its documentation. */

#define ISOTHERMAL 0
#define WALL 1 /* which conducts heat, or none */
#define LIQUID 2
#define CHAMBER @chamber@
#define DIRECT 0
#define SERVOVALVE 1
#define SOLENOID 2
#define SPOOL @spool@
#define PRESCRIBED @prescribed@ /* motion of the load */
#define WAITING 1024            /* commands on their way */

enum { FOLDED = 1, CAVITATES = 2, OFF_TABLE = 4, UNSETTLED = 8, NO_SUPPLY = 16, AT_STOP = 32,
       BROKEN = 128 };

static const double longest_step = @longest_step@; /* [s]: the stiffest part is stable */
static const double dead_time = @dead_time@;       /* [s], from a command to its effect */
static const double plate_length = @plate_length@; /* [m] */

static const double dead[UNITS] = {@dead_volume@};             /* [m3], of hoses and fittings */
static const double room[UNITS] = {@room_pressure@};             /* [Pa], absolute */
static const double lowest_pressure[UNITS] = {@lowest_pressure@}; /* [Pa]: it's empty or boils */
static const double room_warmth[UNITS] = {@room_temperature@}; /* [K] */
static const double supply_warmth = @supply_temperature@;    /* [K] */
#if CHAMBER == LIQUID
static const double density[UNITS] = {@reference_density@}, bulk[UNITS] = {@bulk_modulus@};
static const double compliance[UNITS] = {@compliance@}; /* [m3/Pa] */
#else
static const double gas_constant[UNITS] = {@specific_gas_constant@}; /* [J/(kg K)] */
#endif
#if CHAMBER == WALL
static const double heat_ratio[UNITS] = {@heat_capacity_ratio@};
static const double conductance[UNITS] = {@conductance@}; /* [W/K] */
#endif

/* of the valves to the supply and to the room. For a gas C [m3/(s Pa)] times its density at the
 * reference temperature, b, m, and the hose's C, likewise, and b; for a liquid the orifice's
 * resistance [Pa s2/kg2], its critical pressure difference [Pa], 0, and the hose's resistances,
 * laminar [Pa s/kg] and turbulent; without a hose 0 */
static const double valves[2][UNITS][5] = {
@valves@
};

#if SPOOL != SOLENOID
static const double overlap[UNITS] = {@overlap@};
#endif
#if SPOOL == SERVOVALVE
static const double time_constant[UNITS] = {@time_constant@}; /* [s] */
#elif SPOOL == SOLENOID
static const double period[UNITS] = {@period@}; /* [s] */
static const double opening_delay[UNITS] = {@opening_delay@}; /* [s] */
static const double closing_delay[UNITS] = {@closing_delay@}; /* [s] */
#endif

#if PRESCRIBED
static const double mean = @load_mean@, amplitude = @load_amplitude@;      /* [m] */
static const double pace = 2 * 3.14159265358979323846 * @load_frequency@; /* [rad/s] */
#else
static const double mass = @load_inertia@, damping = @load_damping@;           /* [kg], [N s/m] */
static const double steady_force = @steady_force@;                /* [N] */
static const double spring = @load_stiffness@, spring_rest = @spring_rest@; /* [N/m], [m] */
static const int has_stop = @has_stop@;
static const double stop_low = @stop_low@, stop_high = @stop_high@;             /* [m] */
static const double stop_stiffness = @stop_stiffness@, stop_damping = @stop_damping@;
#endif

/* `chamber`: mass [kg], and behind a wall the internal energy [J] */
typedef struct {
    double position, velocity, spool[UNITS], chamber[UNITS][2], pressure[UNITS];
} state;

static const state begin_state = {@position@, @velocity@, {@spools@}, {@chambers@}, {@pressures@}};

/* what acts on it from outside: openings are commanded [-], `supply` [Pa], `force` [N] */
typedef struct {
    double command[UNITS], supply, force;
} action;

/* one unit's muscles, and its chamber's residual (F12) with its slopes */
typedef struct {
    double force, volume, by_strain, by_pressure;
    double residual, by_state, residual_by_pressure, sensitivity, slope;
} fluid;

/* a state's rates, those of the conserved chambers (T6), and what is seen of it */
typedef struct {
    state rate;
    double conserved[UNITS][2], volume[UNITS], pull, drawn;
    int flags;
} evaluation;

static double unit_strain(int unit, double position)
{
    return own(unit, position / plate_length);
}

static void motion_at(double time, double *position, double *velocity)
{
#if PRESCRIBED
    *position = mean + amplitude * sin(pace * time);
    *velocity = amplitude * pace * cos(pace * time);
#else
    (void)time; (void)position; (void)velocity;
#endif
}

/* slope of a chamber's last number by the rate of volume [SI] */
static double push(int unit, double pressure)
{
#if CHAMBER == WALL
    return -(pressure + room[unit]);
#else
    (void)unit; (void)pressure;
    return 0;
#endif
}

static fluid fluid_at(int unit, double strain, double P, const double chamber[2])
{
    const point at = muscle_at(kind_of[unit], P, strain);
    const double n = count_of[unit], V = n * at.volume;
    double by_volume;
    fluid it;

    it.force = n * at.force;
    it.volume = V;
    it.by_strain = n * length[kind_of[unit]] * at.by_pressure;
    it.by_pressure = n * at.growth;
#if CHAMBER == LIQUID
    {
        const double rho = density[unit] * exp(P / bulk[unit]), c = compliance[unit];
        const double whole = V + dead[unit] + c * P;

        it.residual = rho * whole - chamber[0];
        it.by_state = -1;
        it.residual_by_pressure = rho * (whole / bulk[unit] + c);
        by_volume = rho;
    }
#else
    {
        const double p = P + room[unit], whole = V + dead[unit];
#if CHAMBER == WALL
        it.by_state = -(heat_ratio[unit] - 1);
        it.residual = p * whole + it.by_state * chamber[1];
#else
        it.by_state = -gas_constant[unit] * room_warmth[unit];
        it.residual = p * whole + it.by_state * chamber[0];
#endif
        it.residual_by_pressure = whole;
        by_volume = p;
    }
#endif
    it.sensitivity = it.by_state * push(unit, P) + by_volume;
    it.slope = it.residual_by_pressure + by_volume * it.by_pressure;
    return it;
}

/* a slope of the residual, or the fluid's own where it says little about the pressure */
static double usable(const fluid *it, double slope)
{
    return fabs(slope) > 1e-2 * it->residual_by_pressure ? slope : it->residual_by_pressure;
}

static double pressure_slope(const fluid *it)
{
    return usable(it, it->residual_by_pressure + it->sensitivity * it->by_pressure);
}

static double warmth(int unit, const double chamber[2])
{
#if CHAMBER == WALL
    const double c_v = gas_constant[unit] / (heat_ratio[unit] - 1);

    if (chamber[0] > 0) return chamber[1] / (chamber[0] * c_v);
#else
    (void)chamber;
#endif
    return room_warmth[unit];
}

/* mass flow [kg/s] from 1 to 2, absolute pressures [Pa], of a valve open by a share */
static double flow(const double valve[5], double p_1, double p_2, double T_1, double T_2,
                   double open)
{
#if CHAMBER == LIQUID
    /* (F8) */
    const double drop = p_1 - p_2, root = sqrt(drop * drop + valve[1] * valve[1]);
    const double a = open * valve[3], c = valve[0] + open * open * valve[4];

    (void)T_1; (void)T_2;
    return 2 * open * drop / (a + sqrt(a * a + 4 * c * root));
#else
    /* (F4) */
    const int onward = p_1 >= p_2;
    const double high_p = onward ? p_1 : p_2, low_p = onward ? p_2 : p_1;
    const double beta = @laminar_from@, ratio = high_p > 0 ? low_p / high_p : low_p;
    const double r = ratio < beta ? ratio : beta;
    const double driving = ratio < beta ? high_p : (high_p - low_p) / (1 - beta);
    double C = open * valve[0], b = valve[1], y, size_of;

    if (valve[3] > 0) {
        /* a hose behind it (F5) */
        const double C_1 = onward ? C : valve[3], b_1 = onward ? b : valve[4];
        const double C_2 = onward ? valve[3] : C, b_2 = onward ? valve[4] : b;
        double of_first = 1, of_second = C_2 > 0 ? C_1 / C_2 : C_1;

        C = C_1;
        if (b_1 * C_2 < C_1) {
            const double q = C_2 / C_1, v = 1 - b_1;

            of_second = (b_1 + v * sqrt(1 + q * q * (1 - 2 * b_1))) / (1 + q * q * v * v);
            of_first = q * of_second;
            C = C_2 * of_second;
        }
        b = 1 - of_first * of_first * (1 - b_1) - of_second * of_second * (1 - b_2);
    }
    y = r > b ? (r - b) / (1 - b) : 0;
    size_of = C * sqrt(@reference_temperature@ / (onward ? T_1 : T_2)) * pow(1 - y * y, valve[2]);
    return onward ? size_of * driving : -size_of * driving;
#endif
}

/* shares by which a unit's valves are open, to the supply and to the room */
static void openings(int unit, double command, double spool, double open[2])
{
#if SPOOL == SOLENOID
    /* (F11) */
    const double T = period[unit], duty = fabs(command), rise = 2 * opening_delay[unit];
    const double time = (spool - floor(spool)) * T, fall = 2 * closing_delay[unit];
    const double now = fmin(time / rise, 1 - (time - duty * T) / fall);
    const double before = fmin((time + T) / rise, 1 - (time + T - duty * T) / fall);
    const double z = duty >= 1 ? 1 : fmax(fmin(fmax(now, before), 1), 0);

    open[0] = command > 0 ? z : 0;
    open[1] = command < 0 ? z : 0;
#else
    /* (F9) */
    const double x = SPOOL == DIRECT ? command : spool, o = overlap[unit];

    open[0] = fmin(fmax(x - o, 0) / (1 - o), 1);
    open[1] = fmin(fmax(-x - o, 0) / (1 - o), 1);
#endif
}

#if !PRESCRIBED
static double stop_force(double position, double velocity)
{
    const double over = fmax(position - stop_high, 0), under = fmax(stop_low - position, 0);
    const double depth = over + under;
    /* (T2) */
    const double total = stop_stiffness * (over - under)
        + stop_damping * velocity * depth / (depth + @damper_depth@);

    if (!has_stop) return 0;
    return over > 0 ? fmax(total, 0) : under > 0 ? -fmax(-total, 0) : 0;
}
#endif

static evaluation evaluate(const state *s, const action *from)
{
    const double q = s->position, v = s->velocity;
    double outside = 0;
    evaluation it;
    int i;

    it.pull = it.drawn = 0;
    it.flags = from->supply <= 0 ? NO_SUPPLY : 0;
    for (i = 0; i < UNITS; i++) {
        const double *chamber = s->chamber[i], P = s->pressure[i], p = P + room[i];
        const double eps = unit_strain(i, q), eps_dot = v / length[kind_of[i]];
        const double T = warmth(i, chamber), T_a = room_warmth[i];
        const fluid at = fluid_at(i, eps, P, chamber);
        double open[2], drawn, vented, fixed[2] = {0, 0}, rising, growing;

        openings(i, from->command[i], s->spool[i], open);
        drawn = flow(valves[0][i], from->supply + room[i], p, supply_warmth, T, open[0]);
        if (from->supply <= 0 && drawn > 0) drawn = 0;
        vented = flow(valves[1][i], p, room[i], T, T_a, open[1]);
        fixed[0] = drawn - vented;
#if CHAMBER == WALL
        {
            const double c_p = heat_ratio[i] * gas_constant[i] / (heat_ratio[i] - 1);

            fixed[1] = drawn * c_p * (drawn > 0 ? supply_warmth : T)
                - vented * c_p * (vented > 0 ? T : T_a) - conductance[i] * (T - T_a);
        }
#endif
        /* (T4) */
        rising = -(at.by_state * fixed[CHAMBER == WALL] + at.sensitivity * at.by_strain * eps_dot)
            / pressure_slope(&at);
        growing = at.by_strain * eps_dot + at.by_pressure * rising;
        it.rate.pressure[i] = rising;
        it.rate.chamber[i][0] = it.conserved[i][0] = fixed[0];
        it.rate.chamber[i][1] = fixed[1] + push(i, P) * growing;
        it.conserved[i][1] = fixed[1] - (push(i, rising) - push(i, 0)) * at.volume;
#if SPOOL == SERVOVALVE
        it.rate.spool[i] = (from->command[i] - s->spool[i]) / time_constant[i];
#elif SPOOL == SOLENOID
        it.rate.spool[i] = 1 / period[i]; /* a clock, in periods */
#else
        it.rate.spool[i] = 0;
#endif
        it.volume[i] = at.volume;
        it.pull += at.force;
        it.drawn += drawn;
        if (at.slope <= 0) it.flags |= FOLDED;
        if (lowest_pressure[i] + 100 >= P) it.flags |= CAVITATES;
        if (eps < low[kind_of[i]] || eps > high[kind_of[i]] || P > top[kind_of[i]])
            it.flags |= OFF_TABLE;
        if (fabs(at.residual / usable(&at, at.slope)) > 1 + 1e-4 * fabs(P)) it.flags |= UNSETTLED;
    }
    it.rate.position = v;
    it.rate.velocity = 0;
#if PRESCRIBED
    (void)outside;
#else
    if (has_stop && (q > stop_high || q < stop_low)) it.flags |= AT_STOP;
    outside = steady_force - spring * (q - spring_rest) - damping * v + from->force;
    it.rate.velocity = (it.pull + outside - stop_force(q, v)) / mass;
#endif
    return it;
}

/* a chamber with a conserved state (T6) in two steps of Newton's method */
static void project(int unit, const double conserved[2], double eps, double *pressure,
                    double chamber[2])
{
    const double guess = *pressure, zero_chamber[2] = {0, 0};
    const double lowest = lowest_pressure[unit];
    const fluid first = fluid_at(unit, eps, guess, zero_chamber);
    const double base = conserved[1] + push(unit, guess) * first.volume;
    double P = guess, before = guess, volume;
    fluid at = first;
    int i;

    chamber[0] = conserved[0];
    chamber[1] = base;
    for (i = 0; i < 2; i++) {
        if (i) {
            at = fluid_at(unit, eps, P, zero_chamber);
            chamber[1] = base + push(unit, (guess + P) / 2) * (at.volume - first.volume);
        }
        at = fluid_at(unit, eps, P, chamber);
        before = P;
        P = fmax(P - at.residual / pressure_slope(&at), (P + lowest) / 2); /* half-way to none */
    }
    volume = at.volume + at.by_pressure * (P - before);
    chamber[1] = base + push(unit, (guess + P) / 2) * (volume - first.volume);
    *pressure = P;
}

/* one step of Runge and Kutta's from a time [s]; returns flags of what it met */
static int substep(state *s, double time, const action *from, double h)
{
    static const double times[4] = {0, 0.5, 0.5, 1}, weights[4] = {1, 2, 2, 1};
    const state start = *s;
    state stage = *s, total = *s;
    double conserved[UNITS][2];
    int i, k, n, flags = 0;

    for (n = 0; n < 4; n++) {
        const double w = weights[n] / 6 * h, next = n < 3 ? times[n + 1] * h : 0;
        evaluation at;

        motion_at(time + times[n] * h, &stage.position, &stage.velocity);
        at = evaluate(&stage, from);
        flags |= at.flags & FOLDED;
        total.position += w * at.rate.position;
        total.velocity += w * at.rate.velocity;
        stage.position = start.position + next * at.rate.position;
        stage.velocity = start.velocity + next * at.rate.velocity;
        for (i = 0; i < UNITS; i++) {
            if (!n) {
                conserved[i][0] = start.chamber[i][0];
                conserved[i][1] = start.chamber[i][1] - push(i, start.pressure[i]) * at.volume[i];
            }
            total.spool[i] += w * at.rate.spool[i];
            total.pressure[i] += w * at.rate.pressure[i];
            stage.spool[i] = start.spool[i] + next * at.rate.spool[i];
            stage.pressure[i] = start.pressure[i] + next * at.rate.pressure[i];
            for (k = 0; k < 2; k++) {
                conserved[i][k] += w * at.conserved[i][k];
                stage.chamber[i][k] = start.chamber[i][k] + next * at.rate.chamber[i][k];
            }
        }
    }
    motion_at(time + h, &total.position, &total.velocity);
    for (i = 0; i < UNITS; i++)
        project(i, conserved[i], unit_strain(i, total.position), total.pressure + i,
                total.chamber[i]);
    *s = total;
    return flags;
}
