
/* the inverse: forces over pressure at one strain */
typedef double real;
#define NODES @nodes@
#define KINKS @kinks@ /* of each kind of muscle, over pressure */

static const double node[NODES] = {@node_pressures@}; /* [Pa] */
static const double inverse_top = @inverse_top@;      /* [Pa] */
static const double meets = @meets@; /* [N]: a force this near to the demand meets it */
static const double tie = @tie@;     /* [N]: forces this near to each other are equal */
static const int unit_of[KINDS] = {@first_units@}; /* the first unit of each kind */

/* force [N] of one muscle of each kind and its slope by pressure [m2] at each node; pressures on
 * both sides of each of its kinks [Pa]: where it buckles and collapses */
typedef struct {
    double strain[KINDS], supply, force[KINDS][NODES], slope[KINDS][NODES], full[KINDS];
    double kink[KINDS][KINKS][2];
    int kinks[KINDS];
} curves;

/* a pressure [Pa], and how far its force is beyond the demand [N] */
typedef struct {
    double pressure, excess;
    int meets;
} solution;

/* what changes its sign at a pressure: the force beyond a demand [N], its slope by pressure [m2], or
 * the strain [-] at which a muscle of this kind has a kink less its strain */
typedef struct {
    const curves *at;
    const double *count;
    double force;
    enum { EXCESS, SLOPE, KINK } quantity;
    int kind, kink;
} residual;

static double smaller(double a, double b) { return a < b ? a : b; }
static double larger(double a, double b) { return a > b ? a : b; }
static double size(double x) { return x < 0 ? -x : x; }

static int inside_inverse(double force, double strain, double supply)
{
    return force - force == 0 && strain > @name@_lowest && strain <= @name@_largest && supply > 0;
}

static double force_at(const curves *at, int kind, double pressure, double *slope)
{
    double force, by_strain, *res[6] = {&force, slope, &by_strain, NULL, NULL, NULL};

    @name@_kind(kind, pressure, at->strain[kind], res);
    return force;
}

static double kink_strain(const curves *at, int kind, int kink, double pressure)
{
    double out[3], *res[6] = {NULL, NULL, NULL, &out[0], &out[1], &out[2]};

    @name@_kind(kind, pressure, at->strain[kind], res);
    return out[kink];
}

/* force [N] of so many muscles of each kind beyond a demand, and its slope by pressure [m2] */
static double excess_at(const curves *at, const double count[KINDS], double force, double pressure,
                        double *slope)
{
    double excess = -force, by_pressure;
    int kind;

    *slope = 0;
    for (kind = 0; kind < KINDS; kind++) {
        if (!(count[kind] > 0)) continue;
        excess += count[kind] * force_at(at, kind, pressure, &by_pressure);
        *slope += count[kind] * by_pressure;
    }
    return excess;
}

static double value_of(const residual *of, double pressure)
{
    double excess, slope;

    if (of->quantity == KINK)
        return kink_strain(of->at, of->kind, of->kink, pressure) - of->at->strain[of->kind];
    excess = excess_at(of->at, of->count, of->force, pressure, &slope);
    return of->quantity == EXCESS ? excess : slope;
}

/* the pressure at which a residual changes its sign, by Chandrupatla's method; `low` and `high`
 * become the ends of the last bracket. It ends at a residual of `tolerance`, or at rounding. */
static double root(const residual *of, double *low, double *high, double tolerance)
{
    double a = *low, b = *high, c = b, f_a = value_of(of, a), f_b = value_of(of, b), f_c = f_b;
    double t = f_a / (f_a - f_b), x, f, xi, phi, least;
    int i;

    for (i = 0; i < 100; i++) { /* bisection alone would need 53 */
        const double width = size(b - a);

        least = (2e-16 * size(a) + 1e-300) / (width > 0 ? width : 1); /* rounding of a double */
        if (smaller(size(f_a), size(f_b)) <= tolerance || !(least < 0.5) || !(width > 0)) break;
        t = t - t == 0 ? smaller(larger(t, least), 1 - least) : 0.5;
        x = a + t * (b - a);
        f = value_of(of, x);
        if ((f > 0) == (f_a > 0)) {
            c = a;
            f_c = f_a;
        } else {
            c = b;
            f_c = f_b;
            b = a;
            f_b = f_a;
        }
        a = x;
        f_a = f;
        xi = (a - b) / (c - b);
        phi = (f_a - f_b) / (f_c - f_b);
        t = 0.5;
        if (phi * phi < xi && (1 - phi) * (1 - phi) < 1 - xi)
            t = f_a / (f_b - f_a) * f_c / (f_b - f_c)
              + (c - a) / (b - a) * f_a / (f_c - f_a) * f_b / (f_c - f_b);
    }
    *low = smaller(a, b);
    *high = larger(a, b);
    return size(f_a) < size(f_b) ? a : b;
}

static void add_kink(curves *at, int kind, double left, double right)
{
    int i = at->kinks[kind];

    if (i == KINKS) return;
    at->kinks[kind]++;
    for (; i > 0 && at->kink[kind][i - 1][0] > left; i--) {
        at->kink[kind][i][0] = at->kink[kind][i - 1][0];
        at->kink[kind][i][1] = at->kink[kind][i - 1][1];
    }
    at->kink[kind][i][0] = left;
    at->kink[kind][i][1] = right;
}

