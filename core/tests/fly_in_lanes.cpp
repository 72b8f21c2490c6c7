// One text for every number type: the controller with each of its rules, position first or not, and the plant with
// every effect on, fly in the lanes of a pack as they do alone, in single precision, and with the rotors counted at run
// time. Exits 0 if after two seconds each lane is its flight alone to the last bit, which holds where products and sums
// are rounded one by one (-ffp-contract=off).
#include <cstdio>
#include <cstdlib>

#include "worn.hpp"

using namespace omnimorph;

namespace {

constexpr int every = 4, steps = 2000;
constexpr NoiseKey first_flight{7, 40};

/// Two seconds of Case B in number type T, for a type with N rotors or (0) counted at run time; lane k is flight
/// 40 + k.
template <class T, int N = paper::rotors>
Motion<T> fly(const worn::Rule& rule, Integrator integrator, std::uint32_t number) {
    const auto settings = worn::loop(rule, integrator, every);
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
        for (const worn::Rule& rule : worn::rules) {
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
