/* learned correction of each unit's force, of one muscle [N], linear between nodes: in pressure
 * [Pa], even in its root, and in strain, even */
#define ROWS @rows@
#define STRAINS @strains@

static const real correction[UNITS][ROWS + 1][STRAINS + 1] = {
@forces@
};
static const real correction_pressure[ROWS + 1] = {@pressures@};

static void correct(int unit, real pressure, real strain, point *at)
{
    const real last = correction_pressure[ROWS];
    const real P = least(most(pressure, 0), last);
    const real x = (strain - @lowest@) / (@highest@ - @lowest@) * (real)STRAINS;
    const real y = least(most(x, 0), (real)STRAINS);
    const int i = (int)least(sqrt(P / last) * (real)ROWS, (real)(ROWS - 1));
    const int j = (int)least(y, (real)(STRAINS - 1));
    const real w = y - (real)j;
    const real *row = correction[unit][i], *next = correction[unit][i + 1];
    const real here = (1 - w) * row[j] + w * row[j + 1];
    const real there = (1 - w) * next[j] + w * next[j + 1];
    const real slope = (there - here) / (correction_pressure[i + 1] - correction_pressure[i]);

    at->force += here + slope * (P - correction_pressure[i]);
    if (pressure > 0 && pressure < last) at->by_pressure += slope;
}
