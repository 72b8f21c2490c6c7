// The headers stand alone: the paper's vehicle flies the whole of Case A, with no Python anywhere, by the paper's rule
// and by joint allocation. Exits 0 if it stays within a millimetre of its reference, every allocation proves itself,
// and no memory is asked for.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>

#include "paper.hpp"

namespace {
long allocations = 0;
}

[[gnu::noinline]] void* operator new(std::size_t size) {
    ++allocations;
    if (void* memory = std::malloc(size)) return memory;
    throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept {
    std::free(memory);
}
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept {
    std::free(memory);
}

namespace {

bool flies_well(const char* name, const omnimorph::AllocationRule<double>& rule) {
    using namespace omnimorph;
    const auto vehicle = paper::vehicle();
    const auto segments = paper::flight();
    const FlightLimits limits{45000, 2.0, {0, 0}};
    auto controller = paper::case_a(vehicle, paper::step);
    controller.allocation.rule = rule;
    const auto settings = paper::loop(controller, paper::perfect_plant(vehicle), 1);
    const auto flight = std::make_unique<Flight<double, paper::rotors>>(settings, paper::along(segments), limits,
                                                                        PerLane<Record, double>{});
    double largest_error = 0, largest_residual = 0;
    const long allocations_before = allocations;
    const auto begin = std::chrono::steady_clock::now();
    while (!flight->is_over()) {
        const Vec3<double> e = flight->desired().p - flight->state().plant.motion.p;
        largest_error = std::max(largest_error, std::sqrt(dot(e, e)));
        flight->advance(1);
        largest_residual = std::max(largest_residual, flight->state().decided.kkt_residual);
    }
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const long allocated = allocations - allocations_before;
    std::printf("%s: largest position error %.3g mm, largest KKT residual %.3g, %ld allocations, %.2f M steps/s\n",
                name, 1e3 * largest_error, largest_residual, allocated, 1e-6 * double(limits.steps) / seconds);
    return flight->status() == FlightStatus::completed && largest_error < 1e-3 && largest_residual < 1e-9 &&
           allocated == 0;
}

}  // namespace

int main() {
    const bool three = flies_well("three candidates", omnimorph::TiltCandidates{omnimorph::TiltSpan::window, 3});
    const bool joint = flies_well("thrusts and tilt jointly", omnimorph::JointTilt<double>{0});
    return three && joint ? EXIT_SUCCESS : EXIT_FAILURE;
}