static void fill_curves(curves *at, double strain, double supply)
{
    int kind, i, j;

    at->supply = supply;
    for (kind = 0; kind < KINDS; kind++) {
        double before[3] = {0, 0, 0}, slope;

        at->strain[kind] = strain + (1.0 - ratio_of[unit_of[kind]]) * (1.0 - strain);
        at->kinks[kind] = 0;
        at->full[kind] = force_at(at, kind, supply, &slope);
        for (i = 0; i < NODES; i++) {
            const double P = smaller(node[i], supply);
            double now[3], *res[6] = {&at->force[kind][i], &at->slope[kind][i], &slope,
                                      &now[0], &now[1], &now[2]};

            @name@_kind(kind, P, at->strain[kind], res);
            for (j = 0; j < 3; j++) {
                const double eps = at->strain[kind];
                residual of = {at, NULL, 0, KINK, kind, j};
                double left = i ? smaller(node[i - 1], supply) : 0, right = P;

                /* most laws buckle at the free strain itself */
                if (i && (before[j] > eps) != (now[j] > eps)
                    && !(j == 1 && now[1] == now[0] && before[1] == before[0])) {
                    root(&of, &left, &right, -1);
                    add_kink(at, kind, left, right);
                }
            }
            for (j = 0; j < 3; j++) before[j] = now[j];
        }
    }
}

/* keeps a pressure if its force meets the demand, or is nearer than any before */
static void consider(solution *best, double pressure, double excess)
{
    if (best->meets || !(size(excess) <= meets || size(excess) < size(best->excess) - tie)) return;
    best->pressure = pressure;
    best->excess = excess;
    best->meets = size(excess) <= meets;
}

/* a smooth piece without an extremum between both pressures */
static void search_monotone(const residual *of, double left, double right, double f, double g,
                            solution *best)
{
    consider(best, left, f);
    if (!best->meets && size(g) > meets && (f > 0) != (g > 0)) {
        const double P = root(of, &left, &right, meets / 100), excess = value_of(of, P);

        if (size(excess) <= meets) consider(best, P, excess); /* else the force jumps past it */
    }
    consider(best, right, g);
}

/* a piece without a kink between both pressures; the slopes a thousandth from its ends show
 * whether it has an extremum */
static void search_smooth(const residual *of, double left, double right, solution *best)
{
    const double inset = 1e-3 * (right - left);
    double slope, f_slope, g_slope, low = left + inset, high = right - inset, f, g;

    f = excess_at(of->at, of->count, of->force, left, &slope);
    g = excess_at(of->at, of->count, of->force, right, &slope);
    excess_at(of->at, of->count, of->force, low, &f_slope);
    excess_at(of->at, of->count, of->force, high, &g_slope);
    if ((f_slope > 0) != (g_slope > 0)) {
        residual turn = *of;
        double middle, excess;

        turn.quantity = SLOPE;
        middle = root(&turn, &low, &high, 0);
        excess = value_of(of, middle);
        search_monotone(of, left, middle, f, excess, best);
        search_monotone(of, middle, right, excess, g, best);
    } else {
        search_monotone(of, left, right, f, g, best);
    }
}

/* the lowest pressure at which so many muscles of each kind give a force; else that of the nearest
 * force. Cells between nodes are cut at kinks and at extrema. */
static solution search(const curves *at, const double count[KINDS], double force)
{
    const residual of = {at, count, force, EXCESS, 0, 0};
    solution best = {0, INFINITY, 0};
    int i, k, kind;

    for (i = 0; i + 1 < NODES && node[i] < at->supply && !best.meets; i++) {
        double left = node[i], right = smaller(node[i + 1], at->supply), start = left;
        double f = -force, g = -force, f_step = 0, g_step = 0, low, high;
        int next[KINDS] = {0}, has_kink = 0;

        for (kind = 0; kind < KINDS; kind++) {
            f += count[kind] * at->force[kind][i];
            g += count[kind] * at->force[kind][i + 1];
            f_step += count[kind] * (right - left) * at->slope[kind][i];
            g_step += count[kind] * (right - left) * at->slope[kind][i + 1];
            for (k = 0; k < at->kinks[kind]; k++)
                has_kink = has_kink || (count[kind] > 0 && at->kink[kind][k][0] >= left
                                        && at->kink[kind][k][1] <= right);
        }
        consider(&best, left, f);
        /* the cell lies between its tangents: skip it if it holds nothing nearer */
        low = smaller(smaller(f, f + f_step), smaller(g, g - g_step));
        high = larger(larger(f, f + f_step), larger(g, g - g_step));
        if (!has_kink && (low >= size(best.excess) || high <= -size(best.excess))) {
            consider(&best, right, g);
            continue;
        }
        while (!best.meets) {
            int first = -1;

            for (kind = 0; kind < KINDS; kind++) {
                while (next[kind] < at->kinks[kind] && at->kink[kind][next[kind]][0] < start)
                    next[kind]++;
                if (count[kind] > 0 && next[kind] < at->kinks[kind]
                    && at->kink[kind][next[kind]][1] <= right
                    && (first < 0
                        || at->kink[kind][next[kind]][0] < at->kink[first][next[first]][0]))
                    first = kind;
            }
            if (first < 0) break;
            search_smooth(&of, start, at->kink[first][next[first]][0], &best);
            start = at->kink[first][next[first]++][1];
        }
        if (!best.meets) search_smooth(&of, start, right, &best);
    }
    return best;
}
