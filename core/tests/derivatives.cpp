// Derivatives through the headers: wrench map, tracking, allocation at fixed tilts (with no bound active, and with
// some), the plant by both of its integrators, and the whole loop, in dual numbers. Exits 0 if every derivative is the
// one of finite differences, and every value the one of doubles, to the last bit.
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <vector>

#include "dual.hpp"
#include "paper.hpp"

namespace {

using namespace omnimorph;
using dual::Dual;
constexpr int n = paper::rotors;

double value_of(const Dual& x) {
    return x.value;
}

/// Compare the outputs of f(s) in dual numbers at s = 0 with those in doubles around it (differences of fourth order).
template <class F> bool agrees(const char* name, F f, double h) {
    const std::vector<Dual> in_duals = f(Dual(0, 1));
    const std::vector<double> here = f(0.0), plus = f(h), minus = f(-h), plus_2 = f(2 * h), minus_2 = f(-2 * h);
    double largest = 0, error = 0;
    bool same_values = true, moves = false;
    for (std::size_t k = 0; k < here.size(); ++k) largest = std::fmax(largest, std::fabs(in_duals[k].derivative));
    for (std::size_t k = 0; k < here.size(); ++k) {
        const double difference = (8 * (plus[k] - minus[k]) - (plus_2[k] - minus_2[k])) / (12 * h);
        const double derivative = in_duals[k].derivative;
        const double scale = std::fmax(std::fabs(derivative), 1e-3 * largest);
        error = std::fmax(error, std::fabs(derivative - difference) / scale);
        same_values = same_values && value_of(in_duals[k]) == here[k];
        moves = moves || derivative != 0;
    }
    std::printf("%s: %zu outputs, largest relative error %.2g, values %s\n", name, here.size(), error,
                same_values ? "the same" : "DIFFER");
    return error < 1e-6 && same_values && moves;
}

template <class T, class Array> void append(std::vector<T>& out, const Array& x, int count) {
    for (int k = 0; k < count; ++k) out.push_back(x[k]);
}
template <class T> void append(std::vector<T>& out, const Motion<T>& x) {
    append(out, x.p, 3);
    append(out, x.v, 3);
    for (int r = 0; r < 3; ++r) append(out, x.R[r], 3);
    append(out, x.w, 3);
}

/// A motion off hover, and in every part of it a function of s.
template <class T> Motion<T> motion_at(const T& s) {
    const Vec3<T> turn{{T(0.1) + s, T(-0.2), T(0.05) - T(2) * s}};
    return {{{T(0.01) + s, T(0.02), T(1.18) - s}},
            {{T(0.1), T(-0.05) + s, T(0.02)}},
            exp_so3(turn),
            {{T(0.2) + s, T(-0.1), T(0.3) * s}}};
}

template <class T> Vehicle<T, n> vehicle_at(const T& s) {
    auto vehicle = convert<Vehicle<T, n>>(paper::vehicle());
    for (int i = 0; i < n; ++i) vehicle.position[i][0] *= T(1) + s;
    vehicle.mass *= T(1) + s;
    vehicle.inertia[1][1] *= T(1) + s;
    derive(vehicle);
    return vehicle;
}

struct WrenchOfRotors {
    template <class T> std::vector<T> operator()(const T& s) const {
        PerRotor<T, n> thrust, unit;
        for (int i = 0; i < n; ++i) {
            thrust[i] = T(1.0 + 0.1 * i) + T(i) * s;
            unit[i] = T(1);
        }
        PerServo<T> tilt{};
        tilt[0] = T(0.4) + s;
        std::vector<T> out;
        append(out, wrench(thrust_wrench_map(vehicle_at(s), unit).at(trigonometry_of(tilt, 1)), thrust, n), 6);
        return out;
    }
};

template <class T> Desired<T> desired_at(const T& s) {
    const Vec3<T> turn{{T(0.3), T(0.1) * s, T(0.2)}};
    const Vec3<T> v{{T(0.1), s, T(0)}}, w{{T(0.2), T(0.1), s}}, a{{T(2) + s, T(0.5), T(-0.3)}}, dw{{T(0.5), s, T(0.1)}};
    return {{{T(0), T(0), T(1.2)}}, v, exp_so3(turn), w, a, dw};
}

template <class T> TrackingGains<T> gains() {
    return convert<TrackingGains<T>>(paper::case_a(paper::vehicle(), paper::step).tracking.gains);
}

struct Tracking {
    double lateral_force;  // less than none: the attitude does not give way

    template <class T> std::vector<T> operator()(const T& s) const {
        TrackingSettings<T> settings{gains<T>(), {}};
        settings.position_first = {lateral_force >= 0, T(lateral_force), T(1.315), T(paper::step)};
        TrackingState<T> state;
        std::vector<T> out;
        for (int k = 0; k < 2; ++k) {  // the second time with a state
            const T moved = s * T(1 + k);
            append(out, track(settings, motion_at(moved), desired_at(moved), state).acceleration, 6);
        }
        return out;
    }
};

struct FixedTiltAllocation {
    double up;       // demanded acceleration, m/s²
    bool at_bounds;  // whether that is too much for some rotors

