// The state of a flight is a value: small, plain, copied to branch a flight and stored to go on with it. Exits 0 if a
// branch that begins without caches gives the same bits, with every rule, every effect and a delay, and if a stored
// state comes back as it was, but none that is cut short, of another version or flight, or impossible.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>

#include "omnimorph/flight/stored_state.hpp"
#include "omnimorph/math/pack.hpp"
#include "worn.hpp"

namespace {

using namespace omnimorph;

constexpr int n = paper::rotors;
template <class X> constexpr bool is_plain = std::is_trivially_copyable_v<X> && std::is_standard_layout_v<X>;

template <class T, int N> constexpr bool are_plain() {
    return is_plain<FlightState<T, N>> && is_plain<DelayLine<T, N>> && is_plain<AllocationCache<T, N>>;
}
static_assert(are_plain<double, 8>() && are_plain<double, 18>() && are_plain<double, 0>());
static_assert(are_plain<Pack<double, 4>, 8>() && are_plain<Pack<float, 8>, 8>() && are_plain<Pack<float, 8>, 0>());
static_assert(sizeof(FlightState<double, 8>) <= 3072);
static_assert(sizeof(FlightState<double, 18>) <= 8192 && sizeof(FlightState<double, 0>) <= 8192);

/// Every number of two records, to the last bit.
template <class X> bool is_same(const X& a, const X& b) {
    bool same = true;
    for_each_number(const_cast<X&>(a), b,
                    [&](const auto& x, const auto& y) { same = same && std::memcmp(&x, &y, sizeof(x)) == 0; });
    return same;
}

/// Half a second, and then another one twice: as it goes on, and in a flight that begins with a copy of the state.
template <class T> bool branches(const worn::Rule& rule, Integrator integrator) {
    constexpr long half = 500;
    const auto segments = paper::flight();
    const auto settings = convert<LoopSettings<T, n>>(worn::loop(rule, integrator, 4));
    const auto begin = [&] {
        return std::make_unique<Flight<T, n>>(settings, paper::along(segments), FlightLimits{2 * half, 1e9, {7, 40}},
                                              PerLane<Record, T>{});
    };
    const auto flight = begin(), branch = begin();
    flight->advance(half + 2);  // between two decisions, commands on their way
    const FlightState<T, n> state = flight->state();
    const DelayLine<T, n> line = *flight->delay_line();
    branch->restore(state, &line);
    const bool same_at_first = is_same(branch->state(), state) && is_same(*branch->delay_line(), line);
    flight->advance(half);
    branch->advance(half);
    const bool moved = !is_same(flight->state(), state);
    return same_at_first && moved && is_same(flight->state(), branch->state()) &&
           is_same(*flight->delay_line(), *branch->delay_line());
}

/// A flight to store states of.
struct Stored8 {
    FlightState<double, 0> state;
    DelayLine<double, 0> line;
    StateHeader header;

    Stored8() {
        const auto segments = paper::flight();
        const auto settings = worn::loop(worn::rules[1], Integrator::runge_kutta_4, 4);
        const auto flight = std::make_unique<Flight<double, n>>(
            settings, paper::along(segments), FlightLimits{500, 1e9, {7, 40}}, PerLane<Record, double>{});
        flight->advance(250);
        state = convert<FlightState<double, 0>>(flight->state());
        line = convert<DelayLine<double, 0>>(*flight->delay_line());
        header.n_rotors = n;
        header.n_servos = 1;
        header.has_delay_line = 1;
        header.control_every = settings.control_every;
        header.physics_step = settings.plant.step;
    }
    std::vector<unsigned char> bytes() const { return store(header, state, &line); }
};

Stored read(const std::vector<unsigned char>& bytes, const StateHeader& expected) {
    FlightState<double, 0> state{};
    DelayLine<double, 0> line{};
    return read_state(bytes, expected, state, &line);
}

/// What becomes of a state that was changed before it was stored.
template <class Change> Stored changed(const Stored8& good, Change change) {
    Stored8 other = good;
    change(other);
    return read(other.bytes(), good.header);
}

bool comes_back(const Stored8& good) {
    FlightState<double, 0> state{};
    DelayLine<double, 0> line{};
    const Stored outcome = read_state(good.bytes(), good.header, state, &line);
    return outcome == Stored::read && is_same(state, good.state) && is_same(line, good.line);
}

bool refuses_what_is_cut_short(const Stored8& good) {
    const auto bytes = good.bytes();
    for (std::size_t size = 0; size < bytes.size(); size += size < 100 ? 1 : 97) {
        const std::vector<unsigned char> some(bytes.begin(), bytes.begin() + std::ptrdiff_t(size));
        if (read(some, good.header) != Stored::broken) return false;
    }
    auto longer = bytes;
    longer.push_back(0);
    return read(longer, good.header) == Stored::broken;
}

bool refuses_another(const Stored8& good) {
    auto flipped = good.bytes();
    flipped[0] ^= 1;
    const auto another = [&](auto change) { return changed(good, change) == Stored::of_another_flight; };
    return read(flipped, good.header) == Stored::of_another_version &&
           changed(good, [](Stored8& s) { ++s.header.version; }) == Stored::of_another_version &&
           another([](Stored8& s) { s.header.n_rotors = 6; }) && another([](Stored8& s) { s.header.n_servos = 2; }) &&
           another([](Stored8& s) { s.header.control_every = 3; }) &&
           another([](Stored8& s) { s.header.physics_step = 2e-3; }) &&
           read(store(good.header, good.state, nullptr), good.header) == Stored::of_another_flight;
}

bool refuses_the_impossible(const Stored8& good) {
    const auto broken = [&](auto change) { return changed(good, change) == Stored::broken; };
    return broken([](Stored8& s) { s.state.step = -1; }) && broken([](Stored8& s) { s.state.last_step[0] = -1; }) &&
           broken([](Stored8& s) { s.state.last_step[0] = s.state.step + 1; }) &&
           broken([](Stored8& s) { s.state.status[0] = FlightStatus(6); }) &&
           broken([](Stored8& s) { s.state.status[0] = FlightStatus(-1); }) &&
           broken([](Stored8& s) { s.line.oldest = -1; }) &&
           broken([](Stored8& s) { s.line.oldest = s.line.newest + 1; }) &&
           broken([](Stored8& s) { s.line.newest = s.line.oldest + s.line.places + 1; }) &&
           broken([](Stored8& s) { s.line.oldest = s.line.newest = s.state.step + 2; });
}

bool passes(const char* name, bool passed) {
    std::printf("%s: %s\n", name, passed ? "yes" : "NO");
    return passed;
}

}  // namespace

int main() {
    std::printf("bytes of a state: %zu with 8 rotors, %zu with 18, %zu counted at run time; of a delay line: %zu\n",
                sizeof(FlightState<double, 8>), sizeof(FlightState<double, 18>), sizeof(FlightState<double, 0>),
                sizeof(DelayLine<double, 8>));
    bool well = true;
    for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::runge_kutta_4})
        for (const worn::Rule& rule : worn::rules) {
            well = passes(rule.name, branches<double>(rule, integrator)) && well;
            well = passes("in lanes", branches<Pack<float, 8>>(rule, integrator)) && well;
        }
    const Stored8 good;
    well = passes("a stored state comes back", comes_back(good)) && well;
    well = passes("one that is cut short is refused", refuses_what_is_cut_short(good)) && well;
    well = passes("one of another version or flight is refused", refuses_another(good)) && well;
    well = passes("one that cannot be is refused", refuses_the_impossible(good)) && well;
    return well ? EXIT_SUCCESS : EXIT_FAILURE;
}
