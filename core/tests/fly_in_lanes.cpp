// One text for every number type: the controller with each of its rules, position first or not, and the plant with every effect on, fly in the
// lanes of a pack as they do alone, in single precision, and with the rotors counted at run time. Exits 0 if after two
// seconds each lane is its flight alone to the last bit, which holds where products and sums are rounded one by one
// (-ffp-contract=off).
#include <cstdio>
#include <cstdlib>

#include "paper.hpp"

using namespace omnimorph;

namespace {

constexpr int every = 4, steps = 2000;
constexpr NoiseKey first_flight{7, 40};

PlantSettings<double, paper::rotors> worn_plant(const Vehicle<double, paper::rotors>& vehicle, Integrator integrator) {
    auto plant = paper::perfect_plant(vehicle);
    plant.integrator = integrator;
    plant.delay_steps = 3;
    plant.rotor_momentum = plant.interference = true;
    const double h = plant.actuator_step();
    plant.speed_limits.active = plant.dead_band.active = plant.rotor_lag.active = true;
    for (int i = 0; i < paper::rotors; ++i) {
        plant.effectiveness[i] = 0.95 + 0.01 * (i % 3);
        plant.speed_limits.speed_min[i] = vehicle.speed_min[i];
        plant.speed_limits.speed_max[i] = vehicle.speed_max[i];
        plant.dead_band.smallest[i] = 30 * 2 * paper::pi;
        plant.rotor_lag.keep_up[i] = std::exp(-h / 0.010);
        plant.rotor_lag.keep_down[i] = std::exp(-h / 0.014);
    }
    plant.dead_band.reversal_time = 0.005;
    plant.servo_lag.active = plant.servo_rate_limit.active = true;
    plant.servo_lag.keep[0] = std::exp(-h / 0.02);
    plant.servo_rate_limit.most[0] = vehicle.rate_max[0] * h;
    plant.measurement_noise.active = true;
    plant.measurement_noise.deviation = {{1e-3, 1e-2, 3e-3, 1e-2}};
    plant.measurement_noise.filter_gain = {{1, 1, 0.5, 0.5}};
    plant.disturbance.active = true;
    plant.disturbance.constant = {{0.2, 0, 0.1, 0, 0.001, 0}};
    plant.disturbance.amplitude = {{0.1, 0.1, 0, 0, 0, 0.002}};
    plant.disturbance.frequency = 3;
    return plant;
}

template <class T> Desired<T> cast_desired(const Desired<double>& d) {
    return {cast<T>(d.p), cast<T>(d.v), cast<T>(d.R), cast<T>(d.w), cast<T>(d.a), cast<T>(d.dw)};
}

struct Rule {
    const char* name;
    AllocationRule<double> rule;
    bool position_first = false;
};
constexpr Rule rules[] = {{"three candidates", TiltCandidates{TiltSpan::window, 3}},
                          {"three candidates, position first", TiltCandidates{TiltSpan::window, 3}, true},
                          {"the best in the window", TiltCandidates{TiltSpan::window, 7}},
                          {"towards the best in the range", TiltCandidates{TiltSpan::range, 13}},
                          {"thrusts and tilt jointly", JointTilt<double>{}}};

/// Two seconds of Case B in number type T, for a type with N rotors or (0) counted at run time; lane k is flight 40 + k.
template <class T, int N = paper::rotors> Motion<T> fly(const Rule& rule, Integrator integrator, std::uint32_t flight) {
    const auto vehicle = paper::vehicle();
    auto controller_settings = paper::case_b(vehicle, every * paper::step);
    controller_settings.allocation.rule = rule.rule;
    if (rule.position_first) controller_settings.position_first = {0.05, vehicle.mass, every * paper::step};
    const auto settings = worn_plant(vehicle, integrator);
    const Motion<double> start = paper::start();
    const Command<double, paper::rotors> hover = paper::hovering(vehicle);
    Command<T, N> command{cast<T, N>(hover.thrust, paper::rotors), cast<T>(hover.tilt, 1)};
    Plant<T, N> plant(PlantSettings<T, N>(settings), {cast<T>(start.p), cast<T>(start.v), cast<T>(start.R), cast<T>(start.w)}, command);
    const Vehicle<T, N> model(vehicle);
    Controller<T, N> controller(model, {controller_settings, paper::rotors, 1}, command);
    const Reference reference = paper::flight();
    auto memory = MeasurementNoise<T>::at_rest();
    for (long k = 0; k < steps; ++k) {
        if (k % every == 0) {
            const NoiseKey key{first_flight.seed, flight};
            const auto measured = plant.settings().measurement_noise.measure(plant.motion, key, std::uint32_t(k / every), memory);
            plant.send(k, controller.step(measured, cast_desired<T>(reference.at(k, double(k) * paper::step))).command);
        }
        plant.advance(k, Vec6<T>::zero());
    }
    return plant.motion;
}

template <class T> double difference(const Motion<T>& many, int index, const Motion<double>& alone) {
    double largest = 0;
    for (int r = 0; r < 3; ++r) {
        largest = std::max(largest, std::fabs(double(lane(many.p[r], index)) - alone.p[r]));
        for (int c = 0; c < 3; ++c) largest = std::max(largest, std::fabs(double(lane(many.R[r][c], index)) - alone.R[r][c]));
    }
    return largest;
}

}  // namespace

int main() {
    bool well = true;
    for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::runge_kutta_4})
        for (const Rule& rule : rules) {
            const auto four = fly<Pack<double, 4>>(rule, integrator, first_flight.flight);
            const auto counted = fly<double, 0>(rule, integrator, first_flight.flight);
            const auto single = fly<float>(rule, integrator, first_flight.flight);
            double lanes = 0, apart = 0, rounded = 0;
            for (int k = 0; k < 4; ++k) {
                const auto alone = fly<double>(rule, integrator, first_flight.flight + std::uint32_t(k));
                lanes = std::max(lanes, difference(four, k, alone));
                if (k > 0) apart = std::max(apart, difference(four, 0, alone));
                if (k > 0) continue;
                lanes = std::max(lanes, difference(counted, 0, alone));
                rounded = difference(single, 0, alone);
            }
            std::printf("%s: lanes and flights alone differ by %.2g, flights from each other by %.2g, single precision is off by %.2g\n", rule.name, lanes,
                        apart, rounded);
            well = well && lanes == 0 && apart > 1e-6 && rounded < 1e-4;
        }
    return well ? EXIT_SUCCESS : EXIT_FAILURE;
}
