// One text for every number type: the controller with each of its rules, position first or not, and the plant with
// every effect on, fly in the lanes of a pack as they do alone, in single precision, and with the rotors counted at run
// time. Exits 0 if after two seconds each lane is its flight alone to the last bit, which holds where products and sums
// are rounded one by one (-ffp-contract=off).
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
const Rule rules[] = {{"three candidates", TiltCandidates{TiltSpan::window, 3}},
                      {"three candidates, position first", TiltCandidates{TiltSpan::window, 3}, true},
                      {"the best in the window", TiltCandidates{TiltSpan::window, 7}},
                      {"towards the best in the range", TiltCandidates{TiltSpan::range, 13}},
                      {"thrusts and tilt jointly", JointTilt<double>{0}}};

/// Two seconds of Case B in number type T, for a type with N rotors or (0) counted at run time; lane k is flight 40 +
/// k.
template <class T, int N = paper::rotors> Motion<T> fly(const Rule& rule, Integrator integrator, std::uint32_t number) {
    const auto vehicle = paper::vehicle();
    auto controller = paper::case_b(vehicle, every * paper::step);
    controller.allocation.rule = rule.rule;
    if (rule.position_first) controller.tracking.position_first = {true, 0.05, 0, 0};
    auto settings = paper::loop(controller, worn_plant(vehicle, integrator), every);
    get<MeasurementNoise<double>>(settings.sensors) = {true, {{1e-3, 1e-2, 3e-3, 1e-2}}};
    std::get<LowPass<double>>(settings.estimator).cutoff = {{0, 0, 150, 150}};
    derive(settings);
    const auto segments = paper::flight();
    const auto flight =
        std::make_unique<Flight<T, N>>(convert<LoopSettings<T, N>>(settings), paper::along(segments),
                                       FlightLimits{steps, 1e9, {first_flight.seed, number}}, PerLane<Record, T>{});
    flight->advance(steps);
    return flight->state().plant.motion;
}

template <class T> double difference(const Motion<T>& many, int index, const Motion<double>& alone) {
    double largest = 0;
    for (int r = 0; r < 3; ++r) {
        largest = std::max(largest, std::fabs(double(lane(many.p[r], index)) - alone.p[r]));
        for (int c = 0; c < 3; ++c)
            largest = std::max(largest, std::fabs(double(lane(many.R[r][c], index)) - alone.R[r][c]));
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
            std::printf(
                "%s: lanes and flights alone differ by %.2g, flights from each other by %.2g, single precision is off "
                "by %.2g\n",
                rule.name, lanes, apart, rounded);
            well = well && lanes == 0 && apart > 1e-6 && rounded < 1e-4;
        }
    return well ? EXIT_SUCCESS : EXIT_FAILURE;
}
