/* The step of fric/friction/gms.py, line by line in C: the baseline of benchmarks/gms.py. */
#include <math.h>

static void relax(double s_0, double s_1, double C, double dt, double *left, double *pull)
{
    double x = 2.0 * C * dt / (s_0 + s_1);
    *left = 1.0;
    *pull = 0.0;
    if (x > 0.0) {
        double gone = -expm1(-x), mean = gone / x;
        *left = 1.0 - gone;
        *pull = (mean - *left) * s_0 + (1.0 - mean) * s_1;
    }
}

static void advance(double dz, double direction, double dt, double s_0, double s_1, double *state,
                    const double *parameters, int blocks)
{
    double C = parameters[5], left, pull;
    relax(s_0, s_1, C, dt, &left, &pull);
    for (int i = 0; i < blocks; i++) {
        double alpha = parameters[6 + i], k = parameters[6 + blocks + i];
        double u = direction * state[2 + i];
        if (state[2 + blocks + i] == direction) {
            u = left * u + alpha * pull;
        } else if (dz != 0.0) {
            double stretched = u + k * fabs(dz);
            double before = alpha * s_0 - u, after = alpha * s_1 - stretched;
            if (before > 0.0 && after > 0.0) {
                u = stretched;
                state[2 + blocks + i] = 0.0;
            } else {
                if (before > 0.0) {
                    double x = before / (before - after), s_x = s_0 + x * (s_1 - s_0);
                    double left_x, pull_x;
                    relax(s_x, s_1, C, (1.0 - x) * dt, &left_x, &pull_x);
                    u = alpha * (left_x * s_x + pull_x);
                } else {
                    u = left * u + alpha * pull;
                }
                state[2 + blocks + i] = direction;
            }
        }
        state[2 + i] = direction * u;
    }
}

static double step(double dz, double v, double dt, double *state, const double *parameters, int blocks)
{
    double F_c = parameters[0], F_s = parameters[1], v_s = parameters[2], delta = parameters[3], sigma = parameters[4];
    double v_0 = state[0], s_0 = state[1];
    double s_1 = F_c + (F_s - F_c) * exp(-pow(fabs(v / v_s), delta));
    if (v_0 * v < 0.0) {
        double share = v_0 / (v_0 - v), before = share * dt, overshoot = 0.5 * v_0 * before;
        advance(overshoot, copysign(1.0, v_0), before, s_0, F_s, state, parameters, blocks);
        dz -= overshoot;
        dt -= before;
        s_0 = F_s;
    }
    if (dz != 0.0 || v != 0.0)
        advance(dz, copysign(1.0, dz != 0.0 ? dz : v), dt, s_0, s_1, state, parameters, blocks);
    state[0] = v;
    state[1] = s_1;
    double force = sigma * v;
    for (int i = 0; i < blocks; i++) {
        force += state[2 + i];
        if (v == 0.0)
            state[2 + blocks + i] = 0.0;
    }
    return force;
}

void replay(long n, const double *position, const double *velocity, const double *time, double *state,
            const double *parameters, int blocks, double *force)
{
    force[0] = step(0.0, velocity[0], 0.0, state, parameters, blocks);
    for (long i = 1; i < n; i++)
        force[i] = step(position[i] - position[i - 1], velocity[i], time[i] - time[i - 1], state, parameters, blocks);
}
