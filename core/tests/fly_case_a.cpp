// The headers stand alone: the paper's vehicle flies the first climb and descent of Case A, with no Python anywhere.
// Exits 0 if it stays within a millimetre of its reference and every allocation proves itself.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>

#include "omnimorph/rollout.hpp"

using namespace omnimorph;

namespace {

constexpr int rotors = 8;
constexpr double pi = 3.14159265358979323846;

/// Eight rotors on the vertices of a cube; thrust axes (+-s, 0, c) or (0, +-s, c) at tilt alpha.
Vehicle<double, rotors> omnimorph_vehicle() {
    Vehicle<double, rotors> v;
    const double l = 0.1062, c_f = 1.8638e-4 / (4 * pi * pi), c_tau = 2.754e-6 / (4 * pi * pi), thrust_max = 5.3587;
    const double hub[8][3] = {{1, 1, 1}, {-1, 1, 1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, -1}, {1, -1, -1}};
    const double tilted[8][2] = {{-1, 0}, {0, -1}, {1, 0}, {0, 1}, {1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    v.mass = 1.315;
    v.inertia = {{{1.16e-2, 0, 0}, {0, 1.13e-2, 0}, {0, 0, 1.13e-2}}};
    v.inertia_inverse = inverse(v.inertia);
    for (int i = 0; i < rotors; ++i) {
        v.position[i] = {{l * hub[i][0], l * hub[i][1], l * hub[i][2]}};
        v.axis[i] = Vec3<double>::zero();
        v.axis_cosine[i] = {{0, 0, 1}};
        v.axis_sine[i] = {{tilted[i][0], tilted[i][1], 0}};
        v.servo[i] = 0;
        v.spin[i] = hub[i][0] * hub[i][1] > 0 ? -1 : 1;
        v.thrust_coefficient[i] = c_f;
        v.drag_coefficient[i] = c_tau;
        v.speed_max[i] = std::sqrt(thrust_max / c_f);
        v.speed_min[i] = -v.speed_max[i];
        v.spin_inertia[i] = 0;
    }
    v.n_servos = 1;
    v.angle_min[0] = 0;
    v.angle_max[0] = 60 * pi / 180;
    v.rate_max[0] = 100 * pi / 180;
    return v;
}

ControllerSettings<double, rotors> case_a(const Vehicle<double, rotors>& v, double step) {
    ControllerSettings<double, rotors> s;
    s.gains = {{{30, 30, 30}}, {{300, 300, 300}}, {{40, 40, 40}}, {{100, 100, 100}}};
    for (int i = 0; i < rotors; ++i) {
        const double c_f = v.thrust_coefficient[i] * 4 * pi * pi;  // the paper's inputs are in Hz²
        s.weights.input[i] = 1e-8 / (c_f * c_f);
        s.weights.input_change[i] = 1e-5 / (c_f * c_f);
    }
    s.weights.acceleration = {{3e6, 3e6, 3e6, 1e3, 1e3, 1e3}};
    s.rule = AllocationRule::three_candidates;
    s.tilt_change = v.rate_max[0] * step;
    return s;
}

}  // namespace

int main() {
    const Vehicle<double, rotors> vehicle = omnimorph_vehicle();
    PlantSettings<double, rotors> plant(rotors);
    plant.vehicle = vehicle;
    plant.step = 1e-3;
    for (int i = 0; i < rotors; ++i) {
        plant.command_coefficient[i] = vehicle.thrust_coefficient[i];
        plant.effectiveness[i] = 1;
    }
    const Mat3<double> upright = Mat3<double>::identity();
    const Vec3<double> none = Vec3<double>::zero(), up{{0, 0, 1}};
    Reference reference;
    reference.segments = {{0, 3, {{0, 0, 1.2}}, {{0, 0, 0.8}}, upright, up, 0}, {3, 3, {{0, 0, 2.0}}, {{0, 0, -0.8}}, upright, up, 0}};
    Command<double, rotors> hover;
    for (int i = 0; i < rotors; ++i) hover.thrust[i] = vehicle.mass * gravity / rotors;
    hover.tilt[0] = 0;

    const FlightSettings settings{6000, 1, 2.0, {0, 0}};
    const auto flight = std::make_unique<Flight<double, rotors>>(plant, vehicle, case_a(vehicle, plant.step), reference,
                                                                 Motion<double>{{{0, 0, 1.2}}, none, upright, none}, hover, settings, Record{});
    double largest_error = 0, largest_residual = 0;
    const auto begin = std::chrono::steady_clock::now();
    while (flight->status == FlightStatus::flying) {
        const Vec3<double> e = flight->desired().p - flight->plant.motion.p;
        largest_error = std::max(largest_error, std::sqrt(dot(e, e)));
        flight->advance(1);
        largest_residual = std::max(largest_residual, flight->decided().kkt_residual);
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    std::printf("largest position error %.3g mm, largest KKT residual %.3g, %.2f M steps/s\n", 1e3 * largest_error, largest_residual,
                1e-6 * double(settings.steps) / seconds);
    const bool well = flight->status == FlightStatus::completed && largest_error < 1e-3 && largest_residual < 1e-9;
    return well ? EXIT_SUCCESS : EXIT_FAILURE;
}
