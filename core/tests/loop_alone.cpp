// The loop asks for nothing: with every rule of allocation, every effect, noise, filters and a delay it flies and is
// recorded without exceptions and run-time types (-fno-exceptions -fno-rtti), and memory that it asked for would end
// the program.
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>

#include "worn.hpp"

#if defined(__cpp_exceptions) || defined(__cpp_rtti)
#error "to be compiled with -fno-exceptions -fno-rtti"
#endif

namespace {
bool is_poisoned = false;
}

[[gnu::noinline]] void* operator new(std::size_t size) {
    if (is_poisoned) std::fputs("memory was asked for in flight\n", stderr);
    void* memory = is_poisoned ? nullptr : std::malloc(size);
    if (memory == nullptr) std::abort();
    return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace {

using namespace omnimorph;

constexpr long steps = 1000;

/// Arrays for the columns of a flight of eight rotors, and at most nine numbers in a column.
struct Arrays {
    std::vector<double> numbers = std::vector<double>(n_columns * 9 * (steps + 1));

    Record record() {
        Record record;
        for (int c = 0; c < n_columns; ++c) record.column[c] = &numbers[std::size_t(c * 9 * (steps + 1))];
        return record;
    }
};

template <int N> bool flies(const worn::Rule& rule, Integrator integrator) {
    Arrays arrays;
    const auto segments = paper::flight();
    const auto settings = convert<LoopSettings<double, N>>(worn::loop(rule, integrator, 2));
    const auto flight = std::make_unique<Flight<double, N>>(
        settings, paper::along(segments), FlightLimits{steps, 1, {1, 0}}, PerLane<Record, double>{{arrays.record()}});
    is_poisoned = true;
    flight->advance(steps + 1);
    is_poisoned = false;
    const Vec3<double>& p = flight->state().plant.motion.p;
    std::printf("%s: %s at %a %a %a m\n", rule.name, flight->status() == FlightStatus::completed ? "completed" : "LOST",
                p[0], p[1], p[2]);
    return flight->status() == FlightStatus::completed;
}

}  // namespace

int main() {
    const auto settings = worn::loop(worn::rules[1], Integrator::semi_implicit_euler, 2);
    bool well = worn::is_all_on(settings.plant) && settings.plant.delay.steps > 0 && worn::is_all_on(settings.sensors);
    for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::runge_kutta_4})
        for (const worn::Rule& rule : worn::rules) {
            well = flies<paper::rotors>(rule, integrator) && well;
            well = flies<0>(rule, integrator) && well;
        }
    return well ? EXIT_SUCCESS : EXIT_FAILURE;
}
