// Compiled once for each rotor count (OMNIMORPH_ROTORS; 0 counts at run time) and instruction set: see
// batch_groups.hpp.
#include "batch_groups.hpp"

namespace omnimorph::python::OMNIMORPH_SIMD {

template <> ThreadPool::FlyGroup group_flyer<OMNIMORPH_ROTORS>(const BatchParts& parts, bool single_precision) {
    constexpr int N = OMNIMORPH_ROTORS;
    if (single_precision)
        return [&parts](long first, const std::atomic<bool>& stop) {
            batch::fly_group<Pack<float, lanes<float>>, N>(parts, first, stop);
        };
    return [&parts](long first, const std::atomic<bool>& stop) {
        batch::fly_group<Pack<double, lanes<double>>, N>(parts, first, stop);
    };
}

}  // namespace omnimorph::python::OMNIMORPH_SIMD
