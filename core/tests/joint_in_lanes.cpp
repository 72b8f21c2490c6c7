// Joint allocation of vehicles with many servos: six arms with a servo each and one rotor or two, from random states.
// Exits 0 if each lane of a pack gets its answer alone to the last bit, rotors counted at run time or not, every answer
// proves itself, and no tilt moves further than its servo can.
#include <algorithm>
#include <cstdio>
#include <cstdlib>

#include "omnimorph/control/allocation.hpp"
#include "omnimorph/math/random.hpp"
#include "omnimorph/math/so3.hpp"

using namespace omnimorph;

namespace {

constexpr double pi = 3.14159265358979323846, period = 4e-3;
constexpr int servos = 6, steps = 500;

template <int N> Vehicle<double, N> arms() {
    Vehicle<double, N> v;
    v.n_servos = servos;
    v.mass = 0.32 * N;
    v.inertia = {{{4.0e-3 * N, 0, 0}, {0, 4.1e-3 * N, 0}, {0, 0, 7.6e-3 * N}}};
    v.inertia_inverse = inverse(v.inertia);
    for (int i = 0; i < N; ++i) {
        const int j = i % servos;
        const double angle = (30 + 60 * j) * pi / 180;
        const Vec3<double> arm{{std::cos(angle), std::sin(angle), 0}}, up{{0, 0, 1}};
        v.position[i] = 0.375 * arm;
        v.axis[i] = Vec3<double>::zero();
        v.axis_cosine[i] = up;
        v.axis_sine[i] = cross(arm, up);
        v.servo[i] = j;
        v.spin[i] = (i + i / servos) % 2 == 0 ? 1 : -1;
        v.thrust_coefficient[i] = 1.026e-5;
        v.drag_coefficient[i] = 0.016 * 1.026e-5;
        v.speed_min[i] = 0;
        v.speed_max[i] = 838;
        v.spin_inertia[i] = 0;
    }
    for (int j = 0; j < servos; ++j) {
        v.angle_min[j] = -3;
        v.angle_max[j] = 3;
        v.rate_max[j] = 2 + j;
    }
    return v;
}

template <int N> AllocationSettings<double, N> settings_for(const Vehicle<double, N>& v) {
    AllocationSettings<double, N> s{};
    for (int i = 0; i < N; ++i) s.weights.input[i] = s.weights.input_change[i] = 60;
    s.weights.acceleration = {{3e4, 3e4, 3e4, 10, 10, 10}};
    s.rule = JointTilt<double>{};
    for (int j = 0; j < servos; ++j) s.tilt_change[j] = v.rate_max[j] * period;
    return s;
}

/// What a control step starts from.
template <class T, int N> struct Situation {
    Motion<T> state;
    Vec6<T> acceleration;
    Command<T, N> before;
};

template <int N> Situation<double, N> situation(const Vehicle<double, N>& v, std::uint32_t k) {
    std::uint32_t pair = 0;
    const auto normal = [&] { return standard_normal_pair({11, 0}, k, pair++)[0]; };
    const auto three = [&](double size) { return Vec3<double>{{size * normal(), size * normal(), size * normal()}}; };
    Situation<double, N> s{};
    s.state = {three(0), three(0), exp_so3(three(1.5)), three(1)};
    for (int r = 0; r < 6; ++r) s.acceleration[r] = (r < 3 ? 2 : 5) * normal();
    for (int i = 0; i < N; ++i) s.before.thrust[i] = clamp(3 + 2 * normal(), v.thrust_min(i), v.thrust_max(i));
    for (int j = 0; j < servos; ++j) s.before.tilt[j] = clamp(0.5 * normal(), v.angle_min[j], v.angle_max[j]);
    return s;
}

template <class T, int M, int N> Allocation<T, M> answer(const Vehicle<double, N>& v, const Situation<T, M>& s) {
    const auto vehicle = convert<Vehicle<T, M>>(v);
    const auto settings = convert<AllocationSettings<T, M>>(settings_for(v));
    Allocation<T, M> answer = first_allocation(vehicle, s.before);
    AllocationCache<T, M> cache;
    const auto problem = allocation_problem(vehicle, settings.weights);
    allocate(settings, problem, s.state, Demand<T>{s.acceleration}, answer, cache);
    return answer;
}

template <class T, class S> void put(T& many, int k, const S& one) {
    constexpr int numbers = sizeof(S) / sizeof(double);
    static_assert(sizeof(T) == numbers * sizeof(Pack<double, 4>));
    for (int i = 0; i < numbers; ++i)
        set_lane(reinterpret_cast<Pack<double, 4>*>(&many)[i], k, reinterpret_cast<const double*>(&one)[i]);
}

template <int N> bool agrees() {
    const auto v = arms<N>();
    double apart = 0, residual = 0, beyond = 0;
    for (int step = 0; step < steps; ++step) {
        Situation<Pack<double, 4>, N> many{};
        Situation<double, N> one[4];
        for (int k = 0; k < 4; ++k) {
            one[k] = situation(v, std::uint32_t(4 * step + k));
            put(many, k, one[k]);
        }
        const auto four = answer<Pack<double, 4>, N>(v, many);
        for (int k = 0; k < 4; ++k) {
            const auto alone = answer<double, N>(v, one[k]);
            const Situation<double, 0> uncounted{
                one[k].state,
                one[k].acceleration,
                {convert<PerRotor<double, 0>>(one[k].before.thrust), one[k].before.tilt}};
            const auto counted = answer<double, 0>(v, uncounted);
            for (int i = 0; i < N; ++i)
                apart = std::max({apart, std::fabs(four.command.thrust[i][k] - alone.command.thrust[i]),
                                  std::fabs(counted.command.thrust[i] - alone.command.thrust[i])});
            for (int j = 0; j < servos; ++j) {
                apart = std::max({apart, std::fabs(four.command.tilt[j][k] - alone.command.tilt[j]),
                                  std::fabs(counted.command.tilt[j] - alone.command.tilt[j])});
                beyond =
                    std::max(beyond, std::fabs(alone.command.tilt[j] - one[k].before.tilt[j]) - v.rate_max[j] * period);
            }
            residual = std::max(residual, alone.kkt_residual);
        }
    }
    std::printf(
        "%d rotors: lanes, run-time counts and single answers differ by %.2g, largest KKT residual %.2g, tilts beyond "
        "reach by %.2g\n",
        N, apart, residual, beyond);
    return apart == 0 && residual < 1e-9 && beyond < 1e-15;
}

}  // namespace

int main() {
    return agrees<6>() && agrees<12>() ? EXIT_SUCCESS : EXIT_FAILURE;
}
