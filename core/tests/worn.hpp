// The paper's vehicle with every effect on, and every rule of allocation: what a program flies that leaves nothing out.
#pragma once

#include "paper.hpp"

namespace worn {

using namespace omnimorph;

inline PlantSettings<double, paper::rotors> plant(const Vehicle<double, paper::rotors>& vehicle,
                                                  Integrator integrator) {
    auto plant = paper::perfect_plant(vehicle);
    plant.integrator = integrator;
    plant.delay = {true, 3};
    plant.rotor_momentum.active = plant.interference.active = true;
    auto& limits = get<SpeedLimits<double, paper::rotors>>(plant.rotor_laws);
    auto& dead_band = get<DeadBand<double, paper::rotors>>(plant.rotor_laws);
    auto& rotor_lag = get<RotorLag<double, paper::rotors>>(plant.rotor_laws);
    auto& servo_lag = get<ServoLag<double>>(plant.servo_laws);
    auto& servo_rate_limit = get<ServoRateLimit<double>>(plant.servo_laws);
    limits.active = dead_band.active = rotor_lag.active = servo_lag.active = servo_rate_limit.active = true;
    for (int i = 0; i < paper::rotors; ++i) {
        plant.effectiveness[i] = 0.95 + 0.01 * (i % 3);
        limits.speed_min[i] = vehicle.speed_min[i];
        limits.speed_max[i] = vehicle.speed_max[i];
        dead_band.smallest[i] = 30 * 2 * paper::pi;
        rotor_lag.up[i] = 0.010;
        rotor_lag.down[i] = 0.014;
    }
    dead_band.reversal_time = 0.005;
    servo_lag.time_constant[0] = 0.02;
    servo_rate_limit.rate[0] = vehicle.rate_max[0];
    get<ConstantWrench<double>>(plant.forces) = {true, {{0.2, 0, 0.1, 0, 0.001, 0}}};
    get<SineWrench<double>>(plant.forces) = {true, {{0.1, 0.1, 0, 0, 0, 0.002}}, 3, 0};
    static const double rows[] = {0, 0, 0, 0, 0, 0, 0, 1, 0.05, 0, 0, 0, 0, 0};
    get<WrenchProfile<double>>(plant.forces) = {true, {rows, 14}};
    return plant;
}

struct Rule {
    const char* name;
    AllocationRule<double> rule;
    bool position_first = false;
};
inline const Rule rules[] = {{"thrusts at a fixed tilt", FixedTilt{}},
                             {"three candidates", TiltCandidates{TiltSpan::window, 3}},
                             {"three candidates, position first", TiltCandidates{TiltSpan::window, 3}, true},
                             {"the best in the window", TiltCandidates{TiltSpan::window, 7}},
                             {"towards the best in the range", TiltCandidates{TiltSpan::range, 13}},
                             {"thrusts and tilt jointly", JointTilt<double>{0}}};

/// The loop of Case B with noise, filters and a delay, control every so many physics steps.
inline LoopSettings<double, paper::rotors> loop(const Rule& rule, Integrator integrator, int every) {
    const auto vehicle = paper::vehicle();
    auto controller = paper::case_b(vehicle, every * paper::step);
    controller.allocation.rule = rule.rule;
    if (rule.position_first) controller.tracking.position_first = {true, 0.05, 0, 0};
    auto settings = paper::loop(controller, plant(vehicle, integrator), every);
    get<MeasurementNoise<double>>(settings.sensors) = {true, {{1e-3, 1e-2, 3e-3, 1e-2}}};
    std::get<LowPass<double>>(settings.estimator).cutoff = {{0, 0, 150, 150}};
    derive(settings);
    return settings;
}

/// Whether nothing in a record is switched off, so that a new effect cannot be left out here.
template <class X> bool is_all_on(const X& x) {
    if constexpr (fields::is_record<X>) {
        bool on = true;
        for_each_field(x, [&](const auto& f, const auto& member) {
            if constexpr (std::is_same_v<std::decay_t<decltype(member)>, bool>)
                on = on && (member || std::string("active") != f.name);
            on = on && is_all_on(member);
        });
        return on;
    } else if constexpr (fields::is_list<X>) {
        bool on = true;
        for_each(x, [&](const auto& one) { on = on && is_all_on(one); });
        return on;
    } else {
        return true;
    }
}

}  // namespace worn
