/* The loop of fric/kernels/loop.py and plant.py, line by line in C, with the GMS step that fric exports: the baseline of
   benchmarks/loop.py. */
#include "gms.c"

static const double ROUNDING = 1e-14;
enum { ORDERS = 6, DEPTH = 16, WORK = 400, ROOM = 64 };

typedef struct { double A, B, M, load, delay; } Plant;
typedef struct { double K_v, K_p, K_i, pole, T_s, limit, resolution; } Control;

static double filtered(const double *b, const double *a, double *memory, long order, double x)
{
    double y = b[0] * x + memory[0];
    for (long i = 0; i < order - 1; i++)
        memory[i] = b[i + 1] * x - a[i + 1] * y + memory[i + 1];
    memory[order - 1] = b[order] * x - a[order] * y;
    return y;
}

typedef struct { double z, v, F; } Instant;

static double extrapolated(const double *results, long stride, const double *weights, int k)
{
    double last = results[k * stride], change = 0.0;
    for (int j = 0; j < k; j++)
        change += weights[k * ORDERS + j] * (results[j * stride] - last);
    return last + change;
}

static Instant half_explicit(double *state, const double *parameters, int blocks, const Plant *plant, Instant start,
                             double driven, double h, double reach)
{
    double push = reach / plant->M, free_v = start.v + reach * (driven - plant->A * start.v);
    double ahead = free_v - push * start.F, dz = 0.5 * h * (start.v + ahead);
    double F = step(dz, ahead, h, state, parameters, blocks);
    return (Instant){start.z + dz, free_v - (0.5 * push) * (start.F + F), F};
}

static Instant advance_plant(double *state, const double *parameters, int blocks, const Plant *plant, Instant now,
                             double driven, double length, const double *reach, const double *weights,
                             double tolerance, long lasting_inputs, long *depth)
{
    static double ends[ORDERS][3], states[ORDERS][ROOM];
    double lasting = lasting_inputs * length / plant->M;
    long at = 0, whole = 1L << DEPTH, work = 0, size = 2 + 2 * blocks;
    while (at < whole) {
        double h = length / (1L << *depth), apart = INFINITY;
        double allowed = tolerance + ROUNDING * (fabs(now.v) + lasting * fabs(now.F));
        Instant best = now, last = now;
        int k;
        for (k = 0; k < ORDERS; k++) {
            last = now;
            for (long i = 0; i < size; i++)
                states[k][i] = state[i];
            for (int part = 0; part <= k; part++)
                last = half_explicit(states[k], parameters, blocks, plant, last, driven, h / (k + 1),
                                     reach[*depth * ORDERS + k]);
            ends[k][0] = last.z, ends[k][1] = last.v, ends[k][2] = last.F;
            Instant end = {extrapolated(&ends[0][0], 3, weights, k), extrapolated(&ends[0][1], 3, weights, k),
                           extrapolated(&ends[0][2], 3, weights, k)};
            double before = apart;
            if (k > 0)
                apart = fmax(fabs(end.v - best.v), lasting * fabs(end.F - best.F));
            best = end;
            work += k + 1;
            if (apart <= allowed || (k > 1 && apart > 0.25 * before))
                break;
        }
        if (k == ORDERS)
            k--;
        int smooth = apart <= allowed;
        if (!smooth && *depth < DEPTH && work < WORK) {
            ++*depth;
            continue;
        }
        now = smooth ? best : last;
        for (long i = 0; i < size; i++) {
            double change = fabs(states[k][i] - states[k - 1][i]);
            int steady = smooth && change > 0.0 && change < 0.5 * fabs(states[k][i]);
            state[i] = steady ? extrapolated(&states[0][i], ROOM, weights, k) : states[k][i];
        }
        at += whole >> *depth;
        int easy = (smooth && k < 3) || (work >= WORK && *depth > 3);
        if (easy && *depth > 0 && at % (whole >> (*depth - 1)) == 0)
            --*depth;
    }
    return now;
}

long closed_loop(double *state, const double *parameters, int blocks, const Plant *plant, const Control *control,
                 long order, const double *position_b, const double *position_a, const double *voltage_b,
                 const double *voltage_a, long n_samples, const double *r, const double *r_dot, const double *model,
                 const double *ahead, long late, const double *lengths, const double *reach, const double *weights,
                 double tolerance, long lasting, double *position, double *measured_out, double *velocity,
                 double *input, double *friction, double *disturbance)
{
    double z = r[0], origin = z, seen = z;
    if (control->resolution > 0.0)
        seen = rint(z / control->resolution) * control->resolution;
    double v = 0.0, F = step(0.0, 0.0, 0.0, state, parameters, blocks), filtered_v = 0.0, integral = 0.0;
    double position_memory[8] = {0}, voltage_memory[8] = {0};
    long saturated = 0, depth = 0;
    for (long n = 0; n < n_samples; n++) {
        double measured = z;
        if (control->resolution > 0.0)
            measured = rint(z / control->resolution) * control->resolution;
        filtered_v = control->pole * filtered_v + (1.0 - control->pole) * (measured - seen) / control->T_s;
        seen = measured;
        double error = control->K_v * (r[n] - measured) + r_dot[n] - filtered_v;
        double step_of_integral = control->K_i * control->T_s * error, estimate = 0.0;
        if (order)
            estimate = filtered(position_b, position_a, position_memory, order, measured - origin) - voltage_memory[0];
        double wanted = control->K_p * error + integral + step_of_integral + model[n] + ahead[n] - estimate;
        double u = fmin(fmax(wanted, -control->limit), control->limit);
        if (u == wanted)
            integral += step_of_integral;
        else {
            saturated++;
            if ((wanted - u) * step_of_integral < 0.0)
                integral += step_of_integral;
        }
        if (order)
            filtered(voltage_b, voltage_a, voltage_memory, order, u - ahead[n]);
        position[n] = z, measured_out[n] = measured, velocity[n] = v;
        input[n] = u, friction[n] = F, disturbance[n] = estimate;
        for (int part = 0; part < 2; part++)
            if (lengths[part] > 0.0) {
                long sample = n - late - 1 + part;
                double driven = (sample >= 0 ? plant->B * input[sample] : 0.0) - plant->load / plant->M;
                Instant now = advance_plant(state, parameters, blocks, plant, (Instant){0.0, v, F}, driven,
                                            lengths[part], reach + part * (DEPTH + 1) * ORDERS, weights, tolerance,
                                            lasting, &depth);
                z += now.z, v = now.v, F = now.F;
            }
    }
    return saturated;
}
