// How a batch flies one group of vehicles, behind one face for every rotor count; each count is compiled in a file of
// its own, and all of them once for each instruction set (OMNIMORPH_SIMD names it), in a module of its own.
#pragma once

#include "omnimorph/flight/batch.hpp"

namespace omnimorph::python::OMNIMORPH_SIMD {

inline constexpr int register_bytes = OMNIMORPH_REGISTER_BYTES;
template <class S> inline constexpr int lanes = register_bytes / static_cast<int>(sizeof(S));

/// What flies a group of `parts`, in single or double precision; `parts` must outlive it.
template <int N> ThreadPool::FlyGroup group_flyer(const BatchParts& parts, bool single_precision);

}  // namespace omnimorph::python::OMNIMORPH_SIMD
