// A motor turns no faster than it can, whatever it is told.
#pragma once

#include "../model/vehicle.hpp"

namespace omnimorph {

template <class T, int N> struct SpeedLimits {
    bool active = false;
    PerRotor<T, N> speed_min{}, speed_max{};  // rad/s

    SpeedLimits() = default;
    template <class S, int M> SpeedLimits(const SpeedLimits<S, M>& o, int n)
        : active(o.active), speed_min(cast<T, N>(o.speed_min, n)), speed_max(cast<T, N>(o.speed_max, n)) {}

    T apply(int i, const T& command) const { return active ? clamp(command, speed_min[i], speed_max[i]) : command; }
};

}  // namespace omnimorph