    template <class T> std::vector<T> operator()(const T& s) const {
        const auto settings = convert<AllocationSettings<T, n>>(paper::case_a(paper::vehicle(), 1e-3).allocation);
        const auto vehicle = vehicle_at(s);
        const auto problem = allocation_problem(vehicle, settings.weights);
        auto start = convert<Command<T, n>>(paper::hovering(paper::vehicle()));
        start.tilt[0] = T(0.3) + s;
        Allocation<T, n> answer = first_allocation(vehicle, start);
        AllocationCache<T, n> cache;
        const Demand<T> demand{{{T(0.5) + s, T(0.2), T(up) + T(3) * s, T(1), T(-1), T(2) * s}}};
        std::vector<T> out;
        for (int k = 0; k < 2; ++k) {  // the second time from the answer, with a cache
            allocate(FixedTilt{}, problem, settings.tilt_change, motion_at(s), demand, answer, cache);
            append(out, answer.command.thrust, n);
            append(out, answer.wrench_asked, 6);
            out.push_back(answer.cost);
        }
        int active = 0;
        for (int i = 0; i < n; ++i) active += answer.active[i] == T(0) ? 0 : 1;
        return (active > 0) == at_bounds && active < n ? out : std::vector<T>{};
    }
};

/// A plant with every effect that has a derivative everywhere.
PlantSettings<double, n> late_plant(Integrator integrator) {
    PlantSettings<double, n> s = paper::perfect_plant(paper::vehicle());
    s.integrator = integrator;
    s.rotor_momentum.active = s.interference.active = true;
    auto& rotors = get<RotorLag<double, n>>(s.rotor_laws);
    auto& servos = get<ServoLag<double>>(s.servo_laws);
    auto& push = get<SineWrench<double>>(s.forces);
    rotors.active = servos.active = push.active = true;
    for (int i = 0; i < n; ++i) {
        rotors.up[i] = 0.03;
        rotors.down[i] = 0.05;
    }
    servos.time_constant[0] = 0.1;
    push.amplitude = {{0.1, 0.2, 0.3, 0.01, 0.02, 0.03}};
    push.frequency = 3;
    derive(s);
    return s;
}

struct PlantSteps {
    Integrator integrator;

    template <class T> std::vector<T> operator()(const T& s) const {
        auto settings = convert<PlantSettings<T, n>>(late_plant(integrator));
        settings.vehicle = vehicle_at(s);
        const Plant<T, n> plant(settings);
        auto command = convert<Command<T, n>>(paper::hovering(paper::vehicle()));
        command.tilt[0] = T(0.2) + s;
        PlantState<T, n> state = plant_at(plant, motion_at(s), command);
        for (int i = 0; i < n; ++i)
            command.thrust[i] *= T(0.85 + 0.1 * i) + s;  // none as it was, where up turns into down
        command.tilt[0] += T(0.2);
        for (long step = 0; step < 100; ++step)
            advance(plant, command, step, Vec6<T>{{s, T(0), T(0), T(0), s, T(0)}}, state);
        std::vector<T> out;
        append(out, state.motion);
        append(out, state.actuators.speed, n);
        append(out, state.actuators.tilt, 1);
        append(out, state.load.wrench, 6);
        return out;
    }
};

struct ClosedLoop {
    template <class T> std::vector<T> operator()(const T& s) const {
        auto controller = paper::case_a(paper::vehicle(), paper::step);
        controller.allocation.rule = FixedTilt{};
        auto settings = convert<LoopSettings<T, n>>(paper::loop(controller, paper::perfect_plant(paper::vehicle()), 1));
        settings.start.motion.p[0] += s;
        settings.start.motion.w[2] += s;
        settings.start.command.tilt[0] = T(0.3);
        const Loop<T, n> loop(settings, 100, {0, 0});
        FlightState<T, n> x = state_at(loop, settings.start);
        StepMemory<T, n> memory;
        const Vec3<T> still = Vec3<T>::zero();
        const Desired<T> hover{{{T(0), T(0), T(1.2)}}, still, Mat3<T>::identity(), still, still, still};
        for (int k = 0; k < 100; ++k) step(loop, hover, Vec6<T>::zero(), x, memory);
        std::vector<T> out;
        append(out, x.plant.motion);
        append(out, x.decided.command.thrust, n);
        return out;
    }
};

}  // namespace

int main() {
    bool good = agrees("wrench map", WrenchOfRotors{}, 1e-3);
    good &= agrees("tracking", Tracking{-1}, 1e-3);
    good &= agrees("tracking, position first", Tracking{1}, 1e-5);
    good &= agrees("allocation, no bound active", FixedTiltAllocation{1, false}, 3e-4);
    good &= agrees("allocation, some bounds active", FixedTiltAllocation{12, true}, 1e-3);
    good &= agrees("plant, semi-implicit Euler", PlantSteps{Integrator::semi_implicit_euler}, 1e-4);
    good &= agrees("plant, Runge-Kutta", PlantSteps{Integrator::runge_kutta_4}, 1e-4);
    good &= agrees("closed loop", ClosedLoop{}, 3e-4);
    return good ? EXIT_SUCCESS : EXIT_FAILURE;
}
