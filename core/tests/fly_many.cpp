// Many flights at once, each with its own mass, lag, wakes, noise and start, in lanes and threads: every flight gives the numbers
// it gives alone, to the last bit, also beside flights that are lost or whose numbers overflow. Exits 0 if so, and if two crews
// agree, and one that is told to stop does. (Products and sums are rounded one by one, -ffp-contract=off.)
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "omnimorph/flight/batch.hpp"
#include "paper.hpp"

using namespace omnimorph;

namespace {

constexpr int rotors = paper::rotors, every = 4;
constexpr long flights = 27, steps = 1000, lost = 5, overflowing = 9;

/// All that a batch reads and writes.
struct Flown {
    std::vector<double> mass, rotor_lag, noise, effectiveness, wrench, centre_of_mass;
    std::vector<Motion<double>> start;
    std::vector<FlightSums> sums{flights};
    std::vector<FlightStatus> status{std::vector<FlightStatus>(flights, FlightStatus::flying)};
    std::vector<long> last_step{std::vector<long>(flights)};
};

PlantSettings<double, rotors> worn_plant(const Vehicle<double, rotors>& vehicle) {
    auto plant = paper::perfect_plant(vehicle);
    plant.delay_steps = 3;
    plant.interference = plant.rotor_momentum = plant.rotor_lag.active = plant.measurement_noise.active = true;
    for (int i = 0; i < rotors; ++i) plant.rotor_lag.keep_up[i] = plant.rotor_lag.keep_down[i] = std::exp(-plant.step / 0.02);
    plant.measurement_noise.deviation = {{1e-3, 1e-2, 3e-3, 1e-2}};
    plant.measurement_noise.filter_gain = {{1, 1, 1, 1}};
    return plant;
}

void draw(Flown& flown) {
    for (long k = 0; k < flights; ++k) {
        const auto number = [&](std::uint32_t which) { return standard_normal_pair({77, std::uint32_t(k)}, which, 0)[0]; };
        flown.mass.push_back(k == lost ? 6 : 1 + 0.02 * number(0));
        flown.rotor_lag.push_back(std::exp(0.2 * number(1)));
        flown.noise.push_back(k == overflowing ? 1e160 : 1 + 0.1 * number(2));
        for (std::uint32_t i = 0; i < rotors; ++i) flown.effectiveness.push_back(0.97 + 0.01 * number(3 + i));
        for (std::uint32_t r = 0; r < 6; ++r) flown.wrench.push_back((r < 3 ? 0.1 : 1e-3) * number(20 + r));
        for (std::uint32_t r = 0; r < 3; ++r) flown.centre_of_mass.push_back(1e-3 * number(30 + r));
        Motion<double> start = paper::start();
        start.p[0] += 0.01 * number(40);
        start.R = exp_so3(Vec3<double>{{0.05 * number(41), 0.05 * number(42), 0.05 * number(43)}});
        flown.start.push_back(start);
    }
}

BatchParts parts_of(Flown& flown, const Reference& reference) {
    const auto vehicle = paper::vehicle();
    const auto hover = paper::hovering(vehicle);
    Variation by;
    by.mass = flown.mass.data();
    by.rotor_lag = flown.rotor_lag.data();
    by.noise = flown.noise.data();
    by.effectiveness = flown.effectiveness.data();
    by.wrench = flown.wrench.data();
    by.centre_of_mass = flown.centre_of_mass.data();
    BatchParts parts{PlantSettings<double, 0>(worn_plant(vehicle)),
                     convert<Vehicle<double, 0>>(vehicle),
                     ControllerSettings<double, 0>(paper::case_b(vehicle, every * paper::step), rotors, 1),
                     &reference,
                     {cast<double, 0>(hover.thrust, rotors), hover.tilt},
                     {steps, every, 0.5, {3, 100}},
                     flights,
                     flown.start.data(),
                     by,
                     {},
                     flown.sums.data(),
                     flown.status.data(),
                     flown.last_step.data()};
    return parts;
}

/// Fly them all with a crew, as many side by side as T has lanes.
template <class T> Flown fly(int threads) {
    Flown flown;
    draw(flown);
    const Reference reference = paper::flight();
    const BatchParts parts = parts_of(flown, reference);
    ThreadPool threads(threads, flights, lane_count<T>,
              [&](long first, const std::atomic<bool>& stop) { batch::fly_group<T, rotors>(parts, first, stop); });
    while (!crew.wait(0.01)) {
    }
    if (crew.done() != flights) std::printf("only %ld flights are done\n", crew.done());
    return flown;
}

/// How many flights differ in a single bit of what is left of them.
int different(const Flown& one, const Flown& other) {
    int count = 0;
    for (std::size_t k = 0; k < flights; ++k)
        count += std::memcmp(&one.sums[k], &other.sums[k], sizeof(FlightSums)) != 0 || one.status[k] != other.status[k] || one.last_step[k] != other.last_step[k];
    return count;
}

/// A crew that is stopped ends, and tells of no flight as done that is not.
bool stops() {
    Flown flown;
    draw(flown);
    const Reference reference = paper::flight();
    const BatchParts parts = parts_of(flown, reference);
    ThreadPool threads(2, flights, 4, [&](long first, const std::atomic<bool>& stop) { batch::fly_group<Pack<double, 4>, rotors>(parts, first, stop); });
    crew.stop();
    while (!crew.wait(0.01)) {
    }
    long over = 0;
    for (const FlightStatus status : flown.status) over += status != FlightStatus::flying;
    return crew.done() <= over && over < flights;
}

}  // namespace

int main() {
    const Flown alone = fly<double>(1), together = fly<Pack<double, 4>>(1), in_threads = fly<Pack<double, 4>>(3), wide = fly<Pack<double, 8>>(2);
    const int lanes = different(alone, together), threads = different(together, in_threads), register_size = different(together, wide);
    int completed = 0;
    for (const FlightStatus status : alone.status) completed += status == FlightStatus::completed;
    std::printf("%d of %ld flights completed; %d differ in lanes, %d in threads, %d in wider registers\n", completed, flights, lanes, threads, register_size);
    const bool ended = alone.status[lost] == FlightStatus::lost && alone.status[overflowing] == FlightStatus::not_finite && completed == flights - 2;
    return lanes == 0 && threads == 0 && register_size == 0 && ended && stops() ? EXIT_SUCCESS : EXIT_FAILURE;
}
