// Allocation whose bounds, effectiveness, wrench bias and weights change in every step, by every rule. Exits 0 if each
// answer is the least of the cost written out by Newton and Euler, and if an empty cache gives the same bits as a kept
// one. Prints a hash of all answers: with OMNIMORPH_SCALAR, where candidates are solved one after the other and no
// vector extension is used, it is the same.
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "omnimorph/control/allocation.hpp"
#include "omnimorph/math/random.hpp"

using namespace omnimorph;

namespace {

constexpr double pi = 3.14159265358979323846;
constexpr int rotors = 8, steps = 300;

/// Rotors around a ring that turn either way about their arms, on one servo or on one for each.
template <class T> Vehicle<T, rotors> ring(int servos) {
    Vehicle<double, rotors> v{};
    v.n_servos = servos;
    v.mass = 1.3;
    v.inertia = {{{1.2e-2, 0, 0}, {0, 1.1e-2, 0}, {0, 0, 1.6e-2}}};
    derive(v);
    for (int i = 0; i < rotors; ++i) {
        const double angle = 2 * pi * i / rotors;
        const Vec3<double> arm{{std::cos(angle), std::sin(angle), 0}}, up{{0, 0, 1}};
        v.position[i] = 0.2 * arm;
        v.axis_cosine[i] = up;
        v.axis_sine[i] = (i % 4 < 2 ? 1.0 : -1.0) * cross(arm, up);
        v.servo[i] = i % servos;
        v.spin[i] = i % 2 == 0 ? 1 : -1;
        v.thrust_coefficient[i] = 5e-6;
        v.drag_coefficient[i] = 7e-8;
        v.speed_max[i] = 1000;
        v.speed_min[i] = -700;
    }
    for (int j = 0; j < servos; ++j) {
        v.angle_min[j] = -1;
        v.angle_max[j] = 1.2;
    }
    return convert<Vehicle<T, rotors>>(v);
}

/// What changes from step to step.
template <class T> struct Step {
    Motion<T> state;
    Demand<T> demand;
    PerRotor<T, rotors> low, high, effectiveness;
    Vec6<T> bias;
    AllocationWeights<T, rotors> weights;
};

template <class T> Step<T> draw(std::uint32_t k, const Vehicle<T, rotors>& v) {
    std::uint32_t pair = 0;
    const auto normal = [&](double size) { return T(size * standard_normal_pair({5, 0}, k, pair++)[0]); };
    const auto three = [&](double size) { return Vec3<T>{{normal(size), normal(size), normal(size)}}; };
    Step<T> s;
    s.state = {three(1), three(1), exp_so3(three(0.6)), three(1)};
    for (int r = 0; r < 6; ++r) s.demand.acceleration[r] = normal(r < 3 ? 2 : 8);
    for (int r = 0; r < 6; ++r) s.bias[r] = k % 5 == 0 ? T(0) : normal(r < 3 ? 2 : 0.1);
    for (int i = 0; i < rotors; ++i) {
        s.effectiveness[i] = k % 7 == 0 ? T(i != 3) : clamp(T(0.8) + normal(0.2), T(0.1), T(1));
        s.low[i] = v.thrust_min(i) * clamp(T(0.8) + normal(0.3), T(0), T(1));
        s.high[i] = v.thrust_max(i) * clamp(T(0.8) + normal(0.3), T(0.1), T(1));
        s.weights.input[i] = T(1 + i % 3);
        s.weights.input_change[i] = T(1 + k % 5);
    }
    const bool alike = k % 16 != 6;  // in every direction, so that the map is the same in every attitude
    for (int r = 0; r < 6; ++r) s.weights.acceleration[r] = T(r < 3 ? (alike ? 3e3 : 1e3 * (1 + r)) : 10);
    return s;
}

/// J of some thrusts at some tilts: W1 and W3 of the thrusts, and W2 of the acceleration that they do not give.
template <class T>
T cost_of(const Step<T>& s, const Vehicle<T, rotors>& v, const PerRotor<T, rotors>& thrust, const PerServo<T>& tilt,
          const PerRotor<T, rotors>& before) {
    PerRotor<T, rotors> unit{}, given;
    T cost = T(0);
    for (int i = 0; i < rotors; ++i) {
        const T change = thrust[i] - before[i];
        cost += s.weights.input[i] * thrust[i] * thrust[i] + s.weights.input_change[i] * change * change;
        unit[i] = T(1);
        given[i] = s.effectiveness[i] * thrust[i];
    }
    const WrenchMatrix<T, rotors> A = thrust_wrench_map(v, unit).template at<T>(trigonometry_of(tilt, v.n_servos));
    const Vec6<T> w = wrench(A, given, rotors) + s.bias;
    const Vec3<T> linear = (T(1) / v.mass) * (s.state.R * force_of(w)) - Vec3<T>{{T(0), T(0), T(gravity)}};
    const Vec3<T> turning = v.inertia_inverse * (torque_of(w) - cross(s.state.w, v.inertia * s.state.w));
    const Vec6<T> error = s.demand.acceleration - joined(linear, turning);
    for (int r = 0; r < 6; ++r) cost += s.weights.acceleration[r] * error[r] * error[r];
    return cost;
}

/// How far an answer is from what it should be: in N, one Newton step of each thrust alone within its bounds (J is a
/// quadratic, so that differences are derivatives); relative, the cost that it states; in N and N m, the wrench asked
/// for.
template <class T>
T distance_from_best(const Step<T>& s, const Vehicle<T, rotors>& v, const Allocation<T, rotors>& a,
                     const PerRotor<T, rotors>& before) {
    const auto J = [&](int i, T change) {
        PerRotor<T, rotors> thrust = a.command.thrust;
        if (i >= 0) thrust[i] += change;
        return cost_of(s, v, thrust, a.command.tilt, before);
    };
    const T here = J(-1, T(0));
    T distance = abs(here - a.cost) / here;
    for (int i = 0; i < rotors; ++i) {
        const T up = J(i, T(1)), down = J(i, T(-1));
        const T newton = (down - up) / (T(2) * (up + down - T(2) * here));
        const T best = clamp(a.command.thrust[i] + newton, s.low[i], s.high[i]);
        distance = max(distance, abs(best - a.command.thrust[i]));
    }
    const Vec6<T> beside = wrench_for(v, s.state, s.demand.acceleration) - a.wrench_asked - s.bias;
    for (int r = 0; r < 6; ++r) distance = max(distance, abs(beside[r]));
    return distance;
}

template <class T> struct Checked {
    T distance = T(0);
    int other_bits = 0, at_bounds = 0;
    std::uint64_t hash = 14695981039346656037u;  // FNV-1a

    void add(const T& x) {
        unsigned char bytes[sizeof(T)];
        std::memcpy(bytes, &x, sizeof(T));
        for (const unsigned char byte : bytes) hash = (hash ^ byte) * 1099511628211u;
    }
    void add(const Allocation<T, rotors>& a, int servos) {
        for (int i = 0; i < rotors; ++i) add(a.command.thrust[i]), add(a.active[i]);
        for (int j = 0; j < servos; ++j) add(a.command.tilt[j]);
        for (int r = 0; r < 6; ++r) add(a.wrench_asked[r]);
        add(a.cost), add(a.kkt_residual);
    }
};

template <class T> bool differs(const Allocation<T, rotors>& a, const Allocation<T, rotors>& b, int servos) {
    Checked<T> of_a, of_b;
    of_a.add(a, servos);
    of_b.add(b, servos);
    return of_a.hash != of_b.hash;
}

/// The rule in steps of which each changes one thing of the problem; every second one is the one before once more.
template <class T> Checked<T> solve_all(const AllocationRule<T>& rule, int servos) {
    const Vehicle<T, rotors> v = ring<T>(servos);
    Step<T> now = draw<T>(1, v);
    now.effectiveness = draw<T>(0, v).effectiveness;
    AllocationSettings<T, rotors> settings{now.weights, {}, rule};
    for (int j = 0; j < servos; ++j) settings.tilt_change[j] = T(0.02);
    AllocationProblem<T, rotors> problem = allocation_problem(v, now.weights);
    set_bounds(problem, now.low, now.high);
    set_effectiveness(problem, now.effectiveness);
    set_wrench_bias(problem, now.bias);
    Command<T, rotors> hover{};
    for (int i = 0; i < rotors; ++i) hover.thrust[i] = v.mass * T(gravity / rotors);
    Allocation<T, rotors> last = first_allocation(v, hover);
    AllocationCache<T, rotors> cache;
    Checked<T> checked;
    for (std::uint32_t k = 0; k < steps; ++k) {
        const Step<T> next = draw<T>(k, v);
        now.state = next.state;
        now.demand = next.demand;
        if (k % 8 == 0) set_bounds(problem, now.low = next.low, now.high = next.high);
        if (k % 8 == 2) set_effectiveness(problem, now.effectiveness = next.effectiveness);
        if (k % 8 == 4) set_wrench_bias(problem, now.bias = next.bias);
        if (k % 8 == 6) set_weights(problem, now.weights = next.weights);
        const PerRotor<T, rotors> before = last.command.thrust;
        Allocation<T, rotors> branch = last;
        allocate(settings, problem, now.state, now.demand, last, cache);
        AllocationCache<T, rotors> empty;
        allocate(settings, problem, now.state, now.demand, branch, empty);
        checked.other_bits += differs(last, branch, servos);
        checked.distance = max(checked.distance, distance_from_best(now, v, last, before));
        checked.add(last, servos);
        for (int i = 0; i < rotors; ++i) checked.at_bounds += last.active[i] != T(0);
    }
    return checked;
}

template <class T> bool holds(const char* name, const AllocationRule<T>& rule, int servos) {
    const Checked<T> checked = solve_all<T>(rule, servos);
    std::printf("%s, %d servos, %zu bytes a number: at most %.1e from the best, ", name, servos, sizeof(T),
                double(checked.distance));
    std::printf("%d of %d differ with an empty cache, hash %016llx\n", checked.other_bits, steps,
                static_cast<unsigned long long>(checked.hash));
    const bool is_best = checked.distance < T(is_double<T> ? 1e-11 : 1e-3);
    return is_best && checked.other_bits == 0 && checked.at_bounds > steps / 4;
}

template <class T> bool all_hold() {
    int held = holds<T>("fixed tilt", FixedTilt{}, rotors);
    for (const int count : {3, 5, 7}) held += holds<T>("in the window", TiltCandidates{TiltSpan::window, count}, 1);
    held += holds<T>("in the range", TiltCandidates{TiltSpan::range, 9}, 1);
    for (const int servos : {1, rotors}) held += holds<T>("jointly", JointTilt<T>{}, servos);
    return held == 7;
}

}  // namespace

int main() {
    const bool in_double = all_hold<double>(), in_single = all_hold<float>();
    return in_double && in_single ? EXIT_SUCCESS : EXIT_FAILURE;
}
