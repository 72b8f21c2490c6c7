// The paper's vehicle, its two cases and the 45 s flight, written out in C++ (the TOML files of the package say the
// same).
#pragma once

#include <vector>

#include "omnimorph/flight/flight.hpp"

namespace paper {

using namespace omnimorph;

inline constexpr int rotors = 8;
inline constexpr double pi = 3.14159265358979323846;
inline constexpr double step = 1e-3;

/// Eight rotors on the vertices of a cube; thrust axes (+-s, 0, c) or (0, +-s, c) at tilt alpha.
inline Vehicle<double, rotors> vehicle() {
    Vehicle<double, rotors> v;
    const double l = 0.1062, c_f = 1.8638e-4 / (4 * pi * pi), c_tau = 2.754e-6 / (4 * pi * pi), thrust_max = 5.3587;
    const double hub[8][3] = {{1, 1, 1},  {-1, 1, 1},  {-1, -1, 1},  {1, -1, 1},
                              {1, 1, -1}, {-1, 1, -1}, {-1, -1, -1}, {1, -1, -1}};
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
        v.spin_inertia[i] = 3.41e-5;
    }
    v.n_servos = 1;
    v.angle_min[0] = 0;
    v.angle_max[0] = 60 * pi / 180;
    v.rate_max[0] = 100 * pi / 180;
    return v;
}

inline ControllerSettings<double, rotors> case_a(const Vehicle<double, rotors>& v, double control_period) {
    ControllerSettings<double, rotors> s{};
    s.model = v;
    s.period = control_period;
    s.tracking.gains = {{{30, 30, 30}}, {{300, 300, 300}}, {{40, 40, 40}}, {{100, 100, 100}}};
    for (int i = 0; i < rotors; ++i) {
        const double c_f = v.thrust_coefficient[i] * 4 * pi * pi;  // the paper's inputs are in Hz²
        s.allocation.weights.input[i] = 1e-8 / (c_f * c_f);
        s.allocation.weights.input_change[i] = 1e-5 / (c_f * c_f);
    }
    s.allocation.weights.acceleration = {{3e6, 3e6, 3e6, 1e3, 1e3, 1e3}};
    s.allocation.rule = TiltCandidates{TiltSpan::window, 3};
    s.allocation.tilt_change[0] = v.rate_max[0] * control_period;
    return s;
}

/// Effort counts more, so that the cost decides on the tilt clearly.
inline ControllerSettings<double, rotors> case_b(const Vehicle<double, rotors>& v, double control_period) {
    ControllerSettings<double, rotors> s = case_a(v, control_period);
    for (int i = 0; i < rotors; ++i) s.allocation.weights.input[i] *= 1e3;
    s.allocation.weights.acceleration = {{3e4, 3e4, 3e4, 10, 10, 10}};
    return s;
}

inline PlantSettings<double, rotors> perfect_plant(const Vehicle<double, rotors>& v) {
    PlantSettings<double, rotors> plant{};
    plant.vehicle = v;
    plant.step = step;
    for (int i = 0; i < rotors; ++i) {
        plant.command_coefficient[i] = v.thrust_coefficient[i];
        plant.effectiveness[i] = 1;
    }
    return plant;
}

/// Climb, descend, sideways and back, the same at 30 degrees of roll, a full turn on the spot, climb, hover.
inline std::vector<Segment> flight() {
    struct Leg {
        double duration;
        Vec3<double> move;
        double roll;
    };
    const Leg legs[] = {{3, {{0, 0, 0.8}}, 0},  {3, {{0, 0, -0.8}}, 0},    {3, {{0, 0.5, 0}}, 0},
                        {3, {{0, -0.5, 0}}, 0}, {2, {{0, 0, 0}}, pi / 6},  {3, {{0.5, 0, 0}}, 0},
                        {3, {{-0.5, 0, 0}}, 0}, {2, {{0, 0, 0}}, -pi / 6}, {18, {{0, 0, 0}}, 2 * pi},
                        {3, {{0, 0, 0.4}}, 0},  {2, {{0, 0, 0}}, 0}};
    std::vector<Segment> segments;
    double time = 0;
    Vec3<double> p{{0, 0, 1.2}};
    Mat3<double> R = Mat3<double>::identity();
    const Vec3<double> roll_axis{{1, 0, 0}};
    for (const Leg& leg : legs) {
        segments.push_back({time, leg.duration, p, leg.move, R, roll_axis, leg.roll});
        time += leg.duration;
        p = p + leg.move;
        R = exp_so3(leg.roll * roll_axis) * R;
    }
    return segments;
}

inline Motion<double> start() {
    return {{{0, 0, 1.2}}, Vec3<double>::zero(), Mat3<double>::identity(), Vec3<double>::zero()};
}

inline Command<double, rotors> hovering(const Vehicle<double, rotors>& v) {
    Command<double, rotors> hover;
    for (int i = 0; i < rotors; ++i) hover.thrust[i] = v.mass * gravity / rotors;
    hover.tilt[0] = 0;
    return hover;
}

/// The whole loop; control every so many physics steps, in a plant of its own.
inline LoopSettings<double, rotors> loop(const ControllerSettings<double, rotors>& controller,
                                         const PlantSettings<double, rotors>& plant, int every) {
    LoopSettings<double, rotors> s{};
    s.controller = controller;
    s.plant = plant;
    s.start = {start(), hovering(controller.model)};
    s.control_every = every;
    s.control_period = every * step;
    derive(s);
    return s;
}

inline Reference along(const std::vector<Segment>& segments) {
    return {segments.data(), static_cast<long>(segments.size()), nullptr, 0};
}

}  // namespace paper
