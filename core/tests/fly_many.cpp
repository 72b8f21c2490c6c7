// Many flights at once, each with its own mass, lag, wakes, noise and start, in lanes and threads: every flight gives
// the numbers it gives alone, to the last bit, also beside flights that are lost or whose numbers overflow. Exits 0 if
// so, and if two pools of threads agree, and one that is to stop does. (Products and sums are rounded one by one,
// -ffp-contract=off.)
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
    std::vector<Segment> segments = paper::flight();
    std::vector<double> mass, rotor_lag, noise, effectiveness, wrench, position;
    std::vector<double> sums = std::vector<double>(flights * n_flight_sums);
    std::vector<FlightStatus> status = std::vector<FlightStatus>(flights, FlightStatus::flying);
    std::vector<long> last_step = std::vector<long>(flights);
};

LoopSettings<double, 0> settings() {
    const auto vehicle = paper::vehicle();
    auto plant = paper::perfect_plant(vehicle);
    plant.delay = {true, 3};
    plant.interference.active = plant.rotor_momentum.active = true;
    get<ConstantWrench<double>>(plant.forces).active = true;
    auto& lag = get<RotorLag<double, rotors>>(plant.rotor_laws);
    lag.active = true;
    for (int i = 0; i < rotors; ++i) lag.up[i] = lag.down[i] = 0.02;
    auto s = paper::loop(paper::case_b(vehicle, every * paper::step), plant, every);
    get<MeasurementNoise<double>>(s.sensors) = {true, {{1e-3, 1e-2, 3e-3, 1e-2}}};
    return convert<LoopSettings<double, 0>>(s);
}

void draw(Flown& flown) {
    const auto vehicle = paper::vehicle();
    for (long k = 0; k < flights; ++k) {
        const auto number = [&](std::uint32_t which) {
            return standard_normal_pair({77, std::uint32_t(k)}, which, 0)[0];
        };
        flown.mass.push_back(vehicle.mass * (k == lost ? 6 : 1 + 0.02 * number(0)));
        const double lag = 0.02 * std::exp(0.2 * number(1)), noise = k == overflowing ? 1e160 : 1 + 0.1 * number(2);
        for (int i = 0; i < rotors; ++i) flown.rotor_lag.push_back(lag);
        for (const double deviation : {1e-3, 1e-2, 3e-3, 1e-2}) flown.noise.push_back(noise * deviation);
        for (std::uint32_t i = 0; i < rotors; ++i) flown.effectiveness.push_back(0.97 + 0.01 * number(3 + i));
        for (std::uint32_t r = 0; r < 6; ++r) flown.wrench.push_back((r < 3 ? 0.1 : 1e-3) * number(20 + r));
        const Motion<double> start = paper::start();
        for (std::uint32_t r = 0; r < 3; ++r) flown.position.push_back(start.p[int(r)] + 0.01 * number(30 + r));
    }
}

/// `width` numbers a flight in place of those of the settings.
template <class X>
Varied varied(const LoopSettings<double, 0>& s, const X& place, int width, const std::vector<double>& rows) {
    return {reinterpret_cast<const double*>(&place) - reinterpret_cast<const double*>(&s), width, rows.data()};
}

BatchParts parts_of(Flown& flown) {
    const auto s = settings();
    BatchParts parts{s,
                     paper::along(flown.segments),
                     {steps, 0.5, {3, 100}},
                     flights,
                     {},
                     {},
                     flown.sums.data(),
                     flown.status.data(),
                     flown.last_step.data()};
    const auto& lag = get<RotorLag<double, 0>>(s.plant.rotor_laws);
    parts.varied = {varied(s, s.plant.vehicle.mass, 1, flown.mass),
                    varied(s, lag.up, rotors, flown.rotor_lag),
                    varied(s, lag.down, rotors, flown.rotor_lag),
                    varied(s, get<MeasurementNoise<double>>(s.sensors).deviation, 4, flown.noise),
                    varied(s, s.plant.effectiveness, rotors, flown.effectiveness),
                    varied(s, get<ConstantWrench<double>>(s.plant.forces).constant, 6, flown.wrench),
                    varied(s, s.start.motion.p, 3, flown.position)};
    return parts;
}

/// Fly them all with some threads, as many side by side as T has lanes.
template <class T> Flown fly(int threads) {
    Flown flown;
    draw(flown);
    const BatchParts parts = parts_of(flown);
    ThreadPool pool(threads, flights, lane_count<T>, [&](long first, const std::atomic<bool>& stop) {
        batch::fly_group<T, rotors>(parts, first, stop);
    });
    while (!pool.wait(0.01)) {}
    if (pool.done() != flights) std::printf("only %ld flights are done\n", pool.done());
    return flown;
}

/// How many flights differ in a single bit of what is left of them.
int different(const Flown& one, const Flown& other) {
    int count = 0;
    for (std::size_t k = 0; k < flights; ++k)
        count += std::memcmp(&one.sums[k * n_flight_sums], &other.sums[k * n_flight_sums],
                             n_flight_sums * sizeof(double)) != 0 ||
                 one.status[k] != other.status[k] || one.last_step[k] != other.last_step[k];
    return count;
}

/// A pool that is stopped ends, and counts no flight as done that is not.
bool stops() {
    Flown flown;
    draw(flown);
    const BatchParts parts = parts_of(flown);
    ThreadPool pool(2, flights, 4, [&](long first, const std::atomic<bool>& stop) {
        batch::fly_group<Pack<double, 4>, rotors>(parts, first, stop);
    });
    pool.stop();
    while (!pool.wait(0.01)) {}
    long over = 0;
    for (const FlightStatus status : flown.status) over += status != FlightStatus::flying;
    return pool.done() <= over && over < flights;
}

}  // namespace

int main() {
    const Flown alone = fly<double>(1), together = fly<Pack<double, 4>>(1), in_threads = fly<Pack<double, 4>>(3),
                wide = fly<Pack<double, 8>>(2);
    const int lanes = different(alone, together), threads = different(together, in_threads),
              register_size = different(together, wide);
    int completed = 0;
    for (const FlightStatus status : alone.status) completed += status == FlightStatus::completed;
    std::printf("%d of %ld flights completed; %d differ in lanes, %d in threads, %d in wider registers\n", completed,
                flights, lanes, threads, register_size);
    const bool ended = alone.status[lost] == FlightStatus::lost &&
                       alone.status[overflowing] == FlightStatus::not_finite && completed == flights - 2;
    return lanes == 0 && threads == 0 && register_size == 0 && ended && stops() ? EXIT_SUCCESS : EXIT_FAILURE;
}
